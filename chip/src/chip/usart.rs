//! A serial line (RM0090 rev 19, chapter 30): a byte in the shift register, one before it, one received.

use std::collections::VecDeque;

use super::time::{NEVER, SECOND, Ticks};

const SR: u32 = 0x00;
const DR: u32 = 0x04;
const BRR: u32 = 0x08;
const CR1: u32 = 0x0C;

const ORE: u32 = 1 << 3;
const RXNE: u32 = 1 << 5;
const TC: u32 = 1 << 6;
const TXE: u32 = 1 << 7;

const RE: u32 = 1 << 2;
const TE: u32 = 1 << 3;
const RXNEIE: u32 = 1 << 5;
const TXEIE: u32 = 1 << 7;
const UE: u32 = 1 << 13;

/// The host's rate, and that of the second line.
pub const HOST_BAUD: u64 = 115_200;
pub const SCAN_BAUD: u64 = 460_800;
/// Whoever is at the other end takes bits that are wrong by up to 2 % in length.
const TOLERANCE: Ticks = 50;

pub struct Usart {
    words: [u32; 7],
    /// A byte at the other end's rate: a start bit, eight bits, a stop bit.
    byte: Ticks,
    shifting: Option<(Ticks, u8)>,
    next: Option<u8>,
    received: Option<u8>,
    overrun: bool,
    asked: bool,
    /// The host's bytes on their way, and when each has come.
    coming: VecDeque<(Ticks, u8)>,
    /// The bytes that the other end has received.
    pub heard: Vec<u8>,
    /// When the last of them came.
    pub heard_at: Ticks,
    /// The host's bytes that the chip has lost since power came to the bench.
    pub lost: u32,
}

impl Usart {
    /// A line whose other end has a rate.
    pub const fn at(baud: u64) -> Self {
        Self {
            words: [0; 7],
            byte: 10 * SECOND / baud,
            shifting: None,
            next: None,
            received: None,
            overrun: false,
            asked: false,
            coming: VecDeque::new(),
            heard: Vec::new(),
            heard_at: 0,
            lost: 0,
        }
    }

    /// What is on the line's wires goes on; the chip's registers begin anew.
    pub fn reset(&mut self) {
        let (coming, heard) = (std::mem::take(&mut self.coming), std::mem::take(&mut self.heard));
        let Self { byte, heard_at, lost, .. } = *self;
        *self = Self { byte, coming, heard, heard_at, lost, ..Self::at(HOST_BAUD) };
    }

    /// The host sends bytes, one after the other.
    pub fn send(&mut self, bytes: &[u8], now: Ticks) {
        let mut at = self.coming.back().map_or(now, |&(at, _)| at.max(now));
        for &byte in bytes {
            at += self.byte;
            self.coming.push_back((at, byte));
        }
    }

    /// What has gone over the line by now.
    pub fn advance(&mut self, now: Ticks) {
        while let Some((at, byte)) = self.shifting.filter(|&(at, _)| at <= now) {
            self.heard.push(byte);
            self.heard_at = at;
            self.shifting = self.next.take().map(|byte| (at + self.byte_ticks(), byte));
        }
        while self.coming.front().is_some_and(|&(at, _)| at <= now) {
            let Some((_, byte)) = self.coming.pop_front() else { break };
            let listens = self.words[CR1 as usize / 4] & (UE | RE) == UE | RE;
            if !listens {
                self.lost += 1;
            } else if self.received.is_some() {
                (self.overrun, self.lost) = (true, self.lost + 1);
            } else {
                self.received = Some(byte);
            }
        }
    }

    /// Ten bits as the baud rate register has them, set by [`Self::clock`].
    fn byte_ticks(&self) -> Ticks {
        10 * Ticks::from(self.words[BRR as usize / 4]) * Ticks::from(self.words[6].max(1))
    }

    pub fn read(&mut self, offset: u32) -> (u32, Option<Ticks>) {
        match offset {
            SR => {
                let bit = |is: bool, bit| if is { bit } else { 0 };
                let status = bit(self.overrun, ORE)
                    | bit(self.received.is_some(), RXNE)
                    | bit(self.shifting.is_none(), TC)
                    | bit(self.next.is_none(), TXE);
                let waits = self.asked && self.next.is_some();
                self.asked = true;
                (status, self.shifting.map(|(at, _)| at).filter(|_| waits))
            }
            DR => {
                self.asked = false;
                self.overrun = false;
                (self.received.take().unwrap_or(0).into(), None)
            }
            _ => (self.words.get(offset as usize / 4).copied().unwrap_or(0), None),
        }
    }

    /// A register is written; `bus_ticks` is a cycle of the peripheral's bus. What cannot be is said.
    pub fn write(&mut self, offset: u32, word: u32, now: Ticks, bus_ticks: Ticks) -> Result<(), &'static str> {
        self.words[6] = u32::try_from(bus_ticks).unwrap_or(1);
        match offset {
            SR => return Ok(()),
            DR => {}
            _ => {
                if let Some(place) = self.words.get_mut(offset as usize / 4) {
                    *place = word;
                }
                return Ok(());
            }
        }
        if self.words[CR1 as usize / 4] & (UE | TE) != UE | TE {
            return Err("a byte for a USART that does not send");
        }
        if self.byte_ticks().abs_diff(self.byte) * TOLERANCE > self.byte {
            return Err("a byte at another rate than the other end's");
        }
        self.asked = false;
        let byte = (word & 0xFF) as u8;
        if self.shifting.is_none() {
            self.shifting = Some((now + self.byte_ticks(), byte));
        } else if self.next.replace(byte).is_some() {
            return Err("a byte for a USART whose last one had not gone");
        }
        Ok(())
    }

    /// Whether what is written to a register goes out.
    pub const fn sends(&self, offset: u32) -> bool {
        offset == DR
    }

    /// When the next byte has come, at either end.
    pub fn due(&self) -> Ticks {
        let at = |byte: Option<&(Ticks, u8)>| byte.map_or(NEVER, |&(at, _)| at);
        at(self.coming.front()).min(at(self.shifting.as_ref()))
    }

    /// Whether nothing is on its way, in either direction.
    pub fn is_quiet(&self) -> bool {
        self.coming.is_empty() && self.shifting.is_none() && self.received.is_none()
    }

    /// Whether it asks for its interrupt.
    pub fn asks(&self) -> bool {
        let cr1 = self.words[CR1 as usize / 4];
        cr1 & RXNEIE != 0 && (self.received.is_some() || self.overrun) || cr1 & TXEIE != 0 && self.next.is_none()
    }
}
