//! Parquet as batches: only the columns asked for are decoded, a batch at a time.

use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

use super::records::{self, Projection};
use super::{BATCH_ROWS, Batch, Clock, TableFault};
use crate::parquet_source::ParquetSource;
use crate::source::Source;

/// The names of all columns, and what those are that are times.
pub(super) fn columns(source: &Source) -> Result<(Vec<String>, Vec<Option<Clock>>), TableFault> {
    let builder = builder(source)?;
    if builder.metadata().file_metadata().num_rows() == 0 {
        return Err(TableFault::Empty);
    }
    Ok(records::columns(builder.schema()))
}

/// A stream of batches from a Parquet file.
pub(super) fn batches(
    source: &Source,
    columns: &[usize],
    cells: bool,
) -> Result<impl Iterator<Item = Result<Batch, TableFault>> + use<>, TableFault> {
    let builder = builder(source)?;
    let projection = Projection::of(builder.schema(), columns, cells)?;
    let mask = ProjectionMask::roots(builder.parquet_schema(), projection.read.iter().copied());
    let reader = builder.with_projection(mask).with_batch_size(BATCH_ROWS).build().map_err(|error| damaged(&error))?;
    Ok(projection.batches(reader).map(|batch| batch.map_err(|error| damaged(&error))))
}

fn builder(source: &Source) -> Result<ParquetRecordBatchReaderBuilder<ParquetSource>, TableFault> {
    ParquetRecordBatchReaderBuilder::try_new(ParquetSource::new(source)?).map_err(|error| damaged(&error))
}

fn damaged(error: &dyn std::error::Error) -> TableFault {
    TableFault::Parquet { reason: error.to_string() }
}
