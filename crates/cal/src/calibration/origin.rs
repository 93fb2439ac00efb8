//! The recordings that a calibration rests on, by name and hash.

use std::fmt::Write;
use std::io::{self, Read};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::source::Source;

/// Bytes read at a time.
const CHUNK: usize = 1 << 16;

/// One recording or log that a calibration rests on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// What it is a recording of, as `full-temperature`, `trim-sweep`, `log`.
    pub content: String,
    /// The file's name, without its folder: the file moves, its hash stays.
    pub file: String,
    /// SHA-256 of the file, 64 hexadecimal digits.
    pub sha256: String,
}

impl Origin {
    /// A finished recording or a log.
    ///
    /// # Errors
    /// When the source cannot be read.
    pub fn of(content: impl Into<String>, source: &Source) -> io::Result<Self> {
        Ok(Self { content: content.into(), file: source.short_name().to_owned(), sha256: sha256(source)? })
    }
}

/// SHA-256 (FIPS 180-4) of a source, 64 hexadecimal digits, in bounded memory.
///
/// # Errors
/// When the source cannot be read.
pub fn sha256(source: &Source) -> io::Result<String> {
    let mut file = source.open()?;
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
