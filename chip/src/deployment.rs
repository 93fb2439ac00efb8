//! How a record comes to a board: in parts, and then the commit.

use anyhow::{Context, Result};
use zerorate_core::record::{DeviceRecord, MAX_RECORD_BYTES};
use zerorate_core::wire::{CHUNK, Request};

/// The bytes of a record.
///
/// # Errors
/// There is no such record.
pub fn encoded(record: &DeviceRecord) -> Result<Vec<u8>> {
    let mut buffer = [0; MAX_RECORD_BYTES];
    let bytes = record.encode(&mut buffer).ok().context("a record that cannot be")?;
    Ok(bytes.to_vec())
}

/// The requests that write a record's bytes, and at the end the one that commits it.
///
/// # Errors
/// It is longer than a record can be.
pub fn deployment(bytes: &[u8]) -> Result<Vec<Request>> {
    let write = |(part, chunk): (usize, &[u8])| {
        let offset = u16::try_from(part * CHUNK)?;
        Ok(Request::WriteCalibration { offset, bytes: chunk.iter().copied().collect() })
    };
    let mut requests: Vec<Request> = bytes.chunks(CHUNK).enumerate().map(write).collect::<Result<_>>()?;
    requests.push(Request::CommitCalibration { length: u16::try_from(bytes.len())? });
    Ok(requests)
}
