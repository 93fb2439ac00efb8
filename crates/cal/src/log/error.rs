//! What can be wrong with a log, and what to do about it.

use std::io;

use thiserror::Error;

use crate::recording::RecordingFault;
use crate::source::Faulty;
use crate::table::TableFault;

/// Why a log cannot be read, with its name.
pub type LogError = Faulty<LogFault>;

/// Why a log cannot be read.
#[derive(Debug, Error)]
pub enum LogFault {
    /// The file cannot be opened or read.
    #[error("cannot be read: {0}")]
    Read(#[from] io::Error),
    /// A table cannot be read.
    #[error(transparent)]
    Table(#[from] TableFault),
    /// A recording of the bench cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingFault),
    /// A row's time is before that of the row above it.
    #[error(
        "row {row}: column '{column}' runs backwards, from {before} to {after}: the log is damaged, or several were joined: split it there"
    )]
    TimeBackwards {
        /// The row, from 1, the header not counted.
        row: u64,
        /// The time column's name.
        column: String,
        /// The time above.
        before: f64,
        /// The time in the row.
        after: f64,
    },
}

impl LogFault {
    /// What is wrong with a table or a recording is wrong with the log.
    pub(crate) fn named<F: Into<Self> + std::fmt::Display>(error: Faulty<F>) -> LogError {
        Faulty { name: error.name, fault: error.fault.into() }
    }
}
