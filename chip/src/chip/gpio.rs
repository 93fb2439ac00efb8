//! A GPIO port (RM0090 rev 19, chapter 8): modes and levels; speed, pulls and alternate functions are kept and do nothing.

const MODER: u32 = 0x00;
const IDR: u32 = 0x10;
const ODR: u32 = 0x14;
const BSRR: u32 = 0x18;
const AFRL: u32 = 0x20;

/// A port's registers, and the levels that others drive.
#[derive(Default)]
pub struct Gpio {
    words: [u32; 10],
    /// What is driven from outside.
    pub driven: u32,
}

impl Gpio {
    pub fn reset(&mut self) {
        self.words = [0; 10];
    }

    pub fn read(&self, offset: u32) -> u32 {
        match offset {
            IDR => self.driven,
            BSRR => 0,
            _ => self.words.get(offset as usize / 4).copied().unwrap_or(0),
        }
    }

    pub fn write(&mut self, offset: u32, word: u32) {
        match offset {
            IDR => {}
            BSRR => {
                let odr = &mut self.words[ODR as usize / 4];
                *odr = *odr & !(word >> 16) | word & 0xFFFF;
            }
            _ => {
                if let Some(place) = self.words.get_mut(offset as usize / 4) {
                    *place = word;
                }
            }
        }
    }

    /// A pin's mode: 0 input, 1 output, 2 alternate function, 3 analogue.
    pub fn mode(&self, pin: u32) -> u32 {
        self.words[MODER as usize / 4] >> (2 * pin) & 3
    }

    /// Whether a pin, one of the first eight, is a peripheral's: by its alternate function.
    pub fn is_of(&self, pin: u32, function: u32) -> bool {
        self.mode(pin) == 2 && self.words[AFRL as usize / 4] >> (4 * pin) & 0xF == function
    }

    /// Whether a pin that others pull up is low.
    pub fn pulls_low(&self, pin: u32) -> bool {
        self.mode(pin) == 1 && self.words[ODR as usize / 4] >> pin & 1 == 0
    }
}
