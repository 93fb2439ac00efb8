//! The independent watchdog (RM0090 rev 19, chapter 21), on a clock of its own.

use super::time::{NEVER, SECOND, Ticks};

const KR: u32 = 0x00;
const PR: u32 = 0x04;
const RLR: u32 = 0x08;

pub struct IndependentWatchdog {
    prescaler: u32,
    reload: u32,
    unlocked: bool,
    started: bool,
    ends_at: Ticks,
    /// Its clock: 32 kHz, and 17 to 47 kHz from chip to chip (data sheet, table 42).
    pub clock_hz: u64,
}

impl IndependentWatchdog {
    pub const fn new() -> Self {
        Self { prescaler: 0, reload: 0xFFF, unlocked: false, started: false, ends_at: NEVER, clock_hz: 32_000 }
    }

    pub const fn reset(&mut self) {
        *self = Self { clock_hz: self.clock_hz, ..Self::new() };
    }

    pub const fn read(&self, offset: u32) -> u32 {
        match offset {
            PR => self.prescaler,
            RLR => self.reload,
            _ => 0,
        }
    }

    pub fn write(&mut self, offset: u32, word: u32, now: Ticks) {
        match offset {
            KR => {
                self.unlocked = word == 0x5555;
                self.started |= word == 0xCCCC;
                if self.started && (word == 0xAAAA || word == 0xCCCC) {
                    self.ends_at = now + self.period();
                }
            }
            PR if self.unlocked => self.prescaler = word & 7,
            RLR if self.unlocked => self.reload = word & 0xFFF,
            _ => {}
        }
    }

    /// How long it waits to be fed.
    pub fn period(&self) -> Ticks {
        let divider = 4 << self.prescaler.min(6);
        SECOND * Ticks::from(self.reload + 1) * divider / self.clock_hz
    }

    /// When it resets the chip.
    pub const fn due(&self) -> Ticks {
        self.ends_at
    }
}
