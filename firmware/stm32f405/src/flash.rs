//! The sectors for records: NOR flash in the chip, locked but for the moment of a write.
//!
//! While a sector is erased (2 s, up to 4 s, a byte at a time; data sheet, table 40) the processor stands still, for it runs from the same flash.
//! A commit is a declared pause: only then is anything erased.

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use stm32f4xx_hal::flash::{Error, FlashExt};
use stm32f4xx_hal::pac::FLASH;

/// Sectors 10 and 11, from the flash's beginning.
pub const RECORDS: core::ops::Range<u32> = 0xC_0000..0x10_0000;

/// The chip's flash.
pub struct ChipFlash(pub FLASH);

impl ErrorType for ChipFlash {
    type Error = Error;
}

impl ReadNorFlash for ChipFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        let from = offset as usize;
        let stored = FlashExt::read(&self.0).get(from..from + bytes.len()).ok_or(Error::Operation)?;
        bytes.copy_from_slice(stored);
        Ok(())
    }

    fn capacity(&self) -> usize {
        RECORDS.end as usize
    }
}

impl NorFlash for ChipFlash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 128 * 1024;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
        if from < RECORDS.start || to > RECORDS.end {
            return Err(Error::WriteProtection);
        }
        NorFlash::erase(&mut self.0.unlocked(), from, to)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        if offset < RECORDS.start {
            return Err(Error::WriteProtection);
        }
        NorFlash::write(&mut self.0.unlocked(), offset, bytes)
    }
}
