//! A source as Parquet's reader takes one: any part of it, in any order.

use std::io::{self, BufReader, Read, Seek, SeekFrom};

use bytes::Bytes;
use parquet::errors::{ParquetError, Result};
use parquet::file::reader::{ChunkReader, Length};

use zerorate_source::{ReadSeek, Source};

/// What a Parquet file begins with.
pub const PARQUET_MAGIC: &[u8] = b"PAR1";

/// A Parquet file, wherever it is.
pub struct ParquetSource {
    source: Source,
    length: u64,
}

impl ParquetSource {
    /// A source whose length can be told.
    ///
    /// # Errors
    /// When it cannot.
    pub fn new(source: &Source) -> io::Result<Self> {
        Ok(Self { source: source.clone(), length: source.length()? })
    }
}

impl Length for ParquetSource {
    fn len(&self) -> u64 {
        self.length
    }
}

impl ChunkReader for ParquetSource {
    type T = BufReader<Box<dyn ReadSeek>>;

    fn get_read(&self, start: u64) -> Result<Self::T> {
        let mut reader = self.source.open()?;
        reader.seek(SeekFrom::Start(start))?;
        Ok(BufReader::new(reader))
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes> {
        let mut bytes = Vec::with_capacity(length);
        let read = self.get_read(start)?.take(length as u64).read_to_end(&mut bytes)?;
        if read == length {
            Ok(bytes.into())
        } else {
            Err(ParquetError::EOF("the file ends before its contents".into()))
        }
    }
}
