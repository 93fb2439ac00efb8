//! The recordings that a calibration rests on, by name and hash.

use std::fmt::Write;
use std::io::{self, Read};
use std::time::SystemTime;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::recording::utc::rfc3339;
use crate::source::Source;

/// Bytes read at a time.
const CHUNK: usize = 1 << 16;

/// One recording or log that a calibration rests on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    /// What it is a recording of, as `full-temperature`, `trim-sweep`, `log`; an autopilot's log is a `px4-log` or an
    /// `ardupilot-log`.
    pub content: String,
    /// The file's name, without its folder: the file moves, its hash stays.
    pub file: String,
    /// SHA-256 of the file, 64 hexadecimal digits.
    pub sha256: String,
    /// When its first row was taken, RFC 3339 in UTC; of few logs, for few know their own date.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub started: Option<String>,
    /// When a log's file was last changed, RFC 3339 in UTC.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub changed: Option<String>,
    /// What a log's rows are known by, whatever form they are kept in: the hashes of some runs of 64 successive rows, 16
    /// hexadecimal digits each, and for each sensor the signs of its noise.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rows: Vec<String>,
}

impl Origin {
    /// A finished recording or a log.
    ///
    /// # Errors
    /// When the source cannot be read.
    pub fn of(content: impl Into<String>, source: &Source) -> io::Result<Self> {
        Ok(Self {
            content: content.into(),
            file: source.short_name().to_owned(),
            sha256: sha256(source)?,
            started: None,
            changed: None,
            rows: Vec::new(),
        })
    }

    /// A log, by the autopilot's format if it is an autopilot's.
    ///
    /// # Errors
    /// When the source cannot be read.
    pub fn of_log(autopilot: Option<imu_logs::Format>, source: &Source) -> io::Result<Self> {
        let log = Self::of(autopilot.map_or("log", content_of), source)?;
        Ok(Self { changed: source.changed().map(rfc3339), ..log })
    }

    /// The same with the time at which its first row was taken, where that is known.
    #[must_use]
    pub fn started_at(self, started: Option<SystemTime>) -> Self {
        Self { started: started.map(rfc3339), ..self }
    }

    /// The format of the autopilot that wrote it, if one did.
    #[must_use]
    pub fn autopilot(&self) -> Option<imu_logs::Format> {
        [imu_logs::Format::ULog, imu_logs::Format::DataFlash].into_iter().find(|f| self.content == content_of(*f))
    }
}

fn content_of(log: imu_logs::Format) -> &'static str {
    match log {
        imu_logs::Format::ULog => "px4-log",
        imu_logs::Format::DataFlash => "ardupilot-log",
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
