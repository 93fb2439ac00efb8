//! The acquisition port: the SPI slave of `docs/acquisition-port.md`, version 2.2, with its two banks.

use crate::crc32::Crc32;
use crate::oversampling::MOST_PASSES;

/// "ZRAQ".
const IDENTITY: u32 = 0x5A52_4151;
const VERSION: u32 = 0x0002_0002;
const RUN: u32 = 1 << 0;
const RESTART: u32 = 1 << 1;
const READY: u32 = 1 << 0;
const OVERRUN: u32 = 1 << 1;
/// From scan to scan, and from pass to pass, at least.
const SHORTEST_PERIOD_US: u32 = 100;
/// The burst's address.
const SET: u8 = 0x10;
/// The latest scan's address, and its words.
const SCAN: u8 = 0x20;
const SCAN_WORDS: usize = 4;
/// Words of the burst before the samples, their CRC included.
const HEADER_WORDS: usize = 16;
/// Bit 7 of the first byte.
const WRITE: u8 = 1 << 7;
/// The first byte, both bytes of the head, a word, and a whole write with its CRC, in bits.
const ADDRESS_BITS: usize = 8;
const HEAD_BITS: usize = 16;
const WORD_BITS: usize = 32;
const WRITE_BITS: usize = HEAD_BITS + 2 * WORD_BITS;

/// What a set is filled by: taken up at its start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Settings {
    scan_period_us: u32,
    set_length: u32,
    /// Passes a scan, as they were asked for.
    oversampling: u32,
}

impl Settings {
    /// The passes that a scan has room for: no two come sooner after each other than two scans may.
    fn passes(self) -> u32 {
        let mut passes = self.oversampling;
        while passes * SHORTEST_PERIOD_US > self.scan_period_us {
            passes /= 2;
        }
        passes
    }
}

/// A full set that waits.
#[derive(Debug, Clone, Default)]
struct Bank {
    /// Samples in the order of the burst: scan by scan, channel by channel.
    samples: Vec<u16>,
    number: u32,
    lost_before: bool,
}

/// One SPI transfer in progress: two shift registers, and what the next word to send comes from.
#[derive(Debug, Clone)]
struct Transfer {
    /// Clocks since chip select fell.
    bits: usize,
    /// What has come, the last bit lowest.
    received: u128,
    /// What is still to be sent of a word, the next bit highest.
    sending: u32,
    /// The first byte, once it is in.
    head: u8,
    /// Words 0 to 15 of the burst, as they were when it began; `None` when no set waited.
    header: Option<[u32; HEADER_WORDS]>,
    samples_crc: Crc32,
    /// The latest scan as it was when its reading began.
    scan: [u32; SCAN_WORDS],
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
    /// Scans since RESTART, and the last of them.
    scans: u32,
    latest: Option<[u16; 4]>,
    transfer: Option<Transfer>,
    changed: bool,
}

impl Port {
    pub(crate) fn new() -> Self {
        let settings = Settings { scan_period_us: 3000, set_length: 500, oversampling: 1 };
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
            scans: 0,
            latest: None,
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

    /// Passes of a scan.
    pub(crate) fn passes(&self) -> u32 {
        self.active.passes()
    }

    /// Whether scanning was stopped or started anew since this was last asked: the first scan is a period from then.
    pub(crate) fn take_changed(&mut self) -> bool {
        core::mem::take(&mut self.changed)
    }

    /// Takes a scan; the set's number if this fills it, lost or not.
    pub(crate) fn push(&mut self, scan: [u16; 4]) -> Option<u32> {
        self.latest = Some(scan);
        self.scans = self.scans.wrapping_add(1);
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
            bits: 0,
            received: 0,
            sending: 0,
            head: 0,
            header: None,
            samples_crc: Crc32::new(),
            scan: [0; SCAN_WORDS],
        });
    }

    /// A clock: a bit in and a bit out.
    pub(crate) fn clock(&mut self, bit: bool) -> bool {
        let Some(transfer) = &mut self.transfer else { return false };
        let sent = transfer.sending >> 31 == 1;
        transfer.sending <<= 1;
        transfer.received = transfer.received << 1 | u128::from(bit);
        transfer.bits += 1;
        if transfer.bits == ADDRESS_BITS {
            [.., transfer.head] = transfer.received.to_be_bytes();
            match transfer.head {
                SET => transfer.header = self.waiting.as_ref().map(|bank| header(bank, self.lost)),
                SCAN => transfer.scan = latest(self.scans, self.latest),
                _ => {}
            }
        }
        if transfer.bits >= HEAD_BITS && (transfer.bits - HEAD_BITS).is_multiple_of(WORD_BITS) {
            self.load();
        }
        sent
    }

    /// Chip select rises: a write that is whole takes effect, and a set whose header was sent whole is released.
    pub(crate) fn deselect(&mut self) {
        let Some(transfer) = self.transfer.take() else { return };
        if let Some((address, word)) = transfer.written() {
            self.write(address, word);
        }
        if transfer.header.is_some() && transfer.bits >= HEAD_BITS + WORD_BITS * HEADER_WORDS {
            self.waiting = None;
            self.lost_since_release = false;
        }
    }

    /// The next word goes to the shift register.
    fn load(&mut self) {
        let Some(mut transfer) = self.transfer.take() else { return };
        let index = (transfer.bits - HEAD_BITS) / WORD_BITS;
        transfer.sending = match transfer.head {
            SET => self.burst_word(&mut transfer, index),
            SCAN => transfer.scan.get(index).copied().unwrap_or(0),
            head if head & WRITE != 0 => 0,
            first => self.read(address_of(first, index)),
        };
        self.transfer = Some(transfer);
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
            Some(0x06) => self.written.passes(),
            _ => 0,
        }
    }

    fn write(&mut self, address: u8, word: u32) {
        match address {
            0x02 => self.control(word),
            0x03 if (SHORTEST_PERIOD_US..=1_000_000).contains(&word) => self.written.scan_period_us = word,
            0x04 if (1..=512).contains(&word) => self.written.set_length = word,
            0x06 if word.is_power_of_two() && word <= MOST_PASSES => self.written.oversampling = word,
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
            self.scans = 0;
            self.latest = None;
        }
        let run = word & RUN != 0;
        if run != self.running || word & RESTART != 0 {
            self.filling.clear();
            self.active = self.written;
            self.changed = true;
        }
        self.running = run;
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
                transfer.samples_crc.push(&word.to_be_bytes());
                word
            }
            None if first == bank.samples.len() => transfer.samples_crc.value(),
            None => 0,
        }
    }
}

impl Transfer {
    /// The address and the word of a write; none unless all of it came, nothing after it, and its CRC is right.
    fn written(&self) -> Option<(u8, u32)> {
        let [.., head, around, a, b, c, d, e, f, g, h] = self.received.to_be_bytes();
        let mut crc = Crc32::new();
        crc.push(&[head, around, a, b, c, d]);
        let is_whole = self.bits == WRITE_BITS && head & WRITE != 0 && crc.value() == u32::from_be_bytes([e, f, g, h]);
        is_whole.then(|| (head & !WRITE, u32::from_be_bytes([a, b, c, d])))
    }
}

/// Words 0 to 15 of a set's burst.
fn header(bank: &Bank, lost: u32) -> [u32; HEADER_WORDS] {
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
    words[2] = lost;
    words[3..7].copy_from_slice(&sums);
    for (pair, square) in words[7..15].chunks_exact_mut(2).zip(squares) {
        let bytes = square.to_be_bytes();
        pair[0] = u32::from_be_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        pair[1] = u32::from_be_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]);
    }
    let mut crc = Crc32::new();
    words[..15].iter().for_each(|word| crc.push(&word.to_be_bytes()));
    words[15] = crc.value();
    words
}

/// The words of the latest scan, the last of so many since RESTART; zeros before the first.
fn latest(scans: u32, samples: Option<[u16; 4]>) -> [u32; SCAN_WORDS] {
    let Some([a, b, c, d]) = samples.map(|samples| samples.map(u32::from)) else { return [0; SCAN_WORDS] };
    let mut words = [scans.wrapping_sub(1), a << 16 | b, c << 16 | d, 0];
    let mut crc = Crc32::new();
    words[..3].iter().for_each(|word| crc.push(&word.to_be_bytes()));
    words[3] = !crc.value();
    words
}

/// The address of a word of a read; none from the burst on, where there are only reserved ones.
fn address_of(first: u8, index: usize) -> Option<u8> {
    let address = u8::try_from(usize::from(first) + index).ok()?;
    (address < SET).then_some(address)
}

#[cfg(test)]
#[path = "port_tests.rs"]
mod tests;
