//! Arrow files (Feather 2) as batches: what holds columns of memory as they are, those of data frames and arrays among them.

use std::io::BufReader;
use std::panic::{AssertUnwindSafe, catch_unwind};

use arrow_array::RecordBatch;
use arrow_ipc::reader::FileReader;
use arrow_schema::ArrowError;

use super::records::{self, Projection};
use super::{BATCH_ROWS, Batch, Clock, TableFault};
use crate::source::{ReadSeek, Source};

/// The first bytes of every Arrow file (Arrow columnar format, "IPC File Format").
pub(super) const MAGIC: &[u8] = b"ARROW1";

type Reader = FileReader<BufReader<Box<dyn ReadSeek>>>;

/// The names of all columns, and what those are that are times.
pub(super) fn columns(source: &Source) -> Result<(Vec<String>, Vec<Option<Clock>>), TableFault> {
    let reader = open(source, None)?;
    if reader.num_batches() == 0 {
        return Err(TableFault::Empty);
    }
    Ok(records::columns(&reader.schema()))
}

/// A stream of batches from an Arrow file.
pub(super) fn batches(
    source: &Source,
    columns: &[usize],
    cells: bool,
) -> Result<impl Iterator<Item = Result<Batch, TableFault>> + use<>, TableFault> {
    let schema = open(source, None)?.schema();
    let projection = Projection::of(&schema, columns, cells)?;
    let mut reader = open(source, Some(projection.read.clone()))?;
    let records = std::iter::from_fn(move || unharmed(|| reader.next().transpose()).transpose());
    let batches = projection.batches(records.flat_map(pieces));
    Ok(batches.map(|batch| batch.map_err(|error| damaged(&error))))
}

fn open(source: &Source, read: Option<Vec<usize>>) -> Result<Reader, TableFault> {
    let file = BufReader::new(source.open()?);
    unharmed(|| FileReader::try_new(file, read)).map_err(|error| damaged(&error))
}

/// A batch in pieces no longer than those of other tables: that of a file may be all of it.
fn pieces(record: Result<RecordBatch, ArrowError>) -> Vec<Result<RecordBatch, ArrowError>> {
    let Ok(record) = record else { return vec![record] };
    let starts = (0..record.num_rows()).step_by(BATCH_ROWS);
    starts.map(|start| Ok(record.slice(start, BATCH_ROWS.min(record.num_rows() - start)))).collect()
}

/// Arrow's decoder panics on some of the messages that a damaged file can hold.
fn unharmed<T>(read: impl FnOnce() -> Result<T, ArrowError>) -> Result<T, ArrowError> {
    let contradicts = |_| Err(ArrowError::IpcError("a message contradicts itself".to_owned()));
    catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(contradicts)
}

fn damaged(error: &ArrowError) -> TableFault {
    TableFault::Arrow { reason: error.to_string() }
}
