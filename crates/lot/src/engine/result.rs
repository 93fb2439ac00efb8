//! Numbers of a result.

use arrow_array::RecordBatch;
use arrow_array::cast::AsArray;
use datafusion::arrow::compute::cast;
use datafusion::arrow::datatypes::{DataType, Float64Type};
use datafusion::common::DataFusionError;

use super::EngineError;

/// A column of a result as f64, of whatever kind of number the engine gives it; NaN where a value is missing.
pub(crate) fn column(batch: &RecordBatch, name: &str) -> Result<Vec<f64>, EngineError> {
    let missing = || DataFusionError::Internal(format!("no column {name} in the result"));
    let column = batch.column_by_name(name).ok_or_else(missing)?;
    let column = cast(column, &DataType::Float64).map_err(DataFusionError::from)?;
    Ok(column.as_primitive::<Float64Type>().iter().map(|value| value.unwrap_or(f64::NAN)).collect())
}

/// A count of a result, far below 2^53.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub(crate) fn count(value: f64) -> u64 {
    value as u64
}
