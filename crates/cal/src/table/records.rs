//! Arrow's record batches as batches of a table: what Parquet and Arrow files have in common.

use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{Array, ArrayRef, RecordBatch};
use arrow_cast::display::{ArrayFormatter, FormatOptions};
use arrow_schema::{ArrowError, DataType, Schema};

use super::{Batch, Clock, TableFault};
use crate::units::TimeUnit;

/// The names of all columns, and what those are that are times.
pub(super) fn columns(schema: &Schema) -> (Vec<String>, Vec<Option<Clock>>) {
    schema.fields().iter().map(|field| (field.name().clone(), clock(field.data_type()))).unzip()
}

fn clock(kind: &DataType) -> Option<Clock> {
    let (unit, is_utc) = match kind {
        // With a zone a value counts from 1970 in UTC, without one in nobody knows which.
        DataType::Timestamp(unit, zone) => (unit, zone.is_some()),
        DataType::Duration(unit) => (unit, false),
        _ => return None,
    };
    let unit = match unit {
        arrow_schema::TimeUnit::Second => TimeUnit::S,
        arrow_schema::TimeUnit::Millisecond => TimeUnit::Ms,
        arrow_schema::TimeUnit::Microsecond => TimeUnit::Us,
        arrow_schema::TimeUnit::Nanosecond => TimeUnit::Ns,
    };
    Some(Clock { unit, is_utc })
}

/// Which columns are read of a file, and where each column asked for lies among them.
pub(super) struct Projection {
    /// The columns read, in the file's order: in that they come, whatever the order asked for.
    pub read: Vec<usize>,
    places: Vec<usize>,
    cells: bool,
}

impl Projection {
    /// Of the columns asked for, which must be numbers; with `cells` all are read.
    pub(super) fn of(schema: &Schema, columns: &[usize], cells: bool) -> Result<Self, TableFault> {
        for &column in columns {
            let field = schema.field(column);
            if !is_numeric(field.data_type()) {
                let (column, kind) = (field.name().clone(), field.data_type().to_string());
                return Err(TableFault::NotNumeric { column, kind });
            }
        }
        let mut read: Vec<usize> = if cells { (0..schema.fields().len()).collect() } else { columns.to_vec() };
        read.sort_unstable();
        read.dedup();
        let places =
            columns.iter().map(|column| read.binary_search(column).expect("every column asked for is read")).collect();
        Ok(Self { read, places, cells })
    }

    /// Batches as they come, rows counted.
    pub(super) fn batches(
        self,
        records: impl Iterator<Item = Result<RecordBatch, ArrowError>>,
    ) -> impl Iterator<Item = Result<Batch, ArrowError>> {
        let mut row = 0;
        records.map(move |record| {
            let record = record?;
            let columns = self.places.iter().map(|&place| numbers(record.column(place))).collect::<Result<_, _>>()?;
            let cells = if self.cells { cells(&record)? } else { Vec::new() };
            let first_row = row;
            row += record.num_rows() as u64;
            Ok(Batch { first_row, columns, cells, cut_line: None })
        })
    }
}

/// Whether a column's values are numbers; a time stamp is one in its own unit.
fn is_numeric(kind: &DataType) -> bool {
    kind.is_numeric() || matches!(kind, DataType::Timestamp(..) | DataType::Duration(_))
}

/// A column as f64, a null as NaN.
fn numbers(column: &ArrayRef) -> Result<Vec<f64>, ArrowError> {
    let plain = match column.data_type() {
        DataType::Timestamp(..) | DataType::Duration(_) => arrow_cast::cast(column, &DataType::Int64)?,
        _ => column.clone(),
    };
    let floats = arrow_cast::cast(&plain, &DataType::Float64)?;
    let floats = floats.as_primitive::<Float64Type>();
    if floats.null_count() == 0 {
        return Ok(floats.values().to_vec());
    }
    Ok(floats.iter().map(|value| value.unwrap_or(f64::NAN)).collect())
}

/// The text of every cell, a vector a row.
fn cells(record: &RecordBatch) -> Result<Vec<Vec<String>>, ArrowError> {
    let options = FormatOptions::default();
    let columns: Vec<ArrayFormatter<'_>> =
        record.columns().iter().map(|column| ArrayFormatter::try_new(column, &options)).collect::<Result<_, _>>()?;
    (0..record.num_rows()).map(|row| columns.iter().map(|column| column.value(row).try_to_string()).collect()).collect()
}
