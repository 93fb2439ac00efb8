//! What can go wrong with a recording, and what is left of it.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Why a recording cannot be written or read.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The file cannot be made.
    #[error("{}: the recording cannot be started: {reason}: choose a folder that exists and can be written", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// A group cannot be written.
    #[error("{}: the recording cannot go on: {reason}: the {groups} groups before it are kept there", path.display())]
    Write {
        /// The stream.
        path: PathBuf,
        /// Whole groups in it.
        groups: u64,
        /// What the system said.
        reason: String,
    },
    /// The stream cannot be turned into Parquet.
    #[error("{}: cannot be finished: {reason}: all {groups} groups are kept in {}", path.display(), stream.display())]
    Finish {
        /// The Parquet file.
        path: PathBuf,
        /// The stream.
        stream: PathBuf,
        /// Whole groups in it.
        groups: u64,
        /// What the system said.
        reason: String,
    },
    /// The file cannot be opened or read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file is something else.
    #[error("{}: not a recording: neither Parquet nor an Arrow stream with a recording's columns", path.display())]
    NotARecording {
        /// The file.
        path: PathBuf,
    },
    /// The recording was cut off so early that no header is whole.
    #[error("{}: cut off before its header was whole: nothing can be recovered; record again", path.display())]
    NothingWhole {
        /// The file.
        path: PathBuf,
    },
    /// The file's content contradicts itself.
    #[error("{}: damaged: {reason}: take another copy or record again", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        reason: String,
    },
    /// The recording was written by another version's schema.
    #[error("{}: written in schema version {found}; this program reads version {}: use the program that wrote it, or a later one", path.display(), super::SCHEMA_VERSION)]
    UnknownVersion {
        /// The file.
        path: PathBuf,
        /// The version in the file.
        found: String,
    },
}
