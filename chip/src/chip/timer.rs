//! A general timer counting up (RM0090 rev 19, chapter 18): its update event and no channels.

use super::time::{NEVER, Ticks};

const CR1: u32 = 0x00;
const DIER: u32 = 0x0C;
const SR: u32 = 0x10;
const EGR: u32 = 0x14;
const PSC: u32 = 0x28;
const ARR: u32 = 0x2C;

const CEN: u32 = 1 << 0;
/// Only an overflow sets the flag, and no UG.
const URS: u32 = 1 << 2;
const UIF: u32 = 1 << 0;

pub struct Timer {
    words: [u32; 20],
    update_at: Ticks,
    period: Ticks,
}

impl Timer {
    pub const fn new() -> Self {
        Self { words: [0; 20], update_at: NEVER, period: 1 }
    }

    pub const fn reset(&mut self) {
        *self = Self::new();
    }

    fn word(&self, offset: u32) -> u32 {
        self.words.get(offset as usize / 4).copied().unwrap_or(0)
    }

    pub fn read(&self, offset: u32) -> u32 {
        self.word(offset)
    }

    /// A register is written; `clock_ticks` is a cycle of the timer's clock.
    pub fn write(&mut self, offset: u32, word: u32, now: Ticks, clock_ticks: Ticks) {
        let before = self.word(offset);
        if let Some(place) = self.words.get_mut(offset as usize / 4) {
            *place = if offset == SR { before & word } else { word };
        }
        match offset {
            CR1 if before & CEN == 0 && word & CEN != 0 => self.begin(now, clock_ticks),
            CR1 if word & CEN == 0 => self.update_at = NEVER,
            EGR => {
                if self.word(CR1) & URS == 0 {
                    self.words[SR as usize / 4] |= UIF;
                }
                if self.word(CR1) & CEN != 0 {
                    self.begin(now, clock_ticks);
                }
            }
            _ => {}
        }
    }

    fn begin(&mut self, now: Ticks, clock_ticks: Ticks) {
        self.period = (Ticks::from(self.word(PSC)) + 1) * (Ticks::from(self.word(ARR)) + 1) * clock_ticks;
        self.update_at = now + self.period;
    }

    /// It overflows by somebody else's time.
    pub fn overflow(&mut self) {
        self.words[SR as usize / 4] |= UIF;
    }

    pub fn advance(&mut self, now: Ticks) {
        while self.update_at <= now {
            self.words[SR as usize / 4] |= UIF;
            self.update_at += self.period;
        }
    }

    /// When it overflows.
    pub const fn due(&self) -> Ticks {
        self.update_at
    }

    /// Whether it asks for its interrupt.
    pub fn asks(&self) -> bool {
        self.word(SR) & self.word(DIER) & UIF != 0
    }
}
