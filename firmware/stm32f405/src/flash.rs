//! The sectors for records: NOR flash in the chip, locked but for the moment of a write.
//!
//! While a sector is erased the processor stands still, for it runs from the same flash. A sector of 16 KiB takes 0.5 s at
//! most and a word 0.1 ms, 32 bits at a time (data sheet, table 46): a commit of the longest record stands still for 0.7 s,
//! within a group of 1.5 s. Eight bits at a time, as the HAL writes, it would be 1.4 s. 32 bits take 2.7 V, below which the
//! chip is held in reset (`supply`).

use core::ops::Range;
use core::ptr;

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use stm32f4xx_hal::flash::FlashExt;
use stm32f4xx_hal::pac::FLASH;

/// Where the flash begins, and the size of its first sectors.
const FLASH_START: u32 = 0x0800_0000;
const SECTOR: u32 = 16 * 1024;
/// What unlocks the flash's control register, one after the other (RM0090 rev 19, 3.6.1).
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];

#[allow(unsafe_code)]
// SAFETY: memory.x says so; they are never read, only their addresses are.
unsafe extern "C" {
    static __records_start: u8;
    static __records_end: u8;
}

/// The sectors that the linker has left to the records, from the flash's beginning.
pub fn records() -> Range<u32> {
    let offset = |place: *const u8| place.addr() as u32 - FLASH_START;
    offset(&raw const __records_start)..offset(&raw const __records_end)
}

/// The flash's controller says that it could not be done, or it lies outside the records.
#[derive(Debug, Clone, Copy)]
pub struct Failed;

impl NorFlashError for Failed {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

/// The chip's flash.
pub struct ChipFlash(pub FLASH);

impl ChipFlash {
    /// Has the controller unlocked for an operation on a part of the records.
    fn unlocked(&mut self, part: Range<u32>, act: impl FnOnce(&FLASH) -> Result<(), Failed>) -> Result<(), Failed> {
        let records = records();
        if part.start < records.start || part.end > records.end {
            return Err(Failed);
        }
        for key in KEYS {
            #[allow(unsafe_code)]
            // SAFETY: the register takes any word.
            self.0.keyr().write(|w| unsafe { w.key().bits(key) });
        }
        // What failed before is another matter.
        self.0.sr().write(|w| w.operr().clear().wrperr().clear().pgaerr().clear().pgperr().clear().pgserr().clear());
        let done = act(&self.0);
        self.0.cr().write(|w| w.lock().locked());
        done
    }
}

/// Waits until the controller has done what it was told.
fn finished(flash: &FLASH) -> Result<(), Failed> {
    // What was stored is under way before its end is asked for.
    cortex_m::asm::dsb();
    loop {
        let status = flash.sr().read();
        if status.bsy().bit_is_clear() {
            let failed = status.operr().bit()
                || status.wrperr().bit()
                || status.pgaerr().bit()
                || status.pgperr().bit()
                || status.pgserr().bit();
            return if failed { Err(Failed) } else { Ok(()) };
        }
    }
}

/// Forgets what the data cache holds: it may be of a sector that has been erased (RM0090 rev 19, 3.5.4).
fn forget_cached(flash: &FLASH) {
    let acr = flash.acr();
    acr.modify(|_, w| w.dcen().clear_bit());
    acr.modify(|_, w| w.dcrst().set_bit());
    acr.modify(|_, w| w.dcrst().clear_bit());
    acr.modify(|_, w| w.dcen().set_bit());
}

impl ErrorType for ChipFlash {
    type Error = Failed;
}

impl ReadNorFlash for ChipFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failed> {
        let from = offset as usize;
        let stored = FlashExt::read(&self.0).get(from..from + bytes.len()).ok_or(Failed)?;
        bytes.copy_from_slice(stored);
        Ok(())
    }

    fn capacity(&self) -> usize {
        records().end as usize
    }
}

impl NorFlash for ChipFlash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Failed> {
        self.unlocked(from..to, |flash| {
            for sector in from / SECTOR..to / SECTOR {
                #[allow(unsafe_code)]
                // SAFETY: a sector of the records, of which there is nothing in memory.
                flash.cr().write(|w| unsafe {
                    w.lock().unlocked().psize().psize32().ser().set_bit().snb().bits(sector as u8)
                });
                flash.cr().modify(|_, w| w.strt().set_bit());
                finished(flash)?;
            }
            forget_cached(flash);
            Ok(())
        })
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failed> {
        self.unlocked(offset..offset + bytes.len() as u32, |flash| {
            flash.cr().write(|w| w.lock().unlocked().psize().psize32().pg().set_bit());
            for (place, word) in (FLASH_START + offset..).step_by(4).zip(bytes.chunks_exact(4)) {
                let word = word.try_into().map_or(0, u32::from_le_bytes);
                #[allow(unsafe_code)]
                // SAFETY: a word of the records' sectors, which only this module touches, aligned as the store has it.
                unsafe {
                    ptr::with_exposed_provenance_mut::<u32>(place as usize).write_volatile(word);
                }
                finished(flash)?;
            }
            Ok(())
        })
    }
}
