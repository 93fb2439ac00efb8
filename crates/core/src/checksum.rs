//! The CRC-32 of frames, records and the store: one for all of them.

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

/// CRC-32 as in Ethernet and zip (reflected 0x04C11DB7, all ones before and after).
///
/// A bit at a time: a table is 1 KiB of a board's flash, and what is summed here comes over a line of 11 bytes a
/// millisecond, or once at start-up.
pub static CRC_32: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
