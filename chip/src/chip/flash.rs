//! The flash of the records and its interface (RM0090 rev 19, chapter 3): locked, erased by the sector, programmed by bytes.
//!
//! The core stands still while flash is erased or programmed, for it runs from the same flash: an operation takes its time
//! where it is begun, and its busy flag is never seen.

use super::time::{MICROSECOND, SECOND, Ticks};

/// Where sector 10 begins; 10 and 11 hold the records.
pub const RECORDS: u32 = 0x080C_0000;
/// Their bytes.
pub const RECORD_BYTES: usize = 2 * SECTOR;
const SECTOR: usize = 128 * 1024;
const FIRST_SECTOR: u32 = 10;

/// A byte, eight bits at a time: 16 us typical (data sheet, table 46).
const PROGRAMS: Ticks = 16 * MICROSECOND;

const KEYR: u32 = 0x04;
const SR: u32 = 0x0C;
const CR: u32 = 0x10;
const PG: u32 = 1 << 0;
const SER: u32 = 1 << 1;
const STRT: u32 = 1 << 16;
const LOCK: u32 = 1 << 31;
/// SR: programming in a wrong order; written ones clear.
const PGSERR: u32 = 1 << 7;
const WRPERR: u32 = 1 << 4;

pub struct Flash {
    acr: u32,
    cr: u32,
    sr: u32,
    keys: u32,
    /// What the records' sectors hold.
    pub records: Vec<u8>,
    /// How long a sector of 128 KiB takes to erase: 2 s typical, 4 s at most, eight bits at a time (data sheet, table 46).
    pub erases_in: Ticks,
    /// Sectors erased since power came to the bench, and the longest the core stood still at a stretch.
    pub erased: u32,
}

impl Flash {
    pub fn new() -> Self {
        let records = vec![0xFF; RECORD_BYTES];
        Self { acr: 0, cr: LOCK, sr: 0, keys: 0, records, erases_in: 2 * SECOND, erased: 0 }
    }

    pub const fn reset(&mut self) {
        (self.acr, self.cr, self.sr, self.keys) = (0, LOCK, 0, 0);
    }

    pub const fn read(&self, offset: u32) -> u32 {
        match offset {
            0 => self.acr,
            SR => self.sr,
            CR => self.cr,
            _ => 0,
        }
    }

    /// A register is written; how long the core stands still for it.
    pub fn write(&mut self, offset: u32, word: u32) -> Ticks {
        match offset {
            0 => self.acr = word,
            KEYR => match (self.keys, word) {
                (0, 0x4567_0123) => self.keys = 1,
                (1, 0xCDEF_89AB) => (self.keys, self.cr) = (0, self.cr & !LOCK),
                _ => self.keys = 0,
            },
            SR => self.sr &= !word,
            CR if self.cr & LOCK == 0 => {
                self.cr = word & !STRT;
                if word & (STRT | SER) == STRT | SER {
                    return self.erase(word >> 3 & 0x1F);
                }
            }
            _ => {}
        }
        0
    }

    fn erase(&mut self, sector: u32) -> Ticks {
        let index = sector.wrapping_sub(FIRST_SECTOR) as usize;
        let Some(bytes) = self.records.chunks_exact_mut(SECTOR).nth(index) else {
            self.sr |= WRPERR;
            return 0;
        };
        bytes.fill(0xFF);
        self.erased += 1;
        self.erases_in
    }

    /// Bytes of the records' sectors, as a word.
    pub fn load(&self, offset: u64, size: usize) -> u64 {
        let offset = usize::try_from(offset).unwrap_or(usize::MAX);
        let bytes = self.records.get(offset..offset + size).unwrap_or(&[]);
        bytes.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte))
    }

    /// The program writes into the records' sectors; how long the core stands still. Bits go from 1 to 0 alone.
    pub fn store(&mut self, offset: u64, size: usize, word: u64) -> Ticks {
        let parallel = 1 << (self.cr >> 8 & 3);
        if self.cr & (LOCK | PG) != PG || size != parallel {
            self.sr |= PGSERR;
            return 0;
        }
        let offset = usize::try_from(offset).unwrap_or(usize::MAX);
        if let Some(bytes) = self.records.get_mut(offset..offset + size) {
            bytes.iter_mut().zip(word.to_le_bytes()).for_each(|(byte, new)| *byte &= new);
        }
        PROGRAMS
    }
}
