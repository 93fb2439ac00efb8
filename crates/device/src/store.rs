//! Where the record is kept between power cycles.
//!
//! A store keeps one record and is read in pieces: a board has no room for a second copy of it in memory.

mod blocking;
mod flash;

pub use flash::{FlashStore, Unusable};

/// A store for one record: flash on a board, memory in a test.
pub trait RecordStore {
    /// What is stored.
    fn stored(&self) -> Stored;

    /// Reads a part of the stored record, from an offset in bytes; returns how many bytes there were, fewer than asked
    /// for at the record's end.
    ///
    /// # Errors
    /// [`StoreFailed`].
    fn read(&mut self, offset: usize, into: &mut [u8]) -> Result<usize, StoreFailed>;

    /// Replaces the stored record. The old one is there until the new one is whole, and stays on an error.
    ///
    /// # Errors
    /// [`StoreFailed`].
    fn commit(&mut self, record: &[u8]) -> Result<(), StoreFailed>;
}

/// What a store holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stored {
    /// Nothing was ever stored whole.
    Blank,
    /// A whole record of so many bytes.
    Whole(u16),
    /// The last record is unfinished or damaged; the one before it is whole and has so many bytes.
    Older(u16),
    /// A record was stored, and none is whole any more.
    Damaged,
    /// The flash does not answer.
    Unreachable,
}

impl Stored {
    /// The length of the record that can be read, bytes; 0 where there is none.
    #[must_use]
    pub const fn length(self) -> u16 {
        match self {
            Self::Whole(length) | Self::Older(length) => length,
            Self::Blank | Self::Damaged | Self::Unreachable => 0,
        }
    }
}

/// The store could not be read or written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StoreFailed;
