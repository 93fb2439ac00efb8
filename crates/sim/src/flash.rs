//! A NOR flash: pages that are erased whole, words that are written once, and power that may fail in between.
//!
//! What a failing supply leaves behind is the worst that the parts' sheets allow: the word being written has its first
//! half in and not its second, the page being erased is erased to its middle. After that nothing answers until
//! [`Flash::restore_power`].

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

/// An erased byte: erasing sets all bits, writing only clears them.
const ERASED: u8 = 0xFF;

/// A NOR flash of `PAGE` bytes a page and `WORD` bytes a word.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Flash<const PAGE: usize, const WORD: usize> {
    bytes: Vec<u8>,
    /// Which words have been written since they were erased.
    written: Vec<bool>,
    operations: u32,
    cut_after: Option<u32>,
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
            cut_after: None,
            is_powered: true,
        }
    }

    /// Writes of a word and erases of a page so far.
    #[must_use]
    pub const fn operations(&self) -> u32 {
        self.operations
    }

    /// Lets the power fail in the middle of the operation after so many further ones: 0, the very next.
    pub const fn cut_power_after(&mut self, operations: u32) {
        self.cut_after = Some(operations);
    }

    /// Whether the power has not failed.
    #[must_use]
    pub const fn is_powered(&self) -> bool {
        self.is_powered
    }

    /// Gives the power back.
    pub const fn restore_power(&mut self) {
        self.is_powered = true;
        self.cut_after = None;
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

    /// Counts an operation; `true` when the power fails in the middle of it.
    fn fails(&mut self) -> bool {
        self.operations += 1;
        match &mut self.cut_after {
            Some(0) => {
                self.is_powered = false;
                true
            }
            Some(left) => {
                *left -= 1;
                false
            }
            None => false,
        }
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
            let fails = self.fails();
            let erased = if fails { PAGE / 2 } else { PAGE };
            self.bytes[page..page + erased].fill(ERASED);
            self.written[page / WORD..(page + erased) / WORD].fill(false);
            if fails {
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
            let fails = self.fails();
            // A word of one byte has no half but its bits.
            let (whole, halved) = if fails { word.split_at(WORD / 2) } else { (word, &word[..0]) };
            for (stored, byte) in self.bytes[at..].iter_mut().zip(whole) {
                *stored &= byte;
            }
            if WORD == 1 && let Some(byte) = halved.first() {
                self.bytes[at] &= byte | 0x0F;
            }
            if fails {
                return Err(FlashFault::NoPower);
            }
        }
        Ok(())
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
        flash.cut_power_after(1);
        assert_eq!(flash.write(0, &[0; 12]), Err(FlashFault::NoPower));
        assert_eq!(flash.bytes()[..8], [0, 0, 0, 0, 0, 0, ERASED, ERASED]);
        assert_eq!(flash.read(0, &mut [0; 4]), Err(FlashFault::NoPower));
        flash.restore_power();
        flash.cut_power_after(0);
        assert_eq!(flash.erase(0, 64), Err(FlashFault::NoPower));
        flash.restore_power();
        assert_eq!((flash.bytes()[0], flash.operations()), (ERASED, 3));
        flash.erase(0, 64).unwrap();
    }
}
