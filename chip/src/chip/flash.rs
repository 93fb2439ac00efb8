//! The flash of the records and its interface (RM0090 rev 19, chapter 3): locked, erased by the sector, programmed by bytes.
//!
//! The core stands still while flash is erased or programmed, for it runs from the same flash: an operation takes its time
//! where it is begun, and its busy flag is never seen.

use super::time::{MICROSECOND, MILLISECOND, Ticks};

/// Where sector 1 begins; 1 and 2 hold the records.
pub const RECORDS: u32 = 0x0800_4000;
/// Their bytes.
pub const RECORD_BYTES: usize = 2 * SECTOR;
/// A bank of them.
pub const SECTOR: usize = 16 * 1024;
const FIRST_SECTOR: u32 = 1;

/// To erase a sector of 16 KiB, 8, 16 and 32 bits at a time: typical, and at most (data sheet, table 46).
const ERASES: [[Ticks; 2]; 3] = [
    [400 * MILLISECOND, 800 * MILLISECOND],
    [300 * MILLISECOND, 600 * MILLISECOND],
    [250 * MILLISECOND, 500 * MILLISECOND],
];
/// To program a word of any width: typical, and at most (the same table).
const PROGRAMS: [Ticks; 2] = [16 * MICROSECOND, 100 * MICROSECOND];
/// To program the option bytes: their own small sector is erased first. The sheet has no figure of its own.
const OPTIONS: Ticks = 250 * MILLISECOND;

const KEYR: u32 = 0x04;
const SR: u32 = 0x0C;
const CR: u32 = 0x10;
const OPTKEYR: u32 = 0x08;
const OPTCR: u32 = 0x14;
const OPTLOCK: u32 = 1 << 0;
const OPTSTRT: u32 = 1 << 1;
/// The option bytes of a chip as it is delivered, BOR off; two bits of the register lock and start.
const DELIVERED: u32 = 0x0FFF_AAEC;
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
    /// Whether it takes as long as its sheet allows.
    pub slow: bool,
    /// Sectors erased since power came to the bench, words programmed, and how often the option bytes were.
    pub erased: u32,
    pub programmed: u32,
    pub options_programmed: u32,
    /// The option bytes, and their register.
    options: u32,
    optcr: u32,
    option_keys: u32,
}

impl Flash {
    pub fn new() -> Self {
        Self {
            acr: 0,
            cr: LOCK,
            sr: 0,
            keys: 0,
            records: vec![0xFF; RECORD_BYTES],
            slow: false,
            erased: 0,
            programmed: 0,
            options_programmed: 0,
            options: DELIVERED,
            optcr: DELIVERED | OPTLOCK,
            option_keys: 0,
        }
    }

    /// The registers as after a reset; the option bytes are loaded.
    pub const fn reset(&mut self) {
        (self.acr, self.cr, self.sr, self.keys) = (0, LOCK, 0, 0);
        (self.optcr, self.option_keys) = (self.options | OPTLOCK, 0);
    }

    /// The option bytes are of a level already, as a chip has them that was started before; 3 is a chip as delivered.
    pub const fn set_brown_out_level(&mut self, level: u32) {
        self.options = DELIVERED & !(3 << 2) | level << 2;
        self.optcr = self.options | OPTLOCK;
    }

    /// BOR_LEV as the option bytes have it: 0 is level 3, 3 is off.
    pub const fn brown_out_level(&self) -> u32 {
        self.options >> 2 & 3
    }

    pub const fn read(&self, offset: u32) -> u32 {
        match offset {
            0 => self.acr,
            SR => self.sr,
            CR => self.cr,
            OPTCR => self.optcr,
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
            OPTKEYR => match (self.option_keys, word) {
                (0, 0x0819_2A3B) => self.option_keys = 1,
                (1, 0x4C5D_6E7F) => (self.option_keys, self.optcr) = (0, self.optcr & !OPTLOCK),
                _ => self.option_keys = 0,
            },
            OPTCR if self.optcr & OPTLOCK == 0 => {
                self.optcr = word & !OPTSTRT;
                if word & OPTSTRT != 0 {
                    self.options = word & !(OPTLOCK | OPTSTRT);
                    self.options_programmed += 1;
                    return OPTIONS;
                }
            }
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
        // Wider than 32 bits takes a second supply.
        let width = (self.cr >> 8 & 3).min(2) as usize;
        ERASES[width][usize::from(self.slow)]
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
        self.programmed += 1;
        PROGRAMS[usize::from(self.slow)]
    }
}
