//! The columns of the rows, each named once.

use std::collections::HashMap;
use std::sync::Arc;

use arrow_array::builder::{Float64Builder, ListBuilder};
use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{Array, ArrayRef, Float64Array, RecordBatch, StringArray};
use arrow_schema::{ArrowError, DataType, Field, Schema};

use super::{ModelRow, SCHEMA_VERSION};

/// Where the schema's version stands in the file's metadata.
pub(super) const VERSION_KEY: &str = "zerorate.models_version";

/// A column of texts.
struct Text {
    name: &'static str,
    of: fn(&ModelRow) -> &str,
    of_mut: fn(&mut ModelRow) -> &mut String,
}

/// A column of numbers.
pub(super) struct Number {
    name: &'static str,
    of: fn(&ModelRow) -> f64,
    pub of_mut: fn(&mut ModelRow) -> &mut f64,
}

macro_rules! texts {
    ($($name:ident),* $(,)?) => {
        [$(Text { name: stringify!($name), of: |row| &row.$name, of_mut: |row| &mut row.$name }),*]
    };
}

macro_rules! numbers {
    ($($name:ident),* $(,)?) => {
        [$(Number { name: stringify!($name), of: |row| row.$name, of_mut: |row| &mut row.$name }),*]
    };
}

static TEXTS: [Text; 16] = texts![
    unit_serial,
    axis,
    station,
    operator,
    recorded_at,
    procedure,
    firmware,
    dataset,
    file,
    file_modified,
    model_asked,
    model,
    verdict,
    reasons,
    calibration,
    created_by,
];

pub(super) static NUMBERS: [Number; 16] = numbers![
    file_bytes,
    temperature_min,
    temperature_max,
    temperature_centre,
    temperature_half_span,
    groups,
    samples,
    in_sample_rms,
    in_sample_pp,
    held_out_rms,
    held_out_pp,
    drift_pp,
    reading_mid,
    limit_trim_residual_pp,
    limit_hybrid_residual_floors,
    limit_mean_offset,
];

const COEFFICIENTS: &str = "coefficients";

/// Rows as a batch.
pub(super) fn batch(rows: &[ModelRow]) -> Result<RecordBatch, ArrowError> {
    let mut fields = Vec::new();
    let mut arrays: Vec<ArrayRef> = Vec::new();
    for text in &TEXTS {
        fields.push(Field::new(text.name, DataType::Utf8, false));
        arrays.push(Arc::new(StringArray::from_iter_values(rows.iter().map(text.of))));
    }
    for number in &NUMBERS {
        fields.push(Field::new(number.name, DataType::Float64, true));
        let values = rows.iter().map(|row| Some((number.of)(row)).filter(|value| value.is_finite()));
        arrays.push(Arc::new(values.collect::<Float64Array>()));
    }
    let mut lists = ListBuilder::new(Float64Builder::new());
    for row in rows {
        lists.append_value(row.coefficients.iter().copied().map(Some));
    }
    let lists = lists.finish();
    fields.push(Field::new(COEFFICIENTS, lists.data_type().clone(), true));
    arrays.push(Arc::new(lists));
    let metadata = HashMap::from([(VERSION_KEY.to_owned(), SCHEMA_VERSION.to_string())]);
    RecordBatch::try_new(Arc::new(Schema::new_with_metadata(fields, metadata)), arrays)
}

/// A batch as rows, or what does not fit.
pub(super) fn rows(batch: &RecordBatch) -> Result<Vec<ModelRow>, String> {
    let missing = |name: &str| format!("there is no column '{name}' of the right type");
    let column = |name: &str| batch.column_by_name(name).ok_or_else(|| missing(name));
    let mut rows = vec![ModelRow::default(); batch.num_rows()];
    for text in &TEXTS {
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
        let read = rows(&batch(&[row.clone()]).unwrap()).unwrap().remove(0);
        assert_eq!((&read.unit_serial, &read.coefficients), (&row.unit_serial, &row.coefficients));
        assert!((read.held_out_rms - 0.25).abs() < 1e-15 && read.in_sample_rms.is_nan());
    }
}
