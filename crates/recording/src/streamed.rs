//! A table that is written batch by batch as an Arrow stream, readable up to its last whole batch, and finished as Parquet.

use std::fs::{self, File, TryLockError};
use std::io::{BufReader, BufWriter, Read, Write};
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::RecordBatch;
use arrow_buffer::Buffer;
use arrow_ipc::reader::{StreamDecoder, StreamReader};
use arrow_ipc::writer::StreamWriter;
use arrow_schema::{ArrowError, Schema};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::properties::WriterProperties;

use crate::header;
use crate::parquet_source::PARQUET_MAGIC;
use crate::parquet_source::ParquetSource;
use crate::schema::key_values;
use crate::{RecordingFault, WriteError};
use zerorate_source::Source;

/// Rows in a row group of the Parquet file: what [`Streamed::finish`] keeps in memory.
const ROW_GROUP_ROWS: usize = 65_536;

/// What every message of an Arrow stream starts with (Arrow columnar format, "Encapsulated message format").
pub(super) const CONTINUATION: &[u8] = &[0xFF; 4];

/// The end of an Arrow stream that was finished: a continuation and a length of 0.
const END_OF_STREAM: &[u8] = &[0xFF, 0xFF, 0xFF, 0xFF, 0, 0, 0, 0];

/// A table that is being written.
pub(super) struct Streamed {
    parquet: PathBuf,
    stream: PathBuf,
    schema: Arc<Schema>,
    writer: StreamWriter<BufWriter<File>>,
    of: &'static str,
    batches: u64,
    set_aside: Option<PathBuf>,
}

impl Streamed {
    /// Starts a table, a batch for each of what errors call `of`, that will be finished as the Parquet file `path`; until then it is the stream beside it with
    /// the extension `arrows`. An earlier Parquet file stays until this one is finished; an earlier stream, which a cut
    /// recording left, is kept under the extension `cut.arrows`, or `cut-1.arrows` and so on where one is kept already.
    pub fn create(path: &Path, schema: Arc<Schema>, of: &'static str) -> Result<Self, WriteError> {
        let stream = path.with_extension("arrows");
        let error = |reason: String| WriteError::Create { path: stream.clone(), reason };
        let mut set_aside = None;
        if let Ok(cut) = File::open(&stream) {
            if !hold(&cut) {
                return Err(WriteError::InUse { path: stream });
            }
            let numbered = (1..).map(|number| format!("cut-{number}.arrows"));
            let mut names =
                std::iter::once("cut.arrows".to_owned()).chain(numbered).map(|name| path.with_extension(name));
            set_aside = names.find(|free| !free.exists());
            set_aside.iter().try_for_each(|free| fs::rename(&stream, free)).map_err(|e| error(e.to_string()))?;
        }
        let file = File::create_new(&stream).map_err(|e| error(e.to_string()))?;
        if !hold(&file) {
            return Err(WriteError::InUse { path: stream });
        }
        let mut writer = StreamWriter::try_new(BufWriter::new(file), &schema).map_err(|e| error(e.to_string()))?;
        writer.get_mut().flush().map_err(|e| error(e.to_string()))?;
        Ok(Self { parquet: path.to_owned(), stream: stream.clone(), schema, writer, of, batches: 0, set_aside })
    }

    /// Where an earlier stream is now that was in this one's place.
    pub fn set_aside(&self) -> Option<&Path> {
        self.set_aside.as_deref()
    }

    /// Writes a batch and hands it to the system: from then on the end of this program cannot lose it.
    pub fn write(
        &mut self,
        batch: impl FnOnce(&Arc<Schema>) -> Result<RecordBatch, ArrowError>,
    ) -> Result<(), WriteError> {
        let result = batch(&self.schema).and_then(|batch| {
            self.writer.write(&batch)?;
            Ok(self.writer.get_mut().flush()?)
        });
        result.map_err(|error| WriteError::Write {
            path: self.stream.clone(),
            of: self.of,
            batches: self.batches,
            reason: error.to_string(),
        })?;
        self.batches += 1;
        Ok(())
    }

    /// Finishes the table: rewrites the stream as Parquet, puts that in place at once, and removes the stream. Where that
    /// fails the stream holds every batch, and an earlier Parquet file is as it was.
    pub fn finish(mut self) -> Result<PathBuf, WriteError> {
        let partial = self.parquet.with_extension("parquet.partial");
        let result = self.rewrite(&partial);
        if let Err(reason) = result {
            // It may never have been made.
            let _ = fs::remove_file(&partial);
            return Err(WriteError::Finish {
                path: self.parquet,
                stream: self.stream,
                of: self.of,
                batches: self.batches,
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
            .set_key_value_metadata(Some(key_values(&self.schema)))
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

/// Holds a file or a folder by the system's lock, which others can read past and no end of the program leaves behind, until it
/// is closed; false where somebody else does. There are file systems without locks, and on Windows nobody could read past.
#[must_use]
pub fn hold(place: &File) -> bool {
    !cfg!(unix) || !matches!(place.try_lock(), Err(TryLockError::WouldBlock))
}

/// A table that was read: what its schema says, its rows, and whether it was cut off or is still being written.
pub(super) type ReadBack<I, R> = (I, Vec<R>, bool);

/// Reads a table in either form, by content: `info` says what its schema is of, before anything else is believed of it.
pub(super) fn read<I, R>(
    source: &Source,
    info: impl FnOnce(&Schema) -> Result<I, RecordingFault>,
    rows: impl Fn(&RecordBatch) -> Result<Vec<R>, String>,
) -> Result<ReadBack<I, R>, RecordingFault> {
    // Somebody's log may be large: only a stream, which is the bench's own form, is read whole.
    let start = source.start(CONTINUATION.len() as u64)?;
    if start == PARQUET_MAGIC {
        read_parquet(source, info, rows)
    } else if start == CONTINUATION {
        let mut bytes = Vec::new();
        source.open()?.read_to_end(&mut bytes)?;
        read_stream(bytes, info, rows)
    } else if CONTINUATION.starts_with(&start) {
        Err(RecordingFault::NothingWhole)
    } else {
        Err(RecordingFault::NotARecording)
    }
}

fn read_parquet<I, R>(
    source: &Source,
    info: impl FnOnce(&Schema) -> Result<I, RecordingFault>,
    rows: impl Fn(&RecordBatch) -> Result<Vec<R>, String>,
) -> Result<ReadBack<I, R>, RecordingFault> {
    let file = ParquetSource::new(source)?;
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(RecordingFault::damaged)?;
    let info = info(builder.schema())?;
    let mut read = Vec::new();
    for batch in builder.build().map_err(RecordingFault::damaged)? {
        read.extend(rows(&batch.map_err(RecordingFault::damaged)?).map_err(RecordingFault::damaged)?);
    }
    Ok((info, read, false))
}

fn read_stream<I, R>(
    bytes: Vec<u8>,
    info: impl FnOnce(&Schema) -> Result<I, RecordingFault>,
    rows: impl Fn(&RecordBatch) -> Result<Vec<R>, String>,
) -> Result<ReadBack<I, R>, RecordingFault> {
    let cut = !bytes.ends_with(END_OF_STREAM);
    let info = info(&header::read(&bytes)?)?;
    // Arrow's decoder panics on some of the messages that a damaged file can hold.
    let batches = catch_unwind(|| decode(bytes))
        .map_err(|_| RecordingFault::damaged("a message contradicts itself"))?
        .map_err(RecordingFault::damaged)?;
    let mut read = Vec::new();
    for batch in batches {
        read.extend(rows(&batch).map_err(RecordingFault::damaged)?);
    }
    Ok((info, read, cut))
}

/// Every whole batch. What the decoder keeps for want of its end is the batch that was cut.
fn decode(bytes: Vec<u8>) -> Result<Vec<RecordBatch>, ArrowError> {
    let mut buffer = Buffer::from_vec(bytes);
    let mut decoder = StreamDecoder::new();
    std::iter::from_fn(|| decoder.decode(&mut buffer).transpose()).collect()
}
