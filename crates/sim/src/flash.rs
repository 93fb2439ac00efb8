//! A NOR flash: pages that are erased whole, words that are written once, and power that may fail in between.
//!
//! A failing supply leaves the word being written with its first half in and not its second, and the page being erased as
//! [`HalfErased`] says. After that nothing answers until [`Flash::restore_power`].

use std::cell::RefCell;
use std::rc::Rc;

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

/// An erased byte: erasing sets all bits, writing only clears them.
const ERASED: u8 = 0xFF;

/// What an erase leaves that was cut off: parts differ in it, and their sheets promise nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HalfErased {
    /// The page as it was.
    Untouched,
    /// The page erased up to its middle.
    FirstHalf,
    /// The page erased from its middle on.
    SecondHalf,
    /// All zeros: many parts write a page full before they erase it.
    Zeros,
}

impl HalfErased {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Untouched, Self::FirstHalf, Self::SecondHalf, Self::Zeros];
}

/// A NOR flash of `PAGE` bytes a page and `WORD` bytes a word.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Flash<const PAGE: usize, const WORD: usize> {
    bytes: Vec<u8>,
    /// Which words have been written since they were erased.
    written: Vec<bool>,
    operations: u32,
    cut: Option<(u32, HalfErased)>,
    is_powered: bool,
}

/// What a flash will not do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FlashFault {
    /// The power is gone.
    NoPower,
    /// The place does not stand on a word or a page.
    NotAligned,
    /// The place is outside.
    OutOfBounds,
    /// The word was written before and not erased since: parts with error correction refuse that.
    WrittenTwice,
}

impl NorFlashError for FlashFault {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::NotAligned => NorFlashErrorKind::NotAligned,
            Self::OutOfBounds => NorFlashErrorKind::OutOfBounds,
            Self::NoPower | Self::WrittenTwice => NorFlashErrorKind::Other,
        }
    }
}

impl<const PAGE: usize, const WORD: usize> Flash<PAGE, WORD> {
    /// An erased flash of so many pages.
    #[must_use]
    pub fn erased(pages: usize) -> Self {
        Self {
            bytes: vec![ERASED; pages * PAGE],
            written: vec![false; pages * PAGE / WORD],
            operations: 0,
            cut: None,
            is_powered: true,
        }
    }

    /// Writes of a word and erases of a page so far.
    #[must_use]
    pub const fn operations(&self) -> u32 {
        self.operations
    }

    /// Lets the power fail in the middle of the operation after so many further ones: 0, the very next. If that is an
    /// erase, it leaves what `erased` says.
    pub const fn cut_power_after(&mut self, operations: u32, erased: HalfErased) {
        self.cut = Some((operations, erased));
    }

    /// Whether the power has not failed.
    #[must_use]
    pub const fn is_powered(&self) -> bool {
        self.is_powered
    }

    /// Gives the power back.
    pub const fn restore_power(&mut self) {
        self.is_powered = true;
        self.cut = None;
    }

    /// Damages what is stored: clears bits of a byte, as age and radiation do.
    pub fn wear(&mut self, offset: usize, bits: u8) {
        if let Some(byte) = self.bytes.get_mut(offset) {
            *byte &= !bits;
        }
    }

    /// What is stored.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Counts an operation; when the power fails in the middle of it, what it leaves if it is an erase.
    fn fails(&mut self) -> Option<HalfErased> {
        self.operations += 1;
        let (left, erased) = self.cut.as_mut()?;
        if let Some(fewer) = left.checked_sub(1) {
            *left = fewer;
            return None;
        }
        self.is_powered = false;
        Some(*erased)
    }

    fn place(&self, offset: u32, length: usize, unit: usize) -> Result<core::ops::Range<usize>, FlashFault> {
        if !self.is_powered {
            return Err(FlashFault::NoPower);
        }
        let start = usize::try_from(offset).map_err(|_| FlashFault::OutOfBounds)?;
        let end = start.checked_add(length).filter(|&end| end <= self.bytes.len()).ok_or(FlashFault::OutOfBounds)?;
        if start.is_multiple_of(unit) && length.is_multiple_of(unit) {
            Ok(start..end)
        } else {
            Err(FlashFault::NotAligned)
        }
    }
}

impl<const PAGE: usize, const WORD: usize> ErrorType for Flash<PAGE, WORD> {
    type Error = FlashFault;
}

impl<const PAGE: usize, const WORD: usize> ReadNorFlash for Flash<PAGE, WORD> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashFault> {
        let place = self.place(offset, bytes.len(), Self::READ_SIZE)?;
        bytes.copy_from_slice(&self.bytes[place]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const PAGE: usize, const WORD: usize> NorFlash for Flash<PAGE, WORD> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = PAGE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashFault> {
        let length = to.checked_sub(from).ok_or(FlashFault::OutOfBounds)?;
        let length = usize::try_from(length).map_err(|_| FlashFault::OutOfBounds)?;
        let place = self.place(from, length, PAGE)?;
        for page in place.step_by(PAGE) {
            let half = self.fails();
            let (part, to) = match half {
                None => (0..PAGE, ERASED),
                Some(HalfErased::Untouched) => (0..0, ERASED),
                Some(HalfErased::FirstHalf) => (0..PAGE / 2, ERASED),
                Some(HalfErased::SecondHalf) => (PAGE / 2..PAGE, ERASED),
                Some(HalfErased::Zeros) => (0..PAGE, 0),
            };
            let part = page + part.start..page + part.end;
            self.written[part.start / WORD..part.end / WORD].fill(to != ERASED);
            self.bytes[part].fill(to);
            if half.is_some() {
                return Err(FlashFault::NoPower);
            }
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashFault> {
        let place = self.place(offset, bytes.len(), WORD)?;
        for (at, word) in place.step_by(WORD).zip(bytes.chunks_exact(WORD)) {
            if core::mem::replace(&mut self.written[at / WORD], true) {
                return Err(FlashFault::WrittenTwice);
            }
            let fails = self.fails().is_some();
            // A word of one byte has no half but its bits.
            let (whole, halved) = if fails { word.split_at(WORD / 2) } else { (word, &word[..0]) };
            for (stored, byte) in self.bytes[at..].iter_mut().zip(whole) {
                *stored &= byte;
            }
            if WORD == 1
                && let Some(byte) = halved.first()
            {
                self.bytes[at] &= byte | 0x0F;
            }
            if fails {
                return Err(FlashFault::NoPower);
            }
        }
        Ok(())
    }
}

/// A handle on a flash that a board and a bench share: what is in it survives the board's power.
#[derive(Debug, Clone)]
pub struct FlashPart<const PAGE: usize, const WORD: usize>(Rc<RefCell<Flash<PAGE, WORD>>>);

impl<const PAGE: usize, const WORD: usize> FlashPart<PAGE, WORD> {
    /// A handle on a flash of its own; its clones are handles on the same.
    #[must_use]
    pub fn new(flash: Flash<PAGE, WORD>) -> Self {
        Self(Rc::new(RefCell::new(flash)))
    }

    /// Does something to the flash: cuts its power, wears it, looks at it.
    pub fn with<T>(&self, what: impl FnOnce(&mut Flash<PAGE, WORD>) -> T) -> T {
        what(&mut self.0.borrow_mut())
    }
}

impl<const PAGE: usize, const WORD: usize> ErrorType for FlashPart<PAGE, WORD> {
    type Error = FlashFault;
}

impl<const PAGE: usize, const WORD: usize> ReadNorFlash for FlashPart<PAGE, WORD> {
    const READ_SIZE: usize = Flash::<PAGE, WORD>::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashFault> {
        self.0.borrow_mut().read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.0.borrow().capacity()
    }
}

impl<const PAGE: usize, const WORD: usize> NorFlash for FlashPart<PAGE, WORD> {
    const WRITE_SIZE: usize = Flash::<PAGE, WORD>::WRITE_SIZE;
    const ERASE_SIZE: usize = Flash::<PAGE, WORD>::ERASE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashFault> {
        self.0.borrow_mut().erase(from, to)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashFault> {
        self.0.borrow_mut().write(offset, bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Small = Flash<64, 4>;

    #[test]
    fn bits_are_only_cleared_and_a_word_is_written_once() {
        let mut flash = Small::erased(2);
        flash.write(4, &[0x12, 0x34, 0x56, 0x78]).unwrap();
        assert_eq!(flash.write(4, &[0; 4]), Err(FlashFault::WrittenTwice));
        assert_eq!(flash.write(6, &[0; 4]), Err(FlashFault::NotAligned));
        assert_eq!(flash.write(128, &[0; 4]), Err(FlashFault::OutOfBounds));
        assert_eq!(flash.erase(0, 32), Err(FlashFault::NotAligned));
        flash.wear(4, 0x02);
        let mut word = [0; 4];
        flash.read(4, &mut word).unwrap();
        assert_eq!(word, [0x10, 0x34, 0x56, 0x78]);
        flash.erase(0, 64).unwrap();
        assert_eq!(flash.bytes()[..64], [ERASED; 64]);
        flash.write(4, &[0; 4]).unwrap();
    }

    #[test]
    fn a_cut_leaves_half_a_word_or_half_a_page_and_then_nothing_answers() {
        let mut flash = Small::erased(2);
        flash.cut_power_after(1, HalfErased::FirstHalf);
        assert_eq!(flash.write(0, &[0; 12]), Err(FlashFault::NoPower));
        assert_eq!(flash.bytes()[..8], [0, 0, 0, 0, 0, 0, ERASED, ERASED]);
        assert_eq!(flash.read(0, &mut [0; 4]), Err(FlashFault::NoPower));
        flash.restore_power();
        flash.cut_power_after(0, HalfErased::Zeros);
        assert_eq!(flash.erase(0, 64), Err(FlashFault::NoPower));
        flash.restore_power();
        assert_eq!((flash.bytes()[9], flash.operations()), (0, 3));
        flash.erase(0, 64).unwrap();
    }
}
