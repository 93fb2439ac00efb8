//! Why a calibration cannot be read or written.

use std::io;

use thiserror::Error;

use super::{CREATED_BY, OLDEST_SCHEMA, SCHEMA};
use crate::source::{Faulty, in_quotes};

/// Why a calibration cannot be read, with its name.
pub type CalibrationError = Faulty<CalibrationFault>;

/// Why a calibration cannot be read or made.
#[derive(Debug, Error)]
pub enum CalibrationFault {
    /// A file cannot be read.
    #[error("cannot be read: {0}")]
    Read(#[from] io::Error),
    /// The file is something else.
    #[error(
        "this is not a calibration (JSON with \"schema\" and \"kind\"): give the calibration.json that calibrate or fit wrote"
    )]
    NotOne,
    /// A schema that this code does not know.
    #[error(
        "schema {found}, and this program ({CREATED_BY}) knows schemas {OLDEST_SCHEMA} to {SCHEMA}: {}",
        if *found > u64::from(SCHEMA) { "use a newer zerorate" } else { "calibrate or fit again" }
    )]
    UnknownSchema {
        /// The schema found.
        found: u64,
    },
    /// The text is no JSON, or a field is missing or makes no sense.
    #[error("line {line}, column {column}: {what}: restore the file, or calibrate again")]
    Malformed {
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
}

impl From<serde_json::Error> for CalibrationFault {
    fn from(error: serde_json::Error) -> Self {
        // The place is said in front, as compilers do.
        let text = error.to_string();
        let what = in_quotes(text.split(" at line ").next().unwrap_or(&text));
        Self::Malformed { line: error.line(), column: error.column(), what }
    }
}
