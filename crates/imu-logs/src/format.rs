//! The formats, told by content.

use std::io::{self, Read, Seek};

use crate::{Ending, Sink, dataflash, ulog};

/// As many bytes from a file's beginning as [`recognise`] needs.
pub const START_BYTES: usize = 8;

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
}

/// The format that a file's first bytes tell, if it is one of these.
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

/// Reads a log once, from the reader's beginning to its end. What is whole of a cut or damaged log is read, and the
/// remarks say what was lost.
///
/// # Errors
/// Where the reader fails.
pub fn read(file: impl Read + Seek, format: Format, sink: &mut dyn Sink) -> io::Result<Ending> {
    match format {
        Format::ULog => ulog::read(file, sink),
        Format::DataFlash => dataflash::read(file, sink),
    }
}
