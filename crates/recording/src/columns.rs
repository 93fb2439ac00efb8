//! The columns of a recording: name, type, unit and meaning, once.

use arrow_schema::DataType;

/// One column.
pub(super) struct Column {
    pub name: &'static str,
    pub kind: DataType,
    /// As `s`; `1` of what is counted, `none` of words and bits.
    pub unit: &'static str,
    pub description: &'static str,
}

pub(super) const fn column(
    name: &'static str,
    kind: DataType,
    unit: &'static str,
    description: &'static str,
) -> Column {
    Column { name, kind, unit, description }
}

/// All columns, in their order.
pub(super) static COLUMNS: [Column; 17] = [
    column("group_number", DataType::UInt32, "1", "The group's number; a group has a row for each axis."),
    column(
        "t_s",
        DataType::Float64,
        "s",
        "The acquisition's time at the group's end, from the recording's begin: what passed while nothing was acquired, as a soak, is not in it.",
    ),
    column("phase", DataType::Utf8, "none", "What the chamber was doing: soak, heating, cooling or supply."),
    column("axis", DataType::Utf8, "none", "The axis: x or y."),
    column("n", DataType::UInt32, "1", "Samples in the group."),
    column("temperature_sum", DataType::UInt64, "count", "Sum of the samples' temperatures."),
    column("temperature_sq_sum", DataType::UInt64, "count^2", "Sum of the squares of the samples' temperatures."),
    column("zro_sum", DataType::UInt64, "count", "Sum of the samples' readings."),
    column("zro_sq_sum", DataType::UInt64, "count^2", "Sum of the squares of the samples' readings."),
    column("temperature_counts", DataType::Float64, "count", "The group's mean temperature, as the converter read it."),
    column("zro_counts", DataType::Float64, "count", "The group's mean zero-rate output, not corrected in numbers."),
    column("corrected_counts", DataType::Float64, "count", "The same after the device's digital correction."),
    column("tap", DataType::UInt16, "tap", "The wiper's position during the group, 0 to 1023."),
    column("compensation_mode", DataType::Utf8, "none", "What compensated the axis: off, trim, digital or hybrid."),
    column("chamber_set_c", DataType::Float64, "°C", "The chamber's set point; NaN where it is not known."),
    column("chamber_c", DataType::Float64, "°C", "The chamber's air; NaN where it is not known."),
    column(
        "status_bits",
        DataType::UInt16,
        "none",
        "What the device said of the group: the bits are in zerorate.status_bits.",
    ),
];

/// The columns whose names were others in schema version 1: words that SQL and pandas keep for themselves.
const RENAMED: [(&str, &str); 3] = [("group_number", "group"), ("compensation_mode", "mode"), ("status_bits", "flags")];

/// What a column was called in schema version 1, where it had another name.
#[must_use]
pub fn name_in_version_1(name: &str) -> Option<&'static str> {
    RENAMED.into_iter().find(|(now, _)| *now == name).map(|(_, earlier)| earlier)
}
