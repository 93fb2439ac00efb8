//! A calibration for other programs: the static cubics as JSON, the curves as a table.

use serde::Serialize;
use zerorate_core::drift::{Coverage, Drift};

use super::sensors::sensors;
use super::{ExportError, ExportOptions, Exported, ExportedSensor, Format, one_line, to_know, to_know_of_cubics};
use zerorate_cal::calibration::{AxisCalibration, CREATED_BY, Calibration, Origin};
use zerorate_cal::units::TemperatureUnit;

/// Steps of the table over the range.
const STEPS: u32 = 200;

/// The schema of the JSON.
const SCHEMA: u32 = 1;

#[derive(Serialize)]
struct Form<'a> {
    schema: u32,
    created_by: &'static str,
    unit_serial: &'a Option<String>,
    sources: &'a [Origin],
    /// What the coefficients are: bias = sum of coefficients[k] (T - reference)^k, T clamped to the range.
    formula: &'static str,
    units: [&'static str; 3],
    /// What to know, a sentence each.
    notes: &'a [String],
    sensors: &'a [ExportedSensor],
}

pub(super) fn write_json(calibration: &Calibration, options: &ExportOptions) -> Result<Exported, ExportError> {
    let sensors = sensors(calibration, options, Format::Json)?;
    let notes = to_know_of_cubics(calibration, &sensors);
    let form = Form {
        schema: SCHEMA,
        created_by: CREATED_BY,
        unit_serial: &calibration.unit_serial,
        sources: &calibration.sources,
        formula: "bias = c0 + c1 d + c2 d^2 + c3 d^3, d = clamp(T, range) - reference; corrected = reading - bias",
        units: ["T in C", "gyro in rad/s", "accelerometer in m/s^2"],
        notes: &notes,
        sensors: &sensors,
    };
    // Nothing in the form can fail to be written: its keys are texts and its numbers are a calibration's, which are finite.
    let text = serde_json::to_string_pretty(&form).unwrap_or_default() + "\n";
    Ok(Exported { text, sensors, notes })
}

/// What a column of the table is.
fn what(axis: &AxisCalibration) -> &'static str {
    match axis.fit.model.history {
        None => "bias",
        Some(_) if axis.fit.cubic_between_ways().is_some() => "bias by the cubic without its history",
        Some(_) => "bias by the curve without its history",
    }
}

/// The curves without a history at equal steps of temperature over all that was measured; a cell is empty where an axis was not.
pub(super) fn write_csv(calibration: &Calibration) -> Exported {
    let axes = || calibration.axes.values();
    let least = axes().map(|axis| axis.fit.measured.min()).fold(f64::INFINITY, f64::min);
    let most = axes().map(|axis| axis.fit.measured.max()).fold(f64::NEG_INFINITY, f64::max);
    let unit = match calibration.temperature_unit {
        TemperatureUnit::C => "temperature_c",
        TemperatureUnit::Counts => "temperature_counts",
    };
    let mut rows: Vec<Vec<String>> = vec![
        std::iter::once(unit.to_owned())
            .chain(calibration.axes.iter().map(|(name, axis)| format!("{name} {}, {}", what(axis), axis.rate_unit)))
            .collect(),
    ];
    let drifts: Vec<Drift> = axes().map(AxisCalibration::measured_drift).collect();
    for step in 0..=STEPS {
        // The last is the end itself, not a rounding beyond it.
        let temperature = (least + (most - least) * f64::from(step) / f64::from(STEPS)).min(most);
        let cell = |drift: &Drift| {
            let inside = drift.valid.coverage(temperature) == Coverage::Inside;
            if inside { drift.evaluate(temperature).0.to_string() } else { String::new() }
        };
        rows.push(std::iter::once(temperature.to_string()).chain(drifts.iter().map(cell)).collect());
    }
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        // A vector takes every record, and all have one length.
        let _ = writer.write_record(&row);
    }
    let text = writer.into_inner().ok().and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default();
    let no_gain = |(name, axis): (&String, &AxisCalibration)| match axis.fit.cubic_between_ways() {
        Some(_) => axis.no_gain_of_cubic(name, calibration.told_in),
        None => axis.no_gain(name, calibration.told_in),
    };
    let mut notes = to_know(calibration, calibration.axes.iter().filter_map(no_gain));
    let histories = calibration.axes.iter().filter(|(_, axis)| axis.fit.model.history.is_some());
    let names: Vec<String> = histories.map(|(name, _)| one_line(name)).collect();
    if !names.is_empty() {
        notes.push(format!(
            "the history (plays, lags) of {} is not in the table: beside plays a column is the cubic that goes between both ways, beside \
             lags alone the curve, and the calibration takes off more",
            names.join(", ")
        ));
    }
    Exported { text, sensors: Vec::new(), notes }
}
