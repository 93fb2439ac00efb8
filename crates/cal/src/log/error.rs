//! What can be wrong with a log, and what to do about it.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::recording::RecordingError;
use crate::table::TableError;

/// Why a log cannot be read.
#[derive(Debug, Error)]
pub enum LogError {
    /// The file cannot be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A table cannot be read.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A recording of the bench cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A row's time is before that of the row above it.
    #[error(
        "{}: row {row}: column '{column}' runs backwards, from {before} to {after}: the log is damaged, or several were joined: split it there",
        path.display()
    )]
    TimeBackwards {
        /// The file.
        path: PathBuf,
        /// The row, from 1, the header not counted.
        row: u64,
        /// The time column's name.
        column: String,
        /// The time above.
        before: f64,
        /// The time in the row.
        after: f64,
    },
    /// An autopilot's log of a kind that is not read.
    #[error("{}: {what}", path.display())]
    Autopilot {
        /// The file.
        path: PathBuf,
        /// What is the matter, and what to do.
        what: String,
    },
}
