//! Writing: group by group as a stream, and at the end as Parquet.

use std::fs::{self, File};
use std::io::{BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_ipc::reader::StreamReader;
use arrow_ipc::writer::StreamWriter;
use arrow_schema::Schema;
use parquet::arrow::ArrowWriter;
use parquet::file::properties::WriterProperties;

use super::schema;
use super::{GroupRow, RecordingInfo, WriteError};

/// Rows in a row group of the Parquet file: what [`RecordingWriter::finish`] keeps in memory.
const ROW_GROUP_ROWS: usize = 65_536;

/// A recording that is being written.
pub struct RecordingWriter {
    parquet: PathBuf,
    stream: PathBuf,
    schema: Arc<Schema>,
    writer: StreamWriter<BufWriter<File>>,
    groups: u64,
}

impl RecordingWriter {
    /// Starts a recording that will be finished as the Parquet file `path`; until then it is the stream beside it with
    /// the extension `arrows`. An earlier Parquet file stays until this one is finished; an earlier stream, which a cut
    /// recording left, is kept under the extension `cut.arrows`.
    ///
    /// # Errors
    /// When the folder or the stream cannot be written.
    pub fn create(path: &Path, info: &RecordingInfo) -> Result<Self, WriteError> {
        let stream = path.with_extension("arrows");
        let error = |reason: String| WriteError::Create { path: stream.clone(), reason };
        if stream.exists() {
            fs::rename(&stream, path.with_extension("cut.arrows")).map_err(|e| error(e.to_string()))?;
        }
        let file = File::create(&stream).map_err(|e| error(e.to_string()))?;
        let schema = schema::schema(info);
        let mut writer = StreamWriter::try_new(BufWriter::new(file), &schema).map_err(|e| error(e.to_string()))?;
        writer.get_mut().flush().map_err(|e| error(e.to_string()))?;
        Ok(Self { parquet: path.to_owned(), stream: stream.clone(), schema, writer, groups: 0 })
    }

    /// The stream that is being written.
    #[must_use]
    pub fn stream_path(&self) -> &Path {
        &self.stream
    }

    /// Writes all rows of one group and hands them to the system: from then on the end of this program cannot lose them.
    ///
    /// # Errors
    /// When they cannot be written, as with a full disk; the groups before are kept.
    pub fn write_group(&mut self, rows: &[GroupRow]) -> Result<(), WriteError> {
        let result = schema::batch(&self.schema, rows).and_then(|batch| {
            self.writer.write(&batch)?;
            Ok(self.writer.get_mut().flush()?)
        });
        result.map_err(|error| WriteError::Write {
            path: self.stream.clone(),
            groups: self.groups,
            reason: error.to_string(),
        })?;
        self.groups += 1;
        Ok(())
    }

    /// Finishes the recording: rewrites the stream as Parquet, puts that in place at once, and removes the stream.
    ///
    /// # Errors
    /// When that fails: the stream then still holds every group, and an earlier Parquet file is as it was.
    pub fn finish(mut self) -> Result<PathBuf, WriteError> {
        let partial = self.parquet.with_extension("parquet.partial");
        let result = self.rewrite(&partial);
        if let Err(reason) = result {
            // It may never have been made.
            let _ = fs::remove_file(&partial);
            return Err(WriteError::Finish {
                path: self.parquet,
                stream: self.stream,
                groups: self.groups,
                reason: reason.to_string(),
            });
        }
        Ok(self.parquet)
    }

    fn rewrite(&mut self, partial: &Path) -> Result<(), Box<dyn std::error::Error>> {
        self.writer.finish()?;
        self.writer.get_mut().flush()?;
        let stream = StreamReader::try_new(BufReader::new(File::open(&self.stream)?), None)?;
        let properties = WriterProperties::builder()
            .set_max_row_group_row_count(Some(ROW_GROUP_ROWS))
            .set_key_value_metadata(Some(schema::key_values(&self.schema)))
            .build();
        let mut writer = ArrowWriter::try_new(File::create(partial)?, Arc::clone(&self.schema), Some(properties))?;
        for batch in stream {
            writer.write(&batch?)?;
        }
        writer.into_inner()?.sync_all()?;
        fs::rename(partial, &self.parquet)?;
        fs::remove_file(&self.stream)?;
        Ok(())
    }
}
