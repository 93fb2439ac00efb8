//! The chip's supply and what looks at it (RM0090 rev 19, chapter 5): the PVD, by its levels' typical values. The brown-out
//! reset's level is in the option bytes, and the flash's interface has them.

use super::rcc::Reset;

const CR: u32 = 0x00;
const CSR: u32 = 0x04;
const PVDE: u32 = 1 << 4;
const PVDO: u32 = 1 << 2;
/// The regulator's scale is reached.
const VOSRDY: u32 = 1 << 14;

/// Below it the chip loses everything (PDR, falling, typical; data sheet, table 19).
const POWER_DOWN_V: f64 = 1.68;
/// Where the PVD's output rises as the supply falls (PLS 0 to 7), and where BOR resets (level 3, 2, 1): typical, falling.
const PVD_V: [f64; 8] = [2.04, 2.19, 2.35, 2.51, 2.66, 2.82, 2.93, 3.03];
const BROWN_OUT_V: [f64; 3] = [2.83, 2.50, 2.19];

pub struct Power {
    cr: u32,
    volts: f64,
}

impl Power {
    pub const fn new() -> Self {
        Self { cr: 0, volts: 3.3 }
    }

    pub const fn reset(&mut self) {
        self.cr = 0;
    }

    pub fn read(&self, offset: u32) -> u32 {
        match offset {
            CR => self.cr,
            CSR => VOSRDY | if self.is_low() { PVDO } else { 0 },
            _ => 0,
        }
    }

    /// A write; whether the PVD's output rises with it.
    pub fn write(&mut self, offset: u32, word: u32) -> bool {
        let was_low = self.is_low();
        if offset == CR {
            self.cr = word;
        }
        !was_low && self.is_low()
    }

    fn is_low(&self) -> bool {
        self.cr & PVDE != 0 && self.volts < PVD_V[(self.cr >> 5 & 7) as usize]
    }

    /// The supply goes to so many volts; whether the PVD's output rises, and the reset that it is. `level` is the option
    /// bytes' BOR_LEV.
    pub fn supply(&mut self, volts: f64, level: u32) -> (bool, Option<Reset>) {
        let was_low = self.is_low();
        self.volts = volts;
        let brown_out = BROWN_OUT_V.get(level as usize).is_some_and(|&below| volts < below);
        let reset = match (volts < POWER_DOWN_V, brown_out) {
            (true, _) => Some(Reset::Power),
            (false, true) => Some(Reset::BrownOut),
            (false, false) => None,
        };
        (!was_low && self.is_low(), reset)
    }
}
