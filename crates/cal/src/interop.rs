//! Formats of autopilots and of other programs. What these call things stays in here.

mod dataflash;
pub mod export;
mod streams;
mod ulog;
mod window;

use std::fs::File;
use std::path::Path;

use crate::log::{Ending, LogError, Sink};

/// An autopilot's format of logs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// PX4's ULog (docs.px4.io, "ULog File Format").
    ULog,
    /// ArduPilot's DataFlash (ardupilot.org, "DataFlash Logs").
    DataFlash,
}

impl Format {
    /// The log's name for people.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::ULog => "a PX4 ULog",
            Self::DataFlash => "an ArduPilot DataFlash log",
        }
    }

    /// The format in which this autopilot takes parameters, as `zerorate export --format` has it.
    #[must_use]
    pub fn parameters(self) -> &'static str {
        match self {
            Self::ULog => "px4",
            Self::DataFlash => "ardupilot",
        }
    }
}

/// The format that a file's first bytes tell, if it is an autopilot's.
#[must_use]
pub fn recognise(start: &[u8]) -> Option<Format> {
    if start.starts_with(&ulog::MAGIC) {
        Some(Format::ULog)
    } else if dataflash::recognises(start) {
        Some(Format::DataFlash)
    } else {
        None
    }
}

/// Reads a log once from beginning to end.
pub(crate) fn read(path: &Path, format: Format, sink: &mut dyn Sink) -> Result<Ending, LogError> {
    let unreadable = |source| LogError::Read { path: path.to_owned(), source };
    let file = File::open(path).map_err(unreadable)?;
    match format {
        Format::ULog => ulog::read(file, sink).map_err(unreadable),
        Format::DataFlash => dataflash::read(file, sink).map_err(unreadable),
    }
}
