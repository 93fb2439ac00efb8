//! The serial line to the host (RM0090 rev 19, chapter 30): a byte in the shift register, one before it, one received.

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
const UE: u32 = 1 << 13;

/// A byte of the host's: a start bit, eight bits, a stop bit at 115 200 baud.
const HOST_BYTE: Ticks = 10 * SECOND / 115_200;
/// The host's receiver takes bits that are wrong by up to 2 % in length.
const TOLERANCE: Ticks = HOST_BYTE / 50;

#[derive(Default)]
pub struct Usart {
    words: [u32; 7],
    shifting: Option<(Ticks, u8)>,
    next: Option<u8>,
    received: Option<u8>,
    overrun: bool,
    asked: bool,
    /// The host's bytes on their way, and when each has come.
    coming: VecDeque<(Ticks, u8)>,
    /// The bytes that the host has received.
    pub heard: Vec<u8>,
    /// The host's bytes that the chip has lost since power came to the bench.
    pub lost: u32,
}

impl Usart {
    /// What is on the line's wires goes on; the chip's registers begin anew.
    pub fn reset(&mut self) {
        let (coming, heard, lost) = (std::mem::take(&mut self.coming), std::mem::take(&mut self.heard), self.lost);
        *self = Self { coming, heard, lost, ..Self::default() };
    }

    /// The host sends bytes, one after the other.
    pub fn send(&mut self, bytes: &[u8], now: Ticks) {
        let mut at = self.coming.back().map_or(now, |&(at, _)| at.max(now));
        for &byte in bytes {
            at += HOST_BYTE;
            self.coming.push_back((at, byte));
        }
    }

    /// What has gone over the line by now.
    pub fn advance(&mut self, now: Ticks) {
        while let Some((at, byte)) = self.shifting.filter(|&(at, _)| at <= now) {
            self.heard.push(byte);
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
        if self.byte_ticks().abs_diff(HOST_BYTE) > TOLERANCE {
            return Err("a byte at another rate than the host's 115 200 baud");
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
        self.words[CR1 as usize / 4] & RXNEIE != 0 && (self.received.is_some() || self.overrun)
    }
}
