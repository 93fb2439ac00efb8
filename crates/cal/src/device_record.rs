//! Device records as files: what `device-record.bin` holds, for those who look at one.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use thiserror::Error;
use zerorate_core::record::{DeviceRecord, MAX_RECORD_BYTES, RECORD_VERSION, RecordError};

/// A device record that was read, its CRC-32 and version known to be right.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredRecord {
    /// The record.
    pub record: DeviceRecord,
    /// The version of its body.
    pub version: u16,
    /// Its length, bytes.
    pub bytes: usize,
    /// Its CRC-32, the last four bytes.
    pub crc: u32,
}

/// Why a file is not a device record.
#[derive(Debug, Error)]
pub enum StoredRecordError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Its bytes are no record.
    #[error("{}: {reason}", path.display())]
    Bytes {
        /// The file.
        path: PathBuf,
        /// What is wrong with them.
        reason: RecordError,
    },
}

impl StoredRecord {
    /// Reads a record.
    ///
    /// # Errors
    /// [`StoredRecordError`], by what is wrong first: file, form, version, CRC, body.
    pub fn read(path: &Path) -> Result<Self, StoredRecordError> {
        let cannot = |source| StoredRecordError::Read { path: path.to_owned(), source };
        let mut bytes = Vec::new();
        // A longer file is something else, whatever it begins with.
        File::open(path).map_err(cannot)?.take(MAX_RECORD_BYTES as u64).read_to_end(&mut bytes).map_err(cannot)?;
        let record = DeviceRecord::decode(&bytes)
            .map_err(|reason| StoredRecordError::Bytes { path: path.to_owned(), reason })?;
        let crc = bytes.last_chunk().map_or(0, |crc| u32::from_le_bytes(*crc));
        Ok(Self { record, version: RECORD_VERSION, bytes: bytes.len(), crc })
    }
}
