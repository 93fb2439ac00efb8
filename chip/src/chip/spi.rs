//! An SPI master (RM0090 rev 19, chapter 28): a shift register, one byte before it and one behind.

use zerorate_sim::SPI_BYTE_NS;

use super::time::{Ticks, nanoseconds};

const CR1: u32 = 0x00;
const SR: u32 = 0x08;
const DR: u32 = 0x0C;

const RXNE: u32 = 1 << 0;
const TXE: u32 = 1 << 1;
const OVR: u32 = 1 << 6;
const BSY: u32 = 1 << 7;
/// CR1: on, master, and a frame of 16 bits, which is not modelled.
const SPE: u32 = 1 << 6;
const MSTR: u32 = 1 << 2;
const DFF: u32 = 1 << 11;

#[derive(Default)]
pub struct Spi {
    words: [u32; 9],
    /// The byte in the shift register, and when its last clock has come.
    shifting: Option<(Ticks, u8)>,
    /// The byte that waits for it.
    next: Option<u8>,
    received: Option<u8>,
    last: u8,
    overrun: bool,
    /// SR has been read since DR was touched: the program waits.
    asked: bool,
    byte_ticks: Ticks,
}

impl Spi {
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// The byte whose last clock has come.
    pub fn finished(&self, now: Ticks) -> Option<(Ticks, u8)> {
        self.shifting.filter(|&(at, _)| at <= now)
    }

    /// The finished byte's answer arrives, and the next byte begins.
    pub fn take(&mut self, answer: u8) {
        let Some((at, _)) = self.shifting.take() else { return };
        if self.received.is_some() {
            self.overrun = true;
        } else {
            self.received = Some(answer);
        }
        self.shifting = self.next.take().map(|byte| (at + self.byte_ticks, byte));
    }

    /// Whether a byte is on the line.
    pub const fn is_shifting(&self) -> bool {
        self.shifting.is_some()
    }

    pub fn read(&mut self, offset: u32) -> (u32, Option<Ticks>) {
        match offset {
            DR => {
                self.asked = false;
                self.last = self.received.take().unwrap_or(self.last);
                (self.last.into(), None)
            }
            SR => {
                let bit = |is: bool, bit| if is { bit } else { 0 };
                let status = bit(self.received.is_some(), RXNE)
                    | bit(self.next.is_none(), TXE)
                    | bit(self.overrun, OVR)
                    | bit(self.shifting.is_some(), BSY);
                // Read again with nothing done between: whoever does that waits for the byte.
                let waits = self.asked && self.received.is_none();
                self.asked = true;
                self.overrun = false;
                (status, self.shifting.map(|(at, _)| at).filter(|_| waits))
            }
            _ => (self.words.get(offset as usize / 4).copied().unwrap_or(0), None),
        }
    }

    /// A register is written; `bus_ticks` is a cycle of the peripheral's bus. What cannot be is said.
    pub fn write(&mut self, offset: u32, word: u32, now: Ticks, bus_ticks: Ticks) -> Result<(), &'static str> {
        if offset != DR {
            if let Some(place) = self.words.get_mut(offset as usize / 4) {
                *place = word;
            }
            return Ok(());
        }
        let cr1 = self.words[CR1 as usize / 4];
        if cr1 & (SPE | MSTR | DFF) != SPE | MSTR {
            return Err("a byte for an SPI that is not a master of bytes, or off");
        }
        self.asked = false;
        self.byte_ticks = 8 * bus_ticks * (2 << (cr1 >> 3 & 7));
        if nanoseconds(self.byte_ticks).abs_diff(SPI_BYTE_NS) > 1 {
            return Err("a byte at another clock than the simulated buses have everywhere else");
        }
        let byte = (word & 0xFF) as u8;
        if self.shifting.is_none() {
            self.shifting = Some((now + self.byte_ticks, byte));
        } else if self.next.replace(byte).is_some() {
            return Err("a byte for an SPI whose last one had not gone");
        }
        Ok(())
    }
}
