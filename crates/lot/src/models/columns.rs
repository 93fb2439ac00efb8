//! The columns of the rows, each named once.

use std::collections::HashMap;
use std::sync::Arc;

use arrow_array::builder::{Float64Builder, ListBuilder};
use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{Array, ArrayRef, Float64Array, RecordBatch, StringArray};
use arrow_schema::{ArrowError, DataType, Field, Schema};
use zerorate_cal::recording::{COLUMNS_KEY, columns_told, described};

use super::{ModelRow, SCHEMA_VERSION};

/// Where the schema's version stands in the file's metadata.
pub(super) const VERSION_KEY: &str = "zerorate.models_version";

/// Where what is in no row stands there.
pub(super) const BESIDE_KEY: &str = "zerorate.beside";

/// A column of texts.
struct Text {
    name: &'static str,
    description: &'static str,
    of: fn(&ModelRow) -> &str,
    of_mut: fn(&mut ModelRow) -> &mut String,
}

/// A column of numbers.
pub(super) struct Number {
    name: &'static str,
    unit: &'static str,
    description: &'static str,
    of: fn(&ModelRow) -> f64,
    pub of_mut: fn(&mut ModelRow) -> &mut f64,
}

/// Each column once: what it says, its name, and of a number its unit.
macro_rules! texts {
    ($(#[doc = $description:literal] $name:ident;)+) => {
        [$(Text {
            name: stringify!($name),
            description: $description.trim_ascii(),
            of: |row| &row.$name,
            of_mut: |row| &mut row.$name,
        }),+]
    };
}

macro_rules! numbers {
    ($(#[doc = $description:literal] $name:ident in $unit:literal;)+) => {
        [$(Number {
            name: stringify!($name),
            unit: $unit,
            description: $description.trim_ascii(),
            of: |row| row.$name,
            of_mut: |row| &mut row.$name,
        }),+]
    };
}

static TEXTS: [Text; 17] = texts! {
    /// The unit's serial, as its recording has it.
    unit_serial;
    /// The axis: x or y.
    axis;
    /// The station that recorded it.
    station;
    /// Who recorded it.
    operator;
    /// When it was recorded, RFC 3339.
    recorded_at;
    /// The procedure.
    procedure;
    /// The device's firmware.
    firmware;
    /// The dataset, as it was given.
    dataset;
    /// The recording, from the dataset's root.
    file;
    /// When the recording was written, RFC 3339.
    file_modified;
    /// What its readings are known by: SHA-256 of the ramps' means; empty without a ramp.
    readings_sha256;
    /// The model asked for.
    model_asked;
    /// The model fitted; empty without a fit.
    model;
    /// The unit's verdict: good, warning or rejected.
    verdict;
    /// Why, as JSON.
    reasons;
    /// The axis of the calibration file, as JSON; empty without a fit.
    calibration;
    /// The program that fitted it.
    created_by;
};

pub(super) static NUMBERS: [Number; 16] = numbers! {
    /// The recording's size.
    file_bytes in "byte";
    /// The coldest that was fitted.
    temperature_min in "count";
    /// The hottest that was fitted.
    temperature_max in "count";
    /// Centre of the scaled temperature.
    temperature_centre in "count";
    /// Half span of the scaled temperature.
    temperature_half_span in "count";
    /// Groups fitted.
    groups in "1";
    /// Samples in them.
    samples in "1";
    /// Residual of the fit of everything, rms.
    in_sample_rms in "count";
    /// Residual of the fit of everything, peak to peak.
    in_sample_pp in "count";
    /// Residual of eight folds, each predicted by the fit of the others, rms.
    held_out_rms in "count";
    /// The same, peak to peak.
    held_out_pp in "count";
    /// The drift over the range fitted, peak to peak.
    drift_pp in "count";
    /// The reading in the middle of the range.
    reading_mid in "count";
    /// The set-up's limit on what mode trim leaves, peak to peak.
    limit_trim_residual_pp in "count";
    /// The set-up's limit on what mode hybrid leaves, in floors.
    limit_hybrid_residual_floors in "1";
    /// The set-up's limit on the mean's distance from the centre.
    limit_mean_offset in "count";
};

const COEFFICIENTS: &str = "coefficients";

/// Columns that came later: in rows of before they are empty.
const LATER: [&str; 1] = ["readings_sha256"];

/// Rows as a batch, with what else there is to know of the lot.
pub(super) fn batch(rows: &[ModelRow], beside: &str) -> Result<RecordBatch, ArrowError> {
    let mut fields = Vec::new();
    let mut arrays: Vec<ArrayRef> = Vec::new();
    for text in &TEXTS {
        fields.push(described(Field::new(text.name, DataType::Utf8, false), "none", text.description));
        arrays.push(Arc::new(StringArray::from_iter_values(rows.iter().map(text.of))));
    }
    for number in &NUMBERS {
        fields.push(described(Field::new(number.name, DataType::Float64, true), number.unit, number.description));
        let values = rows.iter().map(|row| Some((number.of)(row)).filter(|value| value.is_finite()));
        arrays.push(Arc::new(values.collect::<Float64Array>()));
    }
    let mut lists = ListBuilder::new(Float64Builder::new());
    for row in rows {
        lists.append_value(row.coefficients.iter().copied().map(Some));
    }
    let lists = lists.finish();
    let list = Field::new(COEFFICIENTS, lists.data_type().clone(), true);
    fields.push(described(
        list,
        "count",
        "Coefficients in the scaled temperature, constant first; of a table its knots.",
    ));
    arrays.push(Arc::new(lists));
    let metadata = HashMap::from([
        (VERSION_KEY.to_owned(), SCHEMA_VERSION.to_string()),
        (COLUMNS_KEY.to_owned(), columns_told(&fields)),
        (BESIDE_KEY.to_owned(), beside.to_owned()),
    ]);
    RecordBatch::try_new(Arc::new(Schema::new_with_metadata(fields, metadata)), arrays)
}

/// A batch as rows, or what does not fit.
pub(super) fn rows(batch: &RecordBatch) -> Result<Vec<ModelRow>, String> {
    let missing = |name: &str| format!("there is no column '{name}' of the right type");
    let column = |name: &str| batch.column_by_name(name).ok_or_else(|| missing(name));
    let mut rows = vec![ModelRow::default(); batch.num_rows()];
    let there = |text: &&Text| !LATER.contains(&text.name) || column(text.name).is_ok();
    for text in TEXTS.iter().filter(there) {
        let values = column(text.name)?.as_string_opt::<i32>().ok_or_else(|| missing(text.name))?;
        rows.iter_mut().zip(values).for_each(|(row, value)| *(text.of_mut)(row) = value.unwrap_or_default().to_owned());
    }
    for number in &NUMBERS {
        let values = column(number.name)?.as_primitive_opt::<Float64Type>().ok_or_else(|| missing(number.name))?;
        rows.iter_mut().zip(values).for_each(|(row, value)| *(number.of_mut)(row) = value.unwrap_or(f64::NAN));
    }
    let lists = column(COEFFICIENTS)?.as_list_opt::<i32>().ok_or_else(|| missing(COEFFICIENTS))?;
    for (row, list) in rows.iter_mut().zip(lists.iter()) {
        let list = list.ok_or_else(|| missing(COEFFICIENTS))?;
        let list = list.as_primitive_opt::<Float64Type>().ok_or_else(|| missing(COEFFICIENTS))?;
        row.coefficients = list.values().to_vec();
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_read_back_as_they_were_written() {
        let mut row = ModelRow { unit_serial: "ZR-1".into(), coefficients: vec![1.0, -2.5], ..ModelRow::unfitted() };
        row.held_out_rms = 0.25;
        let read = rows(&batch(&[row.clone()], "").unwrap()).unwrap().remove(0);
        assert_eq!((&read.unit_serial, &read.coefficients), (&row.unit_serial, &row.coefficients));
        assert!((read.held_out_rms - 0.25).abs() < 1e-15 && read.in_sample_rms.is_nan());
    }

    #[test]
    fn rows_of_before_a_column_are_read_without_it() {
        let row = ModelRow { unit_serial: "ZR-1".into(), readings_sha256: "ab".into(), ..ModelRow::unfitted() };
        let mut batch = batch(&[row], "").unwrap();
        batch.remove_column(batch.schema().index_of("readings_sha256").unwrap());
        let read = rows(&batch).unwrap().remove(0);
        assert_eq!((read.unit_serial.as_str(), read.readings_sha256.as_str()), ("ZR-1", ""));
        batch.remove_column(batch.schema().index_of("axis").unwrap());
        assert!(rows(&batch).unwrap_err().contains("'axis'"));
    }
}
