//! Reading: either form, by content; a cut stream up to its last whole group.

use std::fs::{self, File};
use std::io::Read;
use std::panic::catch_unwind;
use std::path::Path;

use arrow_array::RecordBatch;
use arrow_buffer::Buffer;
use arrow_ipc::reader::StreamDecoder;
use arrow_schema::{ArrowError, Schema};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

use super::{GroupRow, RecordingError, RecordingInfo};
use super::{header, schema};

/// What every Parquet file starts with.
const PARQUET_MAGIC: &[u8] = b"PAR1";

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
    /// Whether a file is a recording, finished or not, of any version: a log of another maker is none.
    #[must_use]
    pub fn is_one(path: &Path) -> bool {
        let Ok(mut file) = File::open(path) else {
            return false;
        };
        let mut start = [0; 4];
        if file.read_exact(&mut start).is_err() {
            return false;
        }
        let of_parquet =
            || ParquetRecordBatchReaderBuilder::try_new(file).is_ok_and(|it| schema::version(it.schema()).is_some());
        if start == *PARQUET_MAGIC { of_parquet() } else { start == *CONTINUATION }
    }

    /// Reads a recording, finished or not.
    ///
    /// # Errors
    /// When the file cannot be read, is no recording or one of another schema version, is damaged, or was cut off before
    /// its header.
    pub fn read(path: &Path) -> Result<Self, RecordingError> {
        let cannot = |source| RecordingError::Read { path: path.to_owned(), source };
        // Somebody's log may be large: only a stream, which is the bench's own form, is read whole.
        let mut start = Vec::new();
        File::open(path).map_err(cannot)?.take(CONTINUATION.len() as u64).read_to_end(&mut start).map_err(cannot)?;
        if start == PARQUET_MAGIC {
            read_parquet(path)
        } else if start == CONTINUATION {
            read_stream(path, fs::read(path).map_err(cannot)?)
        } else if CONTINUATION.starts_with(&start) {
            Err(RecordingError::NothingWhole { path: path.to_owned() })
        } else {
            Err(RecordingError::NotARecording { path: path.to_owned() })
        }
    }

    /// The number of whole groups.
    #[must_use]
    pub fn groups(&self) -> usize {
        self.rows.chunk_by(|a, b| a.group == b.group).count()
    }
}

fn read_parquet(path: &Path) -> Result<Recording, RecordingError> {
    let file = File::open(path).map_err(|source| RecordingError::Read { path: path.to_owned(), source })?;
    let damaged = |reason: String| RecordingError::Damaged { path: path.to_owned(), reason };
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(|e| damaged(e.to_string()))?;
    let info = check(path, builder.schema())?;
    let mut rows = Vec::new();
    for batch in builder.build().map_err(|e| damaged(e.to_string()))? {
        let batch = batch.map_err(|e| damaged(e.to_string()))?;
        rows.extend(schema::rows(&batch).map_err(damaged)?);
    }
    Ok(Recording { info, rows, cut: false })
}

fn read_stream(path: &Path, bytes: Vec<u8>) -> Result<Recording, RecordingError> {
    let damaged = |reason: String| RecordingError::Damaged { path: path.to_owned(), reason };
    let cut = !bytes.ends_with(END_OF_STREAM);
    let info = check(path, &header::read(path, &bytes)?)?;
    // Arrow's decoder panics on some of the messages that a damaged file can hold.
    let batches = catch_unwind(|| decode(bytes))
        .map_err(|_| damaged("a message contradicts itself".to_owned()))?
        .map_err(|error| damaged(error.to_string()))?;
    let mut rows = Vec::new();
    for batch in batches {
        rows.extend(schema::rows(&batch).map_err(damaged)?);
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
    /// The metadata of a recording's schema; `path` is for the error's words.
    ///
    /// # Errors
    /// When the schema is no recording's, or one of another version.
    pub fn of_schema(path: &Path, schema: &Schema) -> Result<Self, RecordingError> {
        check(path, schema)
    }
}

/// The metadata, if it is a recording's of a known version.
fn check(path: &Path, schema: &Schema) -> Result<RecordingInfo, RecordingError> {
    match schema::version(schema) {
        Some(version) if version == super::SCHEMA_VERSION.to_string() => Ok(schema::info(schema)),
        Some(version) => Err(RecordingError::UnknownVersion { path: path.to_owned(), found: version.to_owned() }),
        None => Err(RecordingError::NotARecording { path: path.to_owned() }),
    }
}
