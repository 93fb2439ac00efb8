//! Where the record is kept between power cycles.

use heapless::Vec;
use zerorate_core::record::MAX_RECORD_BYTES;

/// A store for one record: flash on a board, memory in a simulated one.
pub trait RecordStore {
    /// The stored record's bytes; empty where there is none.
    fn bytes(&self) -> &[u8];

    /// Replaces the stored record; on an error the old one is still there.
    ///
    /// # Errors
    /// [`StoreFailed`].
    fn commit(&mut self, bytes: &[u8]) -> Result<(), StoreFailed>;
}

/// The record could not be stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StoreFailed;

/// A store in memory: lost with the power, as on the simulated bench's bare board.
#[derive(Debug, Clone, Default)]
pub struct MemoryStore {
    bytes: Vec<u8, MAX_RECORD_BYTES>,
}

impl RecordStore for MemoryStore {
    fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    fn commit(&mut self, bytes: &[u8]) -> Result<(), StoreFailed> {
        let replacement = Vec::from_slice(bytes).map_err(|_| StoreFailed)?;
        self.bytes = replacement;
        Ok(())
    }
}
