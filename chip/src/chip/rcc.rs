//! Reset and clock control (RM0090 rev 19, chapter 7): the crystal, the PLL, the bus clocks, and why the chip was reset.

use super::time::{MICROSECOND, NEVER, Ticks};

/// From HSEON to HSERDY: 2 ms typical (data sheet, table 39).
const CRYSTAL_STARTS: Ticks = 2000 * MICROSECOND;
/// PLL lock time: at most 200 us at a VCO of 432 MHz (data sheet, table 43).
const PLL_LOCKS: Ticks = 200 * MICROSECOND;

const CR: u32 = 0x00;
const PLLCFGR: u32 = 0x04;
const CFGR: u32 = 0x08;
const AHB1ENR: u32 = 0x30;
const APB1ENR: u32 = 0x40;
const APB2ENR: u32 = 0x44;
const CSR: u32 = 0x74;

const HSEON: u32 = 1 << 16;
const HSERDY: u32 = 1 << 17;
const PLLON: u32 = 1 << 24;
const PLLRDY: u32 = 1 << 25;
const RMVF: u32 = 1 << 24;

/// What started the chip, as CSR's flags.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reset {
    /// Power came.
    Power,
    /// The supply fell below the level of BOR, and came back.
    BrownOut,
    /// The program asked for it.
    Software,
    /// The independent watchdog ran out.
    Watchdog,
    /// The reset pin was pulled low.
    Pin,
}

impl Reset {
    /// Its flags; the pin goes low with each.
    const fn flags(self) -> u32 {
        const PIN: u32 = 1 << 26;
        PIN | match self {
            Self::Power => 1 << 27 | 1 << 25,
            Self::BrownOut => 1 << 25,
            Self::Software => 1 << 28,
            Self::Watchdog => 1 << 29,
            Self::Pin => 0,
        }
    }
}

/// The registers, by word.
pub struct Rcc {
    words: [u32; 0x24],
    crystal_at: Ticks,
    pll_at: Ticks,
    /// Whether the crystal swings.
    pub crystal_works: bool,
}

impl Rcc {
    pub const fn new() -> Self {
        Self { words: [0; 0x24], crystal_at: NEVER, pll_at: NEVER, crystal_works: true }
    }

    /// Everything as after reset, but the flags, which add up until the program clears them or power goes.
    pub fn reset(&mut self, reset: Reset) {
        let kept = if matches!(reset, Reset::Power | Reset::BrownOut) { 0 } else { self.word(CSR) };
        self.words = [0; 0x24];
        (self.crystal_at, self.pll_at) = (NEVER, NEVER);
        *self.word_mut(CR) = 0x83;
        *self.word_mut(PLLCFGR) = 0x2400_3010;
        *self.word_mut(CSR) = kept | reset.flags();
    }

    fn word(&self, offset: u32) -> u32 {
        self.words.get(offset as usize / 4).copied().unwrap_or(0)
    }

    fn word_mut(&mut self, offset: u32) -> &mut u32 {
        &mut self.words[(offset as usize / 4).min(0x23)]
    }

    /// A register, and the instant until which a program that waits for it waits.
    pub fn read(&self, offset: u32, now: Ticks) -> (u32, Option<Ticks>) {
        let word = self.word(offset);
        match offset {
            CR => {
                let crystal = word & HSEON != 0;
                let pll = word & PLLON != 0;
                let ready = |at: Ticks, bit| if at <= now { bit } else { 0 };
                let waits = [(crystal, self.crystal_at), (pll, self.pll_at)];
                let awaited = waits.iter().filter(|(on, at)| *on && *at > now).map(|&(_, at)| at).min();
                (word | ready(self.crystal_at, HSERDY) | ready(self.pll_at, PLLRDY), awaited)
            }
            // The switch is taken at once.
            CFGR => (word & !0xC | (word & 3) << 2, None),
            _ => (word, None),
        }
    }

    pub fn write(&mut self, offset: u32, word: u32, now: Ticks) {
        match offset {
            CR => {
                let before = self.word(CR);
                *self.word_mut(CR) = word & !(HSERDY | PLLRDY) | 2;
                let rises = |bit| before & bit == 0 && word & bit != 0;
                if rises(HSEON) {
                    self.crystal_at = if self.crystal_works { now + CRYSTAL_STARTS } else { NEVER };
                }
                if rises(PLLON) {
                    self.pll_at = if self.crystal_at <= now { now + PLL_LOCKS } else { NEVER };
                }
            }
            CSR => {
                let flags = if word & RMVF != 0 { 0 } else { self.word(CSR) & 0xFE00_0000 };
                *self.word_mut(CSR) = flags | word & 1 | (word & 1) << 1;
            }
            _ => *self.word_mut(offset) = word,
        }
    }

    /// Ticks an instruction takes: one cycle of the core's clock.
    pub fn core_ticks(&self) -> Ticks {
        let mhz = match self.word(CFGR) & 3 {
            0 => 16,
            1 => 8,
            _ => {
                let pll = self.word(PLLCFGR);
                let (m, n, p) = (pll & 0x3F, pll >> 6 & 0x1FF, 2 * ((pll >> 16 & 3) + 1));
                8 * n / m.max(1) / p
            }
        };
        let divider = match self.word(CFGR) >> 4 & 0xF {
            prescaler @ 8..=15 => [2, 4, 8, 16, 64, 128, 256, 512][prescaler as usize - 8],
            _ => 1,
        };
        MICROSECOND * divider / Ticks::from(mhz.max(1))
    }

    fn bus_ticks(&self, place: u32) -> Ticks {
        let divider = match self.word(CFGR) >> place & 7 {
            prescaler @ 4..=7 => 2 << (prescaler - 4),
            _ => 1,
        };
        self.core_ticks() * divider
    }

    /// Ticks a cycle of the first peripheral bus.
    pub fn bus_1_ticks(&self) -> Ticks {
        self.bus_ticks(10)
    }

    /// Ticks a cycle of the second peripheral bus.
    pub fn bus_2_ticks(&self) -> Ticks {
        self.bus_ticks(13)
    }

    /// Ticks a cycle of the timers on the first bus: twice as fast where the bus is divided.
    pub fn timer_ticks(&self) -> Ticks {
        let bus = self.bus_1_ticks();
        if bus == self.core_ticks() { bus } else { bus / 2 }
    }

    /// Whether a peripheral's clock is on; without it, it does not hear.
    pub fn clocks(&self, address: u32) -> bool {
        let (register, bit) = match address & !0x3FF {
            0x4002_0000 => (AHB1ENR, 0),
            0x4002_0400 => (AHB1ENR, 1),
            0x4002_1C00 => (AHB1ENR, 7),
            0x4000_0000 => (APB1ENR, 0),
            0x4000_3800 => (APB1ENR, 14),
            0x4000_4400 => (APB1ENR, 17),
            0x4000_7000 => (APB1ENR, 28),
            0x4001_1000 => (APB2ENR, 4),
            0x4001_3000 => (APB2ENR, 12),
            0x4001_3800 => (APB2ENR, 14),
            _ => return true,
        };
        self.word(register) >> bit & 1 == 1
    }
}
