//! What can go wrong with a recording, and what is left of it.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use zerorate_source::Faulty;

/// Why a recording cannot be read, with its name.
pub type RecordingError = Faulty<RecordingFault>;

/// Why a recording cannot be read.
#[derive(Debug, Error)]
pub enum RecordingFault {
    /// The file cannot be opened or read.
    #[error("cannot be read: {0}")]
    Read(#[from] io::Error),
    /// The file is something else.
    #[error("not a recording: neither Parquet nor an Arrow stream with a recording's columns")]
    NotARecording,
    /// The file is something else than was asked for.
    #[error("not a chamber's recording: `zerorate chamber` makes one")]
    NotAChambers,
    /// A chamber's recording of another version.
    #[error("a chamber's recording of schema version {found}; this program reads version 1: use a later one")]
    UnknownChamberVersion {
        /// The version in the file.
        found: String,
    },
    /// The recording was cut off so early that no header is whole.
    #[error("cut off before its header was whole: nothing can be recovered; record again")]
    NothingWhole,
    /// The file's content contradicts itself.
    #[error("damaged: {reason}: take another copy or record again")]
    Damaged {
        /// What does not fit.
        reason: String,
    },
    /// The recording was written by another version's schema.
    #[error(
        "written in schema version {found}; this program reads versions 1 to {}: use the program that wrote it, or a later one",
        super::SCHEMA_VERSION
    )]
    UnknownVersion {
        /// The version in the file.
        found: String,
    },
}

impl RecordingFault {
    /// What a reader of Arrow or Parquet says of a damaged file.
    pub(super) fn damaged(reason: impl ToString) -> Self {
        Self::Damaged { reason: reason.to_string() }
    }
}

/// Why a recording cannot be written.
#[derive(Debug, Error)]
pub enum WriteError {
    /// The file cannot be made.
    #[error("{}: the recording cannot be started: {reason}: choose a folder that exists and can be written", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// Another program writes it.
    #[error("{}: another run writes its recording there: wait until it is over, or give this one another name", path.display())]
    InUse {
        /// The stream.
        path: PathBuf,
    },
    /// A group, or a chamber's moment, cannot be written.
    #[error("{}: the recording cannot go on: {reason}: what was recorded before it is kept there ({of}: {batches})", path.display())]
    Write {
        /// The stream.
        path: PathBuf,
        /// What is written one after the other.
        of: &'static str,
        /// How many are whole.
        batches: u64,
        /// What the system said.
        reason: String,
    },
    /// The stream cannot be turned into Parquet.
    #[error("{}: cannot be finished: {reason}: all of it is kept in {} ({of}: {batches})", path.display(), stream.display())]
    Finish {
        /// The Parquet file.
        path: PathBuf,
        /// The stream.
        stream: PathBuf,
        /// What is written one after the other.
        of: &'static str,
        /// How many are whole.
        batches: u64,
        /// What the system said.
        reason: String,
    },
}
