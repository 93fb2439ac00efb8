//! The recordings that a calibration rests on, by name and hash.

use std::fmt::Write;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::CalibrationError;

/// Bytes read at a time.
const CHUNK: usize = 1 << 16;

/// One recording or log.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Source {
    /// What it is a recording of, as `full-temperature`, `trim-sweep`, `log`.
    pub content: String,
    /// The file's name, without its folder: the file moves, its hash stays.
    pub file: String,
    /// SHA-256 of the file, 64 hexadecimal digits.
    pub sha256: String,
}

impl Source {
    /// A finished recording or a log.
    ///
    /// # Errors
    /// [`CalibrationError::Read`].
    pub fn of_file(content: impl Into<String>, path: &Path) -> Result<Self, CalibrationError> {
        let sha256 = sha256_of_file(path).map_err(|source| CalibrationError::Read { path: path.to_owned(), source })?;
        let file = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        Ok(Self { content: content.into(), file, sha256 })
    }
}

/// SHA-256 (FIPS 180-4) of a file, 64 hexadecimal digits, in bounded memory.
///
/// # Errors
/// When the file cannot be read.
pub fn sha256_of_file(path: &Path) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut hash = Sha256::new();
    let mut chunk = vec![0; CHUNK];
    loop {
        match file.read(&mut chunk) {
            Ok(0) => break,
            Ok(read) => hash.update(&chunk[..read]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(hash.finalize().iter().fold(String::with_capacity(64), |mut digits, byte| {
        // Writing to a string cannot fail.
        let _ = write!(digits, "{byte:02x}");
        digits
    }))
}
