//! Reading: either form, by content; a cut stream up to its last whole group.

use arrow_schema::Schema;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

use zerorate_source::Source;

use crate::parquet_source::{PARQUET_MAGIC, ParquetSource};
use crate::streamed::{self, CONTINUATION};
use crate::{GroupRow, RecordingError, RecordingFault, RecordingInfo, schema};

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
        match self.rows.is_empty() {
            true => format!("the recording{} is empty: it has no group", self.info.of_procedure()),
            false => self.info.without_a_ramp(),
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
        let (info, rows, cut) = streamed::read(source, check, schema::rows).map_err(|fault| source.faulty(fault))?;
        Ok(Self { info, rows, cut })
    }

    /// The number of whole groups.
    #[must_use]
    pub fn groups(&self) -> usize {
        self.rows.chunk_by(|a, b| a.group == b.group).count()
    }
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
