//! The acquisition port's master: reads whole sets (docs/acquisition-port.md, version 2.2). Of one whose scans are wanted it
//! reads the sums first, and the scans when the wipers are written: they take 6 ms on the bus, two sample periods.

use crc::{CRC_32_MPEG_2, Crc, NoTable};
use embedded_hal::spi::{Operation, SpiDevice};
use zerorate_core::group::GroupSums;

use crate::acquisition::{Acquisition, NumberedScan, Set, Timing};

/// A bit at a time: a set takes 6 ms on the bus with its scans, its CRC a seventh of that; a table would be 1 KiB of flash.
const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_MPEG_2);

const READ: u8 = 0x00;
const WRITE: u8 = 0x80;

const IDENTITY: u8 = 0x00;
const VERSION: u8 = 0x01;
const CONTROL: u8 = 0x02;
const SCAN_PERIOD: u8 = 0x03;
const SET_LENGTH: u8 = 0x04;
const STATUS: u8 = 0x05;
const OVERSAMPLING: u8 = 0x06;
const SET: u8 = 0x10;
const SCAN: u8 = 0x20;

/// "ZRAQ".
const EXPECTED_IDENTITY: u32 = 0x5A52_4151;
/// The major version this master speaks; minor ones add registers.
const EXPECTED_MAJOR: u32 = 2;
/// The minor version since which a port has the latest scan.
const MINOR_WITH_SCAN: u32 = 1;
/// The minor version since which it oversamples.
const MINOR_WITH_OVERSAMPLING: u32 = 2;

const CONTROL_RUN: u32 = 1;
const CONTROL_RESTART: u32 = 2;
const STATUS_READY: u32 = 1;

/// Words 0 to 15: set number, length, lost, sums, sums of squares, CRC.
const HEAD_BYTES: usize = 64;
const CRC_BYTES: usize = 4;
/// So much of it leaves the set waiting: it is released with the CRC's last byte. The other three tell damage but for one
/// time in 16 million.
const KEEPING_BYTES: usize = HEAD_BYTES - 1;
const SET_HEADER: [u8; 2] = [READ | SET, 0];
/// The latest scan: its number, its samples, their CRC inverted.
const SCAN_BYTES: usize = 16;

/// What can go wrong at the port.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PortError<E> {
    /// The SPI transfer failed.
    Spi(E),
    /// Whatever answers is not an acquisition port.
    NotAPort {
        /// What it gave as its identity.
        identity: u32,
    },
    /// A port of a version that this master does not speak.
    UnknownVersion {
        /// The version register.
        version: u32,
    },
    /// A register does not hold what was written to it.
    NotTaken {
        /// The register's address.
        address: u8,
        /// What it holds.
        found: u32,
    },
    /// A set or a scan came whose CRC does not match.
    Damaged,
    /// The set whose scans are wanted is not there any more.
    AnotherSet {
        /// The one that is.
        number: u32,
    },
    /// A set came of another length than was asked for.
    Length {
        /// Its length, scans.
        found: u16,
    },
}

/// An acquisition behind the port: an FPGA on the board, or the simulated bench.
pub struct PortAcquisition<SPI> {
    spi: SPI,
    /// Scans of the first set since the start, and of every further one.
    first_length: u16,
    set_length: u16,
    /// The port has the latest scan.
    gives_scans: bool,
    /// The port has OVERSAMPLING.
    oversamples: bool,
}

impl<SPI: SpiDevice> PortAcquisition<SPI> {
    /// A master on an SPI device in mode 0, up to 10 MHz.
    #[must_use]
    pub const fn new(spi: SPI) -> Self {
        let set_length = Timing::PAPER.set_length;
        Self { spi, first_length: set_length, set_length, gives_scans: false, oversamples: false }
    }

    fn read_word(&mut self, address: u8) -> Result<u32, PortError<SPI::Error>> {
        let mut word = [0; 4];
        let header = [READ | address, 0];
        let mut burst = [Operation::Write(&header), Operation::Read(&mut word)];
        self.spi.transaction(&mut burst).map_err(PortError::Spi)?;
        Ok(u32::from_be_bytes(word))
    }

    /// A port that gets this bent or in part takes nothing of it.
    fn write_word(&mut self, address: u8, word: u32) -> Result<(), PortError<SPI::Error>> {
        let [a, b, c, d] = word.to_be_bytes();
        let crc = CRC.checksum(&[WRITE | address, 0, a, b, c, d]);
        let [e, f, g, h] = crc.to_be_bytes();
        self.spi.write(&[WRITE | address, 0, a, b, c, d, e, f, g, h]).map_err(PortError::Spi)
    }

    /// Writes a setting and reads it back: a write that was lost or bent would change what every group means, unseen.
    fn set(&mut self, address: u8, word: u32) -> Result<(), PortError<SPI::Error>> {
        self.write_word(address, word)?;
        self.expect(address, word)
    }

    fn expect(&mut self, address: u8, word: u32) -> Result<(), PortError<SPI::Error>> {
        let found = self.read_word(address)?;
        if found == word { Ok(()) } else { Err(PortError::NotTaken { address, found }) }
    }

    fn check_identity(&mut self) -> Result<(), PortError<SPI::Error>> {
        let identity = self.read_word(IDENTITY)?;
        if identity != EXPECTED_IDENTITY {
            return Err(PortError::NotAPort { identity });
        }
        let version = self.read_word(VERSION)?;
        if version >> 16 != EXPECTED_MAJOR {
            return Err(PortError::UnknownVersion { version });
        }
        self.gives_scans = version & 0xFFFF >= MINOR_WITH_SCAN;
        self.oversamples = version & 0xFFFF >= MINOR_WITH_OVERSAMPLING;
        Ok(())
    }
}

impl<SPI: SpiDevice> Acquisition for PortAcquisition<SPI>
where
    SPI::Error: core::fmt::Debug,
{
    type Error = PortError<SPI::Error>;

    fn start(&mut self, timing: Timing, first: u16) -> Result<(), Self::Error> {
        self.check_identity()?;
        (self.first_length, self.set_length) = (first, timing.set_length);
        self.write_word(CONTROL, 0)?;
        self.set(SCAN_PERIOD, timing.scan_period_us)?;
        self.set(SET_LENGTH, u32::from(first))?;
        if self.oversamples {
            // It reads less where the period has no room for so many.
            self.set(OVERSAMPLING, u32::from(timing.oversampling))?;
        }
        self.write_word(CONTROL, CONTROL_RESTART | CONTROL_RUN)?;
        // A start that was lost would show by silence alone, and be tried again after two groups; RESTART reads back 0.
        self.expect(CONTROL, CONTROL_RUN)?;
        if first != timing.set_length {
            // Taken up where the next set starts.
            self.set(SET_LENGTH, u32::from(timing.set_length))?;
        }
        Ok(())
    }

    fn stop(&mut self) -> Result<(), Self::Error> {
        self.write_word(CONTROL, 0)
    }

    fn read_set(&mut self, set: &mut Set, then_scans: bool) -> Result<bool, Self::Error> {
        if self.read_word(STATUS)? & STATUS_READY == 0 {
            return Ok(false);
        }
        set.scans.clear();
        let mut head = [0; HEAD_BYTES];
        let sent = if then_scans { KEEPING_BYTES } else { HEAD_BYTES };
        self.spi
            .transaction(&mut [Operation::Write(&SET_HEADER), Operation::Read(&mut head[..sent])])
            .map_err(PortError::Spi)?;
        let content = checked(&head[..sent]).ok_or(PortError::Damaged)?;
        (set.number, set.lost, set.sums) = self.numbers(content)?;
        Ok(true)
    }

    fn read_scans(&mut self, set: &mut Set) -> Result<(), Self::Error> {
        let read = self.scans_of(set);
        if read.is_err() {
            set.scans.clear();
        }
        read
    }

    fn latest_scan(&mut self) -> Result<Option<NumberedScan>, Self::Error> {
        if !self.gives_scans {
            return Ok(None);
        }
        let mut bytes = [0; SCAN_BYTES];
        self.spi
            .transaction(&mut [Operation::Write(&[READ | SCAN, 0]), Operation::Read(&mut bytes)])
            .map_err(PortError::Spi)?;
        if bytes == [0; SCAN_BYTES] {
            return Ok(None);
        }
        let (content, crc) = bytes.split_at(SCAN_BYTES - CRC_BYTES);
        if (!CRC.checksum(content)).to_be_bytes() != *crc {
            return Err(PortError::Damaged);
        }
        let (words, _) = content.as_chunks();
        let (pairs, _) = content.as_chunks();
        let sample = |index: usize| u16::from_be_bytes(pairs[2 + index]);
        Ok(Some(NumberedScan { number: u32::from_be_bytes(words[0]), scan: [0, 1, 2, 3].map(sample) }))
    }
}

impl<SPI: SpiDevice> PortAcquisition<SPI> {
    /// The scans are read straight into the set's memory: a second buffer would be a sixth of a board's RAM.
    fn scans_of(&mut self, set: &mut Set) -> Result<(), PortError<SPI::Error>> {
        let (mut head, mut crc) = ([0; HEAD_BYTES], [0; CRC_BYTES]);
        // A port has no set beyond this memory: one that says so is refused by its length or its CRC.
        let _ = set.scans.resize_default(usize::from(self.length_of(set.number)));
        let samples = set.scans.as_flattened_mut();
        let mut burst = [
            Operation::Write(&SET_HEADER),
            Operation::Read(&mut head),
            Operation::Read(bytemuck::cast_slice_mut(samples)),
            Operation::Read(&mut crc),
        ];
        self.spi.transaction(&mut burst).map_err(PortError::Spi)?;
        let is_whole =
            checked(&head).is_some() && CRC.checksum(bytemuck::cast_slice(samples)) == u32::from_be_bytes(crc);
        if !is_whole {
            return Err(PortError::Damaged);
        }
        let [a, b, c, d, ..] = head;
        let number = u32::from_be_bytes([a, b, c, d]);
        if number != set.number {
            return Err(PortError::AnotherSet { number });
        }
        for sample in samples {
            *sample = u16::from_be(*sample);
        }
        Ok(())
    }

    /// Scans of a set by its number.
    const fn length_of(&self, number: u32) -> u16 {
        if number == 0 { self.first_length } else { self.set_length }
    }

    /// A set's number, the sets lost up to it, and its sums, from what its head says.
    fn numbers(&self, content: &[u8]) -> Result<(u32, u32, [GroupSums; 2]), PortError<SPI::Error>> {
        let (words, _) = content.as_chunks();
        let word = |index: usize| u32::from_be_bytes(words[index]);
        let wide = |index: usize| u64::from(word(index)) << 32 | u64::from(word(index + 1));
        let [high, low, ..] = word(1).to_be_bytes();
        let length = u16::from_be_bytes([high, low]);
        if length != self.length_of(word(0)) {
            return Err(PortError::Length { found: length });
        }
        // Four sums from word 3 on, four sums of squares from word 7 on.
        let sums = [0, 2].map(|temperature| {
            let zro = temperature + 1;
            GroupSums {
                n: u32::from(length),
                temperature: u64::from(word(3 + temperature)),
                temperature_sq: wide(7 + 2 * temperature),
                zro: u64::from(word(3 + zro)),
                zro_sq: wide(7 + 2 * zro),
            }
        });
        Ok((word(0), word(2), sums))
    }
}

/// The content of a head, of whose CRC all bytes or the first ones were read; `None` when they do not match.
fn checked(head: &[u8]) -> Option<&[u8]> {
    let (content, crc) = head.split_at_checked(HEAD_BYTES - CRC_BYTES)?;
    CRC.checksum(content).to_be_bytes().starts_with(crc).then_some(content)
}

#[cfg(test)]
mod tests;
