//! Parquet as batches: only the columns asked for are decoded, a batch at a time.

use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{Array, ArrayRef, RecordBatch};
use arrow_cast::display::{ArrayFormatter, FormatOptions};
use arrow_schema::{ArrowError, DataType};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder};

use super::{BATCH_ROWS, Batch, Clock, TableFault};
use crate::recording::parquet_source::ParquetSource;
use crate::source::Source;
use crate::units::TimeUnit;

/// The names of all columns, and what those are that are times.
pub(super) fn columns(source: &Source) -> Result<(Vec<String>, Vec<Option<Clock>>), TableFault> {
    let builder = builder(source)?;
    if builder.metadata().file_metadata().num_rows() == 0 {
        return Err(TableFault::Empty);
    }
    Ok(builder.schema().fields().iter().map(|field| (field.name().clone(), clock(field.data_type()))).unzip())
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

fn builder(source: &Source) -> Result<ParquetRecordBatchReaderBuilder<ParquetSource>, TableFault> {
    ParquetRecordBatchReaderBuilder::try_new(ParquetSource::new(source)?).map_err(|error| damaged(&error))
}

fn damaged(error: &dyn std::error::Error) -> TableFault {
    let reason = error.to_string();
    let reason = match unknown_packing(&reason) {
        Some(packing) => format!("it is packed by {packing}: write it again, packed by snappy"),
        None => reason,
    };
    TableFault::Parquet { reason }
}

/// What a file is packed by, where the reader says that it was built without it, or that nobody has written it yet.
pub(super) fn unknown_packing(reason: &str) -> Option<&str> {
    let left_out = reason.split_once("Disabled feature at compile time: ").map(|(_, packing)| packing);
    let not_written = || reason.split_once("The codec type ")?.1.strip_suffix(" is not supported yet");
    left_out.or_else(not_written)
}

/// A stream of batches from a Parquet file.
pub(super) struct ParquetBatches {
    reader: ParquetRecordBatchReader,
    /// Where each column asked for lies in the batches read.
    places: Vec<usize>,
    cells: bool,
    row: u64,
}

impl ParquetBatches {
    pub(super) fn open(source: &Source, columns: &[usize], cells: bool) -> Result<Self, TableFault> {
        let builder = builder(source)?;
        for &column in columns {
            let field = builder.schema().field(column);
            if !is_numeric(field.data_type()) {
                let (column, kind) = (field.name().clone(), field.data_type().to_string());
                return Err(TableFault::NotNumeric { column, kind });
            }
        }
        // Columns come in the file's order, whatever the order asked for.
        let mut read: Vec<usize> =
            if cells { (0..builder.schema().fields().len()).collect() } else { columns.to_vec() };
        read.sort_unstable();
        read.dedup();
        let places =
            columns.iter().map(|column| read.binary_search(column).expect("every column asked for is read")).collect();
        let mask = ProjectionMask::roots(builder.parquet_schema(), read);
        let reader =
            builder.with_projection(mask).with_batch_size(BATCH_ROWS).build().map_err(|error| damaged(&error))?;
        Ok(Self { reader, places, cells, row: 0 })
    }

    fn convert(&mut self, record: &RecordBatch) -> Result<Batch, ArrowError> {
        let columns = self.places.iter().map(|&place| numbers(record.column(place))).collect::<Result<_, _>>()?;
        let cells = if self.cells { cells(record)? } else { Vec::new() };
        let first_row = self.row;
        self.row += record.num_rows() as u64;
        Ok(Batch { first_row, columns, cells, cut_line: None })
    }
}

impl Iterator for ParquetBatches {
    type Item = Result<Batch, TableFault>;

    fn next(&mut self) -> Option<Self::Item> {
        let record = self.reader.next()?;
        let batch = record.and_then(|record| self.convert(&record));
        Some(batch.map_err(|error| damaged(&error)))
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
