//! Reading: either form, by content; a cut stream up to its last whole group.

use std::io::Read;
use std::panic::catch_unwind;

use arrow_array::RecordBatch;
use arrow_buffer::Buffer;
use arrow_ipc::reader::StreamDecoder;
use arrow_schema::{ArrowError, Schema};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

use super::{GroupRow, RecordingError, RecordingFault, RecordingInfo};
use super::{header, schema};
use crate::parquet_source::ParquetSource;
use crate::source::Source;
use crate::table::PARQUET_MAGIC;

/// What every message of an Arrow stream starts with (Arrow columnar format, "Encapsulated message format").
const CONTINUATION: &[u8] = &[0xFF; 4];

/// The end of an Arrow stream that was finished: a continuation and a length of 0.
const END_OF_STREAM: &[u8] = &[0xFF, 0xFF, 0xFF, 0xFF, 0, 0, 0, 0];

/// A recording that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// What is true of the whole recording.
    pub info: RecordingInfo,
    /// All rows of all whole groups, in the order written.
    pub rows: Vec<GroupRow>,
    /// Whether the recording was not finished: cut off, or still being written.
    pub cut: bool,
}

impl Recording {
    /// What there is to say of a recording that holds no ramp.
    #[must_use]
    pub fn without_a_ramp(&self) -> String {
        let procedure = Some(self.info.procedure.as_str()).filter(|name| !name.is_empty());
        let of = procedure.map(|name| format!(" of the procedure {name}")).unwrap_or_default();
        match self.rows.is_empty() {
            true => format!("the recording{of} is empty: it has no group"),
            false => format!(
                "the recording{of} holds no ramp, and only a ramp shows the drift: take that of the full-temperature test"
            ),
        }
    }

    /// Whether a source is a recording, finished or not, of any version: a log of another maker is none.
    #[must_use]
    pub fn is_one(source: &Source) -> bool {
        let of_parquet = || {
            let file = ParquetSource::new(source).ok()?;
            let builder = ParquetRecordBatchReaderBuilder::try_new(file).ok()?;
            schema::version(builder.schema()).map(|_| ())
        };
        let start = source.start(PARQUET_MAGIC.len() as u64).unwrap_or_default();
        start == CONTINUATION || (start == PARQUET_MAGIC && of_parquet().is_some())
    }

    /// Reads a recording, finished or not.
    ///
    /// # Errors
    /// When the source cannot be read, is no recording or one of another schema version, is damaged, or was cut off before
    /// its header.
    pub fn read(source: &Source) -> Result<Self, RecordingError> {
        Self::read_either(source).map_err(|fault| source.faulty(fault))
    }

    fn read_either(source: &Source) -> Result<Self, RecordingFault> {
        // Somebody's log may be large: only a stream, which is the bench's own form, is read whole.
        let start = source.start(CONTINUATION.len() as u64)?;
        if start == PARQUET_MAGIC {
            read_parquet(source)
        } else if start == CONTINUATION {
            let mut bytes = Vec::new();
            source.open()?.read_to_end(&mut bytes)?;
            read_stream(bytes)
        } else if CONTINUATION.starts_with(&start) {
            Err(RecordingFault::NothingWhole)
        } else {
            Err(RecordingFault::NotARecording)
        }
    }

    /// The number of whole groups.
    #[must_use]
    pub fn groups(&self) -> usize {
        self.rows.chunk_by(|a, b| a.group == b.group).count()
    }
}

fn read_parquet(source: &Source) -> Result<Recording, RecordingFault> {
    let file = ParquetSource::new(source)?;
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(RecordingFault::damaged)?;
    let info = check(builder.schema())?;
    let mut rows = Vec::new();
    for batch in builder.build().map_err(RecordingFault::damaged)? {
        rows.extend(schema::rows(&batch.map_err(RecordingFault::damaged)?).map_err(RecordingFault::damaged)?);
    }
    Ok(Recording { info, rows, cut: false })
}

fn read_stream(bytes: Vec<u8>) -> Result<Recording, RecordingFault> {
    let cut = !bytes.ends_with(END_OF_STREAM);
    let info = check(&header::read(&bytes)?)?;
    // Arrow's decoder panics on some of the messages that a damaged file can hold.
    let batches = catch_unwind(|| decode(bytes))
        .map_err(|_| RecordingFault::damaged("a message contradicts itself"))?
        .map_err(RecordingFault::damaged)?;
    let mut rows = Vec::new();
    for batch in batches {
        rows.extend(schema::rows(&batch).map_err(RecordingFault::damaged)?);
    }
    Ok(Recording { info, rows, cut })
}

/// Every whole batch. What the decoder keeps for want of its end is the group that was cut.
fn decode(bytes: Vec<u8>) -> Result<Vec<RecordBatch>, ArrowError> {
    let mut buffer = Buffer::from_vec(bytes);
    let mut decoder = StreamDecoder::new();
    std::iter::from_fn(|| decoder.decode(&mut buffer).transpose()).collect()
}

impl RecordingInfo {
    /// The metadata of a recording's schema.
    ///
    /// # Errors
    /// When the schema is no recording's, or one of another version.
    pub fn of_schema(schema: &Schema) -> Result<Self, RecordingFault> {
        check(schema)
    }
}

/// The metadata, if it is a recording's of a known version.
fn check(schema: &Schema) -> Result<RecordingInfo, RecordingFault> {
    match schema::version(schema) {
        Some(version) if (1..=super::SCHEMA_VERSION).any(|known| version == known.to_string()) => {
            Ok(schema::info(schema))
        }
        Some(version) => Err(RecordingFault::UnknownVersion { found: version.to_owned() }),
        None => Err(RecordingFault::NotARecording),
    }
}
