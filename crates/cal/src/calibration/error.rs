//! Why a calibration cannot be read or written.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::{CREATED_BY, OLDEST_SCHEMA, SCHEMA};

/// Why a calibration cannot be read or written.
#[derive(Debug, Error)]
pub enum CalibrationError {
    /// A file cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file is something else.
    #[error(
        "{}: this is not a calibration (JSON with a number under \"schema\"): give the calibration.json that calibrate or fit wrote",
        path.display()
    )]
    NotOne {
        /// The file.
        path: PathBuf,
    },
    /// A schema that this code does not know.
    #[error(
        "{}: schema {found}, and this program ({CREATED_BY}) knows schemas {OLDEST_SCHEMA} to {SCHEMA}: {}",
        path.display(),
        if *found > u64::from(SCHEMA) { "use a newer zerorate" } else { "calibrate or fit again" }
    )]
    UnknownSchema {
        /// The file.
        path: PathBuf,
        /// The schema found.
        found: u64,
    },
    /// The text is no JSON, or a field is missing or makes no sense.
    #[error("{}:{line}:{column}: {what}: restore the file, or calibrate again", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The column, from 1.
        column: usize,
        /// What is wrong there.
        what: String,
    },
    /// The log was rejected.
    #[error("the log was rejected, and no calibration comes of it: {reasons}")]
    Rejected {
        /// The reasons.
        reasons: String,
    },
    /// The calibration has numbers that a file cannot hold.
    #[error("the calibration cannot be written, for it would not read back: {what}")]
    Unwritable {
        /// What is wrong with it.
        what: String,
    },
    /// A file cannot be written.
    #[error("{}: cannot be written: {source}: an earlier file there is as it was", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

impl CalibrationError {
    pub(super) fn malformed(path: &Path, error: &serde_json::Error) -> Self {
        // The place is said in front, as compilers do.
        let text = error.to_string();
        let what = text.split(" at line ").next().unwrap_or(&text).to_owned();
        Self::Malformed { path: path.to_owned(), line: error.line(), column: error.column(), what }
    }
}
