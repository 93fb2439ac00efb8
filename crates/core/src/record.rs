//! The stored calibration as the device takes it: the laws in integers, with identity, version and CRC.
//!
//! On the wire and in flash a record is `"ZRCR"`, the version (u16, little-endian), the body in postcard, and a
//! CRC-32 (IEEE) of all before it. The version changes when the body's meaning does; a device refuses one it does
//! not know, and runs uncompensated.
//!
//! The host makes it from models in f64 ([`AxisModel`]).

mod model;

use heapless::String;
use serde::{Deserialize, Serialize};

use crate::board::BoardNumbers;
use crate::checksum::CRC_32;
use crate::compensate::{AxisLaw, LawNumbers, LawRefused, Mode};
use crate::units::{Axis, TemperatureScale};

pub use model::{AxisModel, HistoryModel};

/// The version of the body that this code reads and writes.
///
/// 1: static laws. 2: each axis may carry a history with its group period. 3: laws in integers, no models in f64.
/// 4: readings from the one aimed at; what the board is made of. 5: a term of a history says how much of what drifts is behind.
pub const RECORD_VERSION: u16 = 5;
/// More bytes than any record takes.
pub const MAX_RECORD_BYTES: usize = 6144;

const MAGIC: [u8; 4] = *b"ZRCR";

/// A unit's serial, up to 32 bytes of UTF-8.
pub type UnitSerial = String<32>;

/// What a board puts in its serial for what it cannot read there. No record is of such a unit.
pub const UNREADABLE: char = '?';

/// One axis's part of a record.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct AxisRecord {
    /// The law, as it was read: [`law`](Self::law) checks it.
    pub law: LawNumbers,
    /// What the axis does when the board starts.
    pub start_up_mode: Mode,
}

impl AxisRecord {
    /// The law as the device runs it, checked.
    ///
    /// # Errors
    /// [`LawRefused`], with the part of it that cannot be run.
    pub fn law(&self) -> Result<AxisLaw, LawRefused> {
        AxisLaw::from_numbers(&self.law)
    }
}

/// The calibration of one unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DeviceRecord {
    /// The unit it was measured on; a device of another serial refuses it.
    pub unit: UnitSerial,
    /// What a temperature code stands for on this board.
    pub temperature_scale: TemperatureScale,
    /// Its converter and its temperature sensors.
    pub board: BoardNumbers,
    /// The axes, X then Y.
    pub axes: [AxisRecord; 2],
}

/// Why bytes are not a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum RecordError {
    /// They do not begin as a record does, or are too few.
    NotARecord,
    /// A version that this code does not know.
    UnknownVersion {
        /// The version found.
        found: u16,
    },
    /// The CRC-32 does not match: cut or changed.
    Damaged,
    /// The CRC-32 matches and the body still makes no sense.
    Malformed,
    /// The buffer is too small for the record.
    TooLong,
}

impl core::fmt::Display for RecordError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotARecord => f.write_str("this is not a device record (it does not begin with ZRCR)"),
            Self::UnknownVersion { found } => write!(
                f,
                "a device record of version {found}; this program knows version {RECORD_VERSION}: make the record anew from calibration.json"
            ),
            Self::Damaged => f.write_str("the device record is damaged (its CRC-32 does not match): write it again"),
            Self::Malformed => f.write_str("the device record's body makes no sense although its CRC-32 matches"),
            Self::TooLong => f.write_str("the device record is longer than the buffer for it"),
        }
    }
}

impl core::error::Error for RecordError {}

/// What a unit runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Laws {
    /// The laws of its axes, X then Y.
    pub axes: [AxisLaw; 2],
    /// What they do when the board starts.
    pub start_up_modes: [Mode; 2],
    /// What its readings are held against.
    pub board: BoardNumbers,
}

/// Why a unit does not run a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordRefused {
    /// The bytes are no record.
    Bytes(RecordError),
    /// It is another unit's.
    OtherUnit,
    /// A law of it cannot be run, or no board has such numbers.
    Law,
}

/// What stands before a record's axes.
#[derive(Deserialize)]
struct Head {
    unit: UnitSerial,
    #[allow(dead_code)] // it is the host's
    temperature_scale: TemperatureScale,
    board: BoardNumbers,
}

/// The laws in a record's bytes, checked in every respect, for the unit of a serial; without one for any.
///
/// An axis is read after the other: a whole record and its laws together are a sixth of a board's memory.
///
/// # Errors
/// [`RecordRefused`].
pub fn laws_for(serial: Option<&[u8]>, bytes: &[u8]) -> Result<Laws, RecordRefused> {
    let body = body_of(bytes).map_err(RecordRefused::Bytes)?;
    let (Head { unit, board, .. }, axes) = postcard::take_from_bytes(body).map_err(|_| MALFORMED)?;
    if serial.is_some_and(|serial| serial != unit.as_bytes() || unit.contains(UNREADABLE)) {
        return Err(RecordRefused::OtherUnit);
    }
    if !board.are_sound() {
        return Err(RecordRefused::Law);
    }
    let mut axes = axes;
    let (x, x_mode) = next_law(&mut axes)?;
    let (y, y_mode) = next_law(&mut axes)?;
    Ok(Laws { axes: [x, y], start_up_modes: [x_mode, y_mode], board })
}

const MALFORMED: RecordRefused = RecordRefused::Bytes(RecordError::Malformed);

/// The law of the axis that the bytes begin with, and its mode at the start; what follows is left.
#[inline(never)]
fn next_law(bytes: &mut &[u8]) -> Result<(AxisLaw, Mode), RecordRefused> {
    let (axis, rest): (AxisRecord, _) = postcard::take_from_bytes(bytes).map_err(|_| MALFORMED)?;
    *bytes = rest;
    Ok((axis.law().map_err(|_| RecordRefused::Law)?, axis.start_up_mode))
}

/// What stands between a record's version and its CRC.
fn body_of(bytes: &[u8]) -> Result<&[u8], RecordError> {
    let head = MAGIC.len() + 2;
    if bytes.len() < head + 4 || !bytes.starts_with(&MAGIC) {
        return Err(RecordError::NotARecord);
    }
    let (content, crc) = bytes.split_at(bytes.len() - 4);
    let found = u16::from_le_bytes([content[4], content[5]]);
    // The version comes first: an unknown one may keep its CRC elsewhere.
    if found != RECORD_VERSION {
        return Err(RecordError::UnknownVersion { found });
    }
    if CRC_32.checksum(content).to_le_bytes() != crc {
        return Err(RecordError::Damaged);
    }
    Ok(&content[head..])
}

impl DeviceRecord {
    /// One axis's part.
    #[must_use]
    pub const fn axis(&self, axis: Axis) -> &AxisRecord {
        &self.axes[axis.index()]
    }

    /// Writes the record and returns its bytes.
    ///
    /// # Errors
    /// [`RecordError::TooLong`].
    pub fn encode<'b>(&self, buffer: &'b mut [u8]) -> Result<&'b [u8], RecordError> {
        let head = MAGIC.len() + 2;
        if buffer.len() < head + 4 {
            return Err(RecordError::TooLong);
        }
        buffer[..MAGIC.len()].copy_from_slice(&MAGIC);
        buffer[MAGIC.len()..head].copy_from_slice(&RECORD_VERSION.to_le_bytes());
        let room = buffer.len() - 4;
        let body = postcard::to_slice(self, &mut buffer[head..room]).map_err(|_| RecordError::TooLong)?.len();
        let end = head + body;
        let crc = CRC_32.checksum(&buffer[..end]).to_le_bytes();
        buffer[end..end + 4].copy_from_slice(&crc);
        Ok(&buffer[..end + 4])
    }

    /// Reads a record.
    ///
    /// # Errors
    /// [`RecordError`], by what is wrong first: form, version, CRC, body.
    pub fn decode(bytes: &[u8]) -> Result<Self, RecordError> {
        postcard::from_bytes(body_of(bytes)?).map_err(|_| RecordError::Malformed)
    }
}

#[cfg(test)]
mod tests;
