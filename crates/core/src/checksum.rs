//! The CRC-32 of frames, records and the store: one table for all of them.

use crc::{CRC_32_ISO_HDLC, Crc};

/// CRC-32 as in Ethernet and zip (reflected 0x04C11DB7, all ones before and after).
pub static CRC_32: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);
