//! The acquisition port: the SPI slave of `docs/acquisition-port.md`, version 1.0, with its two banks.

use crate::crc32::Crc32;

/// "ZRAQ".
const IDENTITY: u32 = 0x5A52_4151;
const VERSION: u32 = 0x0001_0000;
const RUN: u32 = 1 << 0;
const RESTART: u32 = 1 << 1;
const READY: u32 = 1 << 0;
const OVERRUN: u32 = 1 << 1;
/// The burst's address.
const SET: u8 = 0x10;
/// Words of the burst before the samples, their CRC included.
const HEADER_WORDS: usize = 16;

/// What a set is filled by: taken up at its start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Settings {
    scan_period_us: u32,
    set_length: u32,
}

/// A full set that waits.
#[derive(Debug, Clone, Default)]
struct Bank {
    /// Samples in the order of the burst: scan by scan, channel by channel.
    samples: Vec<u16>,
    number: u32,
    lost_before: bool,
}

/// One SPI transfer in progress.
#[derive(Debug, Clone)]
struct Transfer {
    bytes: usize,
    write: bool,
    address: u8,
    /// The word being sent or received.
    word: [u8; 4],
    /// Words 0 to 15 of the burst, as they were when it began; `None` when no set waited.
    header: Option<[u32; HEADER_WORDS]>,
    samples_crc: Crc32,
}

/// The port.
#[derive(Debug, Clone)]
pub(crate) struct Port {
    running: bool,
    written: Settings,
    active: Settings,
    filling: Vec<u16>,
    waiting: Option<Bank>,
    next_number: u32,
    lost: u32,
    lost_since_release: bool,
    last_was_lost: bool,
    transfer: Option<Transfer>,
    changed: bool,
}

impl Port {
    pub(crate) fn new() -> Self {
        let settings = Settings { scan_period_us: 3000, set_length: 500 };
        Self {
            running: false,
            written: settings,
            active: settings,
            filling: Vec::new(),
            waiting: None,
            next_number: 0,
            lost: 0,
            lost_since_release: false,
            last_was_lost: false,
            transfer: None,
            changed: false,
        }
    }

    pub(crate) fn running(&self) -> bool {
        self.running
    }

    /// The data ready line.
    pub(crate) fn data_ready(&self) -> bool {
        self.waiting.is_some()
    }

    /// From the last scan to the next, in nanoseconds.
    pub(crate) fn scan_period_ns(&self) -> u64 {
        u64::from(self.active.scan_period_us) * 1000
    }

    /// Whether scanning was stopped or started anew since this was last asked: the first scan is a period from then.
    pub(crate) fn take_changed(&mut self) -> bool {
        core::mem::take(&mut self.changed)
    }

    /// Takes a scan; the set's number if this fills it, lost or not.
    pub(crate) fn push(&mut self, scan: [u16; 4]) -> Option<u32> {
        self.filling.extend_from_slice(&scan);
        if self.filling.len() < self.active.set_length as usize * 4 {
            return None;
        }
        let number = self.next_number;
        self.next_number = number.wrapping_add(1);
        if self.waiting.is_some() {
            self.lost = self.lost.wrapping_add(1);
            self.lost_since_release = true;
        }
        if self.waiting.is_some() && self.reading() {
            self.last_was_lost = true;
            self.filling.clear();
        } else {
            let older = self.waiting.take();
            let lost_before = older.is_some() || self.last_was_lost;
            self.last_was_lost = false;
            let free = older.map(|bank| bank.samples).unwrap_or_else(|| Vec::with_capacity(4 * 512));
            let samples = core::mem::replace(&mut self.filling, free);
            self.filling.clear();
            self.waiting = Some(Bank { samples, number, lost_before });
        }
        self.active = self.written;
        Some(number)
    }

    /// Whether the waiting set is just being read.
    fn reading(&self) -> bool {
        self.transfer.as_ref().is_some_and(|transfer| transfer.header.is_some())
    }

    /// Chip select falls.
    pub(crate) fn select(&mut self) {
        self.transfer = Some(Transfer {
            bytes: 0,
            write: false,
            address: 0,
            word: [0; 4],
            header: None,
            samples_crc: Crc32::new(),
        });
    }

    /// Eight clocks: a byte in and a byte out.
    pub(crate) fn exchange(&mut self, byte: u8) -> u8 {
        let Some(mut transfer) = self.transfer.take() else { return 0 };
        let sent = match transfer.bytes {
            0 => {
                transfer.write = byte & 0x80 != 0;
                transfer.address = byte & 0x7F;
                if transfer.address == SET && !transfer.write {
                    transfer.header = self.waiting.as_ref().map(|bank| self.header(bank));
                }
                0
            }
            1 => 0,
            bytes => self.exchange_word(&mut transfer, bytes - 2, byte),
        };
        transfer.bytes += 1;
        self.transfer = Some(transfer);
        sent
    }

    /// Chip select rises: a set whose header was sent whole is released.
    pub(crate) fn deselect(&mut self) {
        let Some(transfer) = self.transfer.take() else { return };
        if transfer.header.is_some() && transfer.bytes >= 2 + 4 * HEADER_WORDS {
            self.waiting = None;
            self.lost_since_release = false;
        }
    }

    fn exchange_word(&mut self, transfer: &mut Transfer, position: usize, byte: u8) -> u8 {
        let (index, place) = (position / 4, position % 4);
        let burst = transfer.address == SET && !transfer.write;
        if transfer.write {
            transfer.word[place] = byte;
            if place == 3 {
                self.write(address_of(transfer, index), u32::from_be_bytes(transfer.word));
            }
            return 0;
        }
        if place == 0 {
            let word = if burst { self.burst_word(transfer, index) } else { self.read(address_of(transfer, index)) };
            transfer.word = word.to_be_bytes();
        }
        transfer.word[place]
    }

    fn read(&self, address: Option<u8>) -> u32 {
        match address {
            Some(0x00) => IDENTITY,
            Some(0x01) => VERSION,
            Some(0x02) => u32::from(self.running) * RUN,
            Some(0x03) => self.written.scan_period_us,
            Some(0x04) => self.written.set_length,
            Some(0x05) => {
                let ready = if self.data_ready() { READY } else { 0 };
                let overrun = if self.lost_since_release { OVERRUN } else { 0 };
                self.lost << 16 | overrun | ready
            }
            _ => 0,
        }
    }

    fn write(&mut self, address: Option<u8>, word: u32) {
        match address {
            Some(0x02) => self.control(word),
            Some(0x03) if (100..=1_000_000).contains(&word) => self.written.scan_period_us = word,
            Some(0x04) if (1..=512).contains(&word) => self.written.set_length = word,
            _ => {}
        }
    }

    fn control(&mut self, word: u32) {
        if word & RESTART != 0 {
            self.waiting = None;
            self.next_number = 0;
            self.lost = 0;
            self.lost_since_release = false;
            self.last_was_lost = false;
        }
        let run = word & RUN != 0;
        if run != self.running || word & RESTART != 0 {
            self.filling.clear();
            self.active = self.written;
            self.changed = true;
        }
        self.running = run;
    }

    fn header(&self, bank: &Bank) -> [u32; HEADER_WORDS] {
        let mut sums = [0_u32; 4];
        let mut squares = [0_u64; 4];
        for scan in bank.samples.chunks_exact(4) {
            for (channel, &sample) in scan.iter().enumerate() {
                sums[channel] += u32::from(sample);
                squares[channel] += u64::from(sample) * u64::from(sample);
            }
        }
        let length = u32::try_from(bank.samples.len() / 4).unwrap_or(u32::MAX);
        let mut words = [0; HEADER_WORDS];
        words[0] = bank.number;
        words[1] = length << 16 | u32::from(bank.lost_before);
        words[2] = self.lost;
        words[3..7].copy_from_slice(&sums);
        for (pair, square) in words[7..15].chunks_exact_mut(2).zip(squares) {
            let bytes = square.to_be_bytes();
            pair[0] = u32::from_be_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
            pair[1] = u32::from_be_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]);
        }
        let mut crc = Crc32::new();
        words[..15].iter().for_each(|&word| crc.push(word));
        words[15] = crc.value();
        words
    }

    fn burst_word(&self, transfer: &mut Transfer, index: usize) -> u32 {
        let (Some(header), Some(bank)) = (&transfer.header, &self.waiting) else { return 0 };
        if index < HEADER_WORDS {
            return header[index];
        }
        let first = (index - HEADER_WORDS) * 2;
        match bank.samples.get(first..first + 2) {
            Some(pair) => {
                let word = u32::from(pair[0]) << 16 | u32::from(pair[1]);
                transfer.samples_crc.push(word);
                word
            }
            None if first == bank.samples.len() => transfer.samples_crc.value(),
            None => 0,
        }
    }
}

/// The address of a word of a transfer; none from the burst on, where there are only reserved ones.
fn address_of(transfer: &Transfer, index: usize) -> Option<u8> {
    let address = u8::try_from(usize::from(transfer.address) + index).ok()?;
    (address < SET).then_some(address)
}

#[cfg(test)]
#[path = "port_tests.rs"]
mod tests;
