//! The messages.

use heapless::Vec;
use serde::{Deserialize, Serialize};

/// The version of these messages; board and host say theirs in [`Request::Hello`] and [`Board`].
pub const VERSION: u16 = 3;
/// The longest request, its length left off.
pub const MAX_REQUEST: usize = 600;
/// The most operations of one SPI transaction.
pub const MAX_TRANSACTION: usize = 8;
/// Bytes of a unit's serial in [`Board`].
pub const SERIAL_BYTES: usize = 32;

/// A part on the board's SPI.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Bus {
    /// The acquisition port.
    Port,
    /// The potentiometer.
    Potentiometer,
}

/// An operation of an SPI transaction, chip select low from the first to the last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Transfer<'a> {
    /// Bytes out; what comes back is dropped.
    Write(&'a [u8]),
    /// So many bytes in.
    Read(u16),
    /// Bytes out, as many in.
    Exchange(&'a [u8]),
    /// A pause, nanoseconds.
    Delay(u32),
}

/// How far the line between board and bench has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Poll {
    /// Bytes that the board has received and acted on since it started.
    pub received: u32,
    /// Bytes that it has sent.
    pub sent: u32,
}

/// What the board asks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Request<'a> {
    /// The first: it has started. Answered with a [`Board`].
    Hello {
        /// [`VERSION`] of the board.
        version: u16,
    },
    /// A whole SPI transaction. Answered with the bytes of its reads and exchanges, in order.
    Transaction {
        /// The part.
        bus: Bus,
        /// What is done while it is selected.
        transfers: Vec<Transfer<'a>, MAX_TRANSACTION>,
    },
    /// Lets time pass on the bench.
    Delay {
        /// Nanoseconds.
        ns: u32,
    },
    /// Reads from the flash. Answered with the bytes.
    FlashRead {
        /// Where.
        offset: u32,
        /// How many.
        length: u16,
    },
    /// Writes to the flash: bits can only be cleared.
    FlashWrite {
        /// Where.
        offset: u32,
        /// What.
        bytes: &'a [u8],
    },
    /// Erases whole sectors of the flash.
    FlashErase {
        /// From this offset.
        from: u32,
        /// Up to this one.
        to: u32,
    },
    /// Nothing left to do: has data ready risen, or a second gone by?
    Poll(Poll),
    /// The firmware has panicked; it restarts.
    Panicked {
        /// The source file.
        file: &'a str,
        /// The line in it.
        line: u32,
    },
}

/// The first byte of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Answer {
    /// Done; the bytes that were asked for follow. To a poll: bytes of the host are on their way, sleep until they come.
    Done = 0,
    /// It could not be done; nothing follows.
    Failed = 1,
    /// To a poll: data ready has risen.
    SetReady = 2,
    /// To a poll: a second has gone by on the bench, whose time is the board's.
    Second = 3,
}

impl Answer {
    /// The answer of a byte.
    #[must_use]
    pub const fn of(byte: u8) -> Option<Self> {
        match byte {
            0 => Some(Self::Done),
            1 => Some(Self::Failed),
            2 => Some(Self::SetReady),
            3 => Some(Self::Second),
            _ => None,
        }
    }
}

/// What the host says in answer to [`Request::Hello`]: what a real board has been given when it was built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Board {
    /// [`VERSION`] of the host.
    pub version: u16,
    /// Scans a set.
    pub set_length: u16,
    /// Microseconds from scan to scan.
    pub scan_period_us: u32,
    /// Conversions that a sample is the mean of.
    pub oversampling: u8,
    /// The unit's serial, UTF-8, filled up with zeros.
    pub serial: [u8; SERIAL_BYTES],
}

impl Board {
    /// Bytes of its form.
    pub const BYTES: usize = 9 + SERIAL_BYTES;

    /// As bytes, little-endian.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let mut bytes = [0; Self::BYTES];
        bytes[..2].copy_from_slice(&self.version.to_le_bytes());
        bytes[2..4].copy_from_slice(&self.set_length.to_le_bytes());
        bytes[4..8].copy_from_slice(&self.scan_period_us.to_le_bytes());
        bytes[8] = self.oversampling;
        bytes[9..].copy_from_slice(&self.serial);
        bytes
    }

    /// From bytes.
    #[must_use]
    pub fn from_bytes(bytes: &[u8; Self::BYTES]) -> Self {
        let mut serial = [0; SERIAL_BYTES];
        serial.copy_from_slice(&bytes[9..]);
        Self {
            version: u16::from_le_bytes([bytes[0], bytes[1]]),
            set_length: u16::from_le_bytes([bytes[2], bytes[3]]),
            scan_period_us: u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]),
            oversampling: bytes[8],
            serial,
        }
    }

    /// The unit's serial.
    #[must_use]
    pub fn serial(&self) -> &str {
        let end = self.serial.iter().position(|&byte| byte == 0).unwrap_or(SERIAL_BYTES);
        core::str::from_utf8(&self.serial[..end]).unwrap_or("")
    }
}

impl<'a> Request<'a> {
    /// Reads a request, its length left off; `None` where the bytes are none of this version.
    #[must_use]
    pub fn decode(bytes: &'a [u8]) -> Option<Self> {
        postcard::from_bytes(bytes).ok()
    }

    /// The request with its length before it, in `buffer`; `None` when it does not fit.
    pub fn encode<'b>(&self, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
        let (head, body) = buffer.split_first_chunk_mut::<2>()?;
        let length = postcard::to_slice(self, body).ok()?.len();
        *head = u16::try_from(length).ok()?.to_le_bytes();
        buffer.get(..2 + length)
    }
}
