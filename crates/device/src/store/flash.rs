//! Calibration records in NOR flash, two generations of them, power cuts survived.
//!
//! The range is two banks, each a sequential-storage queue of its own with one record in it: the record in pieces, and as
//! the last small item the head: generation, length and CRC-32 of the whole. A commit erases the bank that does not hold
//! the record in use, and writes there. Only a bank whose head agrees with its pieces is believed, the higher generation
//! first. The bank in use is not touched, so whatever a cut leaves in the other one, in the middle of a word or of an
//! erase, does not matter: until the last byte of the new head is in, the old record is the one that is found.

use core::ops::Range;

use embedded_storage::nor_flash::NorFlash;
use sequential_storage::Error;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::queue::{QueueConfig, QueueStorage};
use zerorate_core::checksum::CRC_32;
use zerorate_core::record::MAX_RECORD_BYTES;

use super::blocking::{Blocking, now};
use super::{RecordStore, StoreFailed, Stored};

/// Bytes of a record in one item: with its kind a whole number of words of up to 32 bytes.
const PIECE: usize = 255;
/// An item as it is read and written: its kind and a piece.
const ITEM: usize = 1 + PIECE;
/// The most that an item takes in flash: its header of 8 bytes, and both padded to words of up to 32.
const ITEM_IN_FLASH: usize = 32 + ITEM;
/// Bytes that are looked at together for being erased: pages are whole multiples of them.
const ERASE_SEEN: usize = 128;
/// The pieces of the longest record and their head.
const ITEMS: usize = MAX_RECORD_BYTES.div_ceil(PIECE) + 1;
/// An item's first byte.
const KIND_PIECE: u8 = b'P';
const KIND_HEAD: u8 = b'H';
/// Generation, length, CRC-32.
const HEAD_BYTES: usize = 10;

/// A bank as a queue; nothing is kept in memory between calls.
type Bank<'f, F> = QueueStorage<&'f mut Blocking<F>, Cache<Uncached, Uncached, Uncached>>;

/// Why a range of flash cannot be a store.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unusable {
    /// It does not begin and end on pages, its pages do not make two halves, or its words are longer than 32 bytes.
    Geometry,
    /// A half of it does not hold a record of the greatest length.
    TooSmall {
        /// Items of 256 bytes that half of it holds.
        items: usize,
        /// Items that a record takes.
        needed: usize,
    },
}

/// An item in memory; some flash controllers take aligned words only.
#[derive(Clone)]
#[repr(align(4))]
struct Buffer([u8; ITEM]);

/// What the head of a bank says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Head {
    generation: u32,
    length: u16,
    crc: u32,
}

impl Head {
    fn parse(bytes: &[u8]) -> Option<Self> {
        let (generation, rest) = bytes.split_first_chunk::<4>()?;
        let (length, rest) = rest.split_first_chunk::<2>()?;
        let crc = rest.first_chunk::<4>()?;
        let length = u16::from_le_bytes(*length);
        let is_possible = (1..=MAX_RECORD_BYTES).contains(&usize::from(length));
        is_possible.then_some(Self {
            generation: u32::from_le_bytes(*generation),
            length,
            crc: u32::from_le_bytes(*crc),
        })
    }

    fn bytes(self) -> [u8; HEAD_BYTES] {
        let mut bytes = [0; HEAD_BYTES];
        bytes[..4].copy_from_slice(&self.generation.to_le_bytes());
        bytes[4..6].copy_from_slice(&self.length.to_le_bytes());
        bytes[6..].copy_from_slice(&self.crc.to_le_bytes());
        bytes
    }
}

/// What a bank holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Content {
    /// Nothing.
    Nothing,
    /// Something that was never finished, or whose head cannot be read any more.
    Unfinished,
    /// A head, and not what it stands for.
    Damaged { generation: u32 },
    /// A whole record.
    Whole(Head),
}

impl Content {
    const fn generation(self) -> u32 {
        match self {
            Self::Nothing | Self::Unfinished => 0,
            Self::Damaged { generation } | Self::Whole(Head { generation, .. }) => generation,
        }
    }
}

/// The banks in a range of NOR flash.
struct Banks<F> {
    flash: Blocking<F>,
    /// The range's first address and the length of one half of it, bytes.
    start: u32,
    bytes: u32,
}

impl<F: NorFlash> Banks<F> {
    fn open(&mut self, bank: u8) -> Result<Bank<'_, F>, StoreFailed> {
        let start = self.start + u32::from(bank) * self.bytes;
        let config = QueueConfig::try_new(start..start + self.bytes).map_err(|_| StoreFailed)?;
        Ok(QueueStorage::new(&mut self.flash, config, Cache::new_uncached()))
    }
}

/// A store in a range of NOR flash.
pub struct FlashStore<F: NorFlash> {
    banks: Banks<F>,
    /// The item last read or written, its length, and which piece of the record in use it is.
    buffer: Buffer,
    length: usize,
    piece: Option<usize>,
    /// The bank of the record in use.
    bank: u8,
    contents: [Content; 2],
    stored: Stored,
}

impl<F: NorFlash> FlashStore<F> {
    /// The store in a range of flash, with what is found there. It touches nothing outside the range.
    ///
    /// # Errors
    /// [`Unusable`], when the range does not stand on pages or is too small. A flash that does not answer is no error
    /// here: the store says so, and the device runs uncompensated.
    pub fn new(flash: F, range: Range<u32>) -> Result<Self, Unusable> {
        let page = u32::try_from(F::ERASE_SIZE).map_err(|_| Unusable::Geometry)?;
        let bytes = range.end.checked_sub(range.start).ok_or(Unusable::Geometry)?;
        let pages = usize::try_from(bytes / (2 * page)).map_err(|_| Unusable::Geometry)?;
        if !range.start.is_multiple_of(page) || !bytes.is_multiple_of(2 * page) {
            return Err(Unusable::Geometry);
        }
        // Two words of a page mark its state.
        let items = pages * (F::ERASE_SIZE.saturating_sub(2 * F::WRITE_SIZE.max(F::READ_SIZE)) / ITEM_IN_FLASH);
        if items < ITEMS {
            return Err(Unusable::TooSmall { items, needed: ITEMS });
        }
        let mut store = Self {
            banks: Banks { flash: Blocking(flash), start: range.start, bytes: bytes / 2 },
            buffer: Buffer([0; ITEM]),
            length: 0,
            piece: None,
            bank: 0,
            contents: [Content::Nothing; 2],
            stored: Stored::Blank,
        };
        if store.banks.open(0).is_err() {
            return Err(Unusable::Geometry);
        }
        store.stored = store.look().unwrap_or(Stored::Unreachable);
        Ok(store)
    }

    /// Looks what the banks hold, and which of them is to be believed.
    fn look(&mut self) -> Result<Stored, StoreFailed> {
        self.contents = [self.look_at(0)?, self.look_at(1)?];
        let [first, second] = self.contents;
        let newest = u8::from(second.generation() > first.generation());
        for (bank, is_newest) in [(newest, true), (newest ^ 1, false)] {
            if let Content::Whole(head) = self.contents[usize::from(bank)] {
                self.bank = bank;
                // Beside one without a head nobody knows which is the newer.
                let alone = self.contents[usize::from(bank ^ 1)] != Content::Unfinished;
                return Ok(if is_newest && alone { Stored::Whole(head.length) } else { Stored::Older(head.length) });
            }
        }
        let nothing = self.contents == [Content::Nothing; 2];
        Ok(if nothing { Stored::Blank } else { Stored::Damaged })
    }

    /// Goes through a bank from its first item to its head.
    fn look_at(&mut self, bank: u8) -> Result<Content, StoreFailed> {
        // Before the queue looks, which erases what it cannot make out.
        if self.is_erased(bank)? {
            return Ok(Content::Nothing);
        }
        let mut digest = CRC_32.digest();
        let mut length = 0;
        let mut content = Content::Unfinished;
        self.each(bank, |item| {
            match item.split_first() {
                Some((&KIND_PIECE, piece)) => {
                    digest.update(piece);
                    length += piece.len();
                    content = Content::Unfinished;
                }
                Some((&KIND_HEAD, head)) => {
                    let Some(head) = Head::parse(head) else {
                        content = Content::Unfinished;
                        return None;
                    };
                    let is_whole = usize::from(head.length) == length && digest.clone().finalize() == head.crc;
                    let damaged = Content::Damaged { generation: head.generation };
                    content = if is_whole { Content::Whole(head) } else { damaged };
                }
                _ => content = Content::Unfinished,
            }
            None::<()>
        })?;
        Ok(content)
    }

    /// Whether a bank is as an erase leaves it.
    fn is_erased(&mut self, bank: u8) -> Result<bool, StoreFailed> {
        self.piece = None;
        let start = self.banks.start + u32::from(bank) * self.banks.bytes;
        for offset in (start..start + self.banks.bytes).step_by(ERASE_SEEN) {
            let seen = self.buffer.0.get_mut(..ERASE_SEEN).ok_or(StoreFailed)?;
            self.banks.flash.0.read(offset, seen).map_err(|_| StoreFailed)?;
            if seen.iter().any(|&byte| byte != 0xFF) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Shows a bank's items in order, until one of them is what was looked for; it is then in the buffer.
    fn each<T>(&mut self, bank: u8, mut show: impl FnMut(&[u8]) -> Option<T>) -> Result<Option<T>, StoreFailed> {
        self.piece = None;
        let mut queue = self.banks.open(bank)?;
        let mut items = match now(queue.iter()).ok_or(StoreFailed)? {
            Ok(items) => items,
            // What cannot be made sense of holds nothing.
            Err(Error::Corrupted { .. }) => return Ok(None),
            Err(_) => return Err(StoreFailed),
        };
        loop {
            match now(items.next(&mut self.buffer.0)).ok_or(StoreFailed)? {
                Ok(Some(item)) => {
                    if let Some(found) = show(&item) {
                        self.length = item.len();
                        return Ok(Some(found));
                    }
                }
                Ok(None) => return Ok(None),
                // An item longer than ours is none of ours.
                Err(Error::Corrupted { .. } | Error::BufferTooSmall(_)) => return Ok(None),
                Err(_) => return Err(StoreFailed),
            }
        }
    }

    /// Brings a piece of the record in use into the buffer.
    fn load(&mut self, piece: usize) -> Result<&[u8], StoreFailed> {
        if self.piece != Some(piece) {
            let mut left = piece;
            let found = self.each(self.bank, |item| {
                let is_it = left == 0;
                left = left.saturating_sub(1);
                is_it.then(|| item.first() == Some(&KIND_PIECE))
            })?;
            if found != Some(true) {
                return Err(StoreFailed);
            }
            self.piece = Some(piece);
        }
        self.buffer.0.get(1..self.length).ok_or(StoreFailed)
    }

    fn write(&mut self, bank: u8, head: Head, record: &[u8]) -> Result<(), StoreFailed> {
        self.piece = None;
        now(self.banks.open(bank)?.erase_all()).and_then(Result::ok).ok_or(StoreFailed)?;
        for piece in record.chunks(PIECE) {
            self.push(bank, KIND_PIECE, piece)?;
        }
        self.push(bank, KIND_HEAD, &head.bytes())
    }

    fn push(&mut self, bank: u8, kind: u8, content: &[u8]) -> Result<(), StoreFailed> {
        let mut item = Buffer([0; ITEM]);
        let bytes = item.0.get_mut(..=content.len()).ok_or(StoreFailed)?;
        let (first, rest) = bytes.split_first_mut().ok_or(StoreFailed)?;
        *first = kind;
        rest.copy_from_slice(content);
        now(self.banks.open(bank)?.push(bytes, false)).and_then(Result::ok).ok_or(StoreFailed)
    }
}

impl<F: NorFlash> RecordStore for FlashStore<F> {
    fn stored(&self) -> Stored {
        self.stored
    }

    fn read(&mut self, offset: usize, into: &mut [u8]) -> Result<usize, StoreFailed> {
        let end = usize::from(self.stored.length()).min(offset.saturating_add(into.len()));
        let mut at = offset;
        while at < end {
            let piece =
                self.load(at / PIECE)?.get(at % PIECE..).filter(|piece| !piece.is_empty()).ok_or(StoreFailed)?;
            let n = piece.len().min(end - at);
            into[at - offset..at - offset + n].copy_from_slice(&piece[..n]);
            at += n;
        }
        Ok(at - offset)
    }

    fn commit(&mut self, record: &[u8]) -> Result<(), StoreFailed> {
        let length = u16::try_from(record.len()).map_err(|_| StoreFailed)?;
        if !(1..=MAX_RECORD_BYTES).contains(&record.len()) {
            return Err(StoreFailed);
        }
        if self.stored == Stored::Unreachable {
            // A record may be there that could not be read: look again before anything is erased.
            self.stored = self.look()?;
        }
        // Above both, also above a head whose pieces are damaged.
        let generation = self.contents.map(Content::generation).into_iter().max().unwrap_or(0).wrapping_add(1);
        let head = Head { generation, length, crc: CRC_32.checksum(record) };
        let bank = if self.stored.length() > 0 { self.bank ^ 1 } else { 0 };
        let written = self.write(bank, head, record);
        // Read back before it is believed: a worn-out word shows here.
        let found = self.look_at(bank);
        self.contents[usize::from(bank)] = found.unwrap_or(Content::Nothing);
        written?;
        if found? != Content::Whole(head) {
            return Err(StoreFailed);
        }
        (self.bank, self.stored) = (bank, Stored::Whole(length));
        Ok(())
    }
}

#[cfg(test)]
mod tests;
