//! The processor's side: an SPI master whose clock is as uneven as is asked, and the A/D's SPI for a processor that drives
//! it itself.

use core::cell::Cell;
use core::convert::Infallible;
use std::rc::Rc;

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};

use crate::Ps;
use crate::ad7949::{Ad7949, Frame};
use crate::bench::Bench;
use crate::burst::written;
use crate::random::Random;

/// From chip select's rise to data ready's fall, at most: five of the block's clocks when a set is released, and one more when
/// a restart drops it.
const FALL_PS: Ps = 250_000;

/// How a master clocks. Each range is drawn from anew every time.
#[derive(Debug, Clone, Copy)]
pub struct Timing {
    /// SCK's period, from transfer to transfer.
    pub period_ps: (Ps, Ps),
    /// The part of the period that SCK is low, percent, from bit to bit.
    pub low_percent: (u64, u64),
    /// Between two bytes, one time in eight.
    pub pause_ps: (Ps, Ps),
    /// From chip select to SCK, from SCK to chip select, and between transfers.
    pub around_ps: (Ps, Ps),
}

impl Timing {
    /// 10 MHz without a pause.
    pub const FASTEST: Self =
        Self { period_ps: (100_000, 100_000), low_percent: (50, 50), pause_ps: (0, 0), around_ps: (50_000, 50_000) };
    /// From 1 to 10 MHz, uneven, with pauses up to 2 us.
    pub const UNEVEN: Self = Self {
        period_ps: (100_000, 1_000_000),
        low_percent: (40, 60),
        pause_ps: (0, 2_000_000),
        around_ps: (50_000, 1_000_000),
    };
    /// From 5 to 10 MHz, uneven, and chip select close beside SCK or itself: where the clocks meet in the most ways.
    pub const QUICK: Self = Self {
        period_ps: (100_000, 200_000),
        low_percent: (40, 60),
        pause_ps: (0, 200_000),
        around_ps: (2_000, 200_000),
    };
}

/// The master, and the board that it is on.
#[derive(Debug)]
pub struct Port {
    /// The board.
    pub bench: Bench,
    timing: Timing,
    random: Random,
    period_ps: Ps,
}

impl Port {
    /// A master; the seed is for its unevenness.
    #[must_use]
    pub fn new(bench: Bench, timing: Timing, seed: u64) -> Self {
        Self { bench, timing, random: Random::new(seed), period_ps: timing.period_ps.0 }
    }

    /// Clocks otherwise from the next transfer on.
    pub fn set_timing(&mut self, timing: Timing) {
        self.timing = timing;
    }

    /// Chip select falls.
    pub fn select(&mut self) {
        self.period_ps = self.draw(self.timing.period_ps);
        self.bench.drive_spi(false, false, false);
        let lead_ps = self.draw(self.timing.around_ps);
        self.bench.pass(lead_ps);
    }

    /// Chip select rises, at any bit.
    pub fn deselect(&mut self) {
        let trail_ps = self.draw(self.timing.around_ps);
        self.bench.pass(trail_ps);
        self.bench.drive_spi(true, false, false);
        let gap_ps = self.draw(self.timing.around_ps);
        self.bench.pass(gap_ps);
    }

    /// The first bits of a byte, most significant first; what came back stands at the low end.
    pub fn bits(&mut self, byte: u8, count: u32) -> u8 {
        if self.random.one_in(8) {
            let pause_ps = self.draw(self.timing.pause_ps);
            self.bench.pass(pause_ps);
        }
        let mut back = 0;
        for place in 0..count {
            let low_ps = self.period_ps * self.draw(self.timing.low_percent) / 100;
            let mosi = byte >> (7 - place) & 1 == 1;
            self.bench.drive_spi(false, false, mosi);
            self.bench.pass(low_ps);
            back = back << 1 | u8::from(self.bench.miso());
            self.bench.drive_spi(false, true, mosi);
            self.bench.pass(self.period_ps - low_ps);
            self.bench.drive_spi(false, false, mosi);
        }
        back
    }

    /// A byte each way.
    pub fn byte(&mut self, byte: u8) -> u8 {
        self.bits(byte, 8)
    }

    /// Four bytes, nothing sent.
    pub fn word(&mut self) -> u32 {
        u32::from_be_bytes([0; 4].map(|zero: u8| self.byte(zero)))
    }

    /// Reads words from an address on.
    pub fn read(&mut self, address: u8, words: usize) -> Vec<u32> {
        self.select();
        let head = [address, 0].map(|byte| self.byte(byte));
        assert_eq!(head, [0, 0], "nothing is sent before the first word");
        let words = (0..words).map(|_| self.word()).collect();
        self.deselect();
        words
    }

    /// Reads the burst of a set of so many scans, to its last word.
    pub fn read_set(&mut self, length: usize) -> Vec<u32> {
        self.read(0x10, 16 + 2 * length + 1)
    }

    /// Writes a word.
    pub fn write(&mut self, address: u8, word: u32) {
        self.select();
        written(address, word).into_iter().for_each(|byte| _ = self.byte(byte));
        self.deselect();
    }

    /// Sets SCAN_PERIOD and SET_LENGTH, and starts anew with RESTART. The bench counts its scans from here.
    pub fn start(&mut self, period_us: u32, length: u32) {
        self.write(0x02, 0);
        self.write(0x03, period_us);
        self.write(0x04, length);
        self.write(0x02, 0b11);
        self.bench.count_scans();
    }

    /// Waits for the data ready line, or so many microseconds of SCAN_PERIOD; whether it is high.
    pub fn wait_for_data_ready(&mut self, at_most_us: u64) -> bool {
        let until_ps = self.bench.now_ps() + self.bench.period_ps(at_most_us);
        self.bench.pass(FALL_PS);
        while !self.bench.data_ready() && self.bench.now_ps() < until_ps {
            self.bench.pass(200_000);
        }
        self.bench.data_ready()
    }

    fn draw(&mut self, (low, high): (u64, u64)) -> u64 {
        self.random.between(low, high)
    }
}

impl ErrorType for Port {
    type Error = Infallible;
}

impl SpiDevice for Port {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        self.select();
        for operation in operations {
            match operation {
                Operation::Read(bytes) => bytes.iter_mut().for_each(|byte| *byte = self.byte(0)),
                Operation::Write(bytes) => bytes.iter().for_each(|&byte| _ = self.byte(byte)),
                Operation::TransferInPlace(bytes) => bytes.iter_mut().for_each(|byte| *byte = self.byte(*byte)),
                Operation::Transfer(read, write) => {
                    for place in 0..read.len().max(write.len()) {
                        let back = self.byte(write.get(place).copied().unwrap_or(0));
                        if let Some(byte) = read.get_mut(place) {
                            *byte = back;
                        }
                    }
                }
                Operation::DelayNs(ns) => self.bench.pass(u64::from(*ns) * 1000),
            }
        }
        self.deselect();
        Ok(())
    }
}

/// The A/D on the processor's own SPI, without any gateware between them.
pub struct ConverterSpi<F> {
    converter: Ad7949,
    input: F,
    now_ps: Rc<Cell<Ps>>,
}

/// The processor's delay beside that SPI, on the same clock.
pub struct ConverterDelay(Rc<Cell<Ps>>);

impl DelayNs for ConverterDelay {
    fn delay_ns(&mut self, ns: u32) {
        self.0.set(self.0.get() + 1000 * Ps::from(ns));
    }
}

impl<F: FnMut(usize) -> u16> ConverterSpi<F> {
    /// The part; `input` as for [`Bench::new`].
    pub fn new(converter: Ad7949, input: F) -> Self {
        Self { converter, input, now_ps: Rc::new(Cell::new(10_000_000)) }
    }

    /// The processor's delay.
    #[must_use]
    pub fn delay(&self) -> ConverterDelay {
        ConverterDelay(Rc::clone(&self.now_ps))
    }

    fn pins(&mut self, cnv: bool, sck: bool, din: bool) -> Option<Frame> {
        // 5 MHz.
        self.now_ps.set(self.now_ps.get() + 100_000);
        self.converter.pins(self.now_ps.get(), cnv, sck, din, &mut self.input)
    }
}

impl<F> ErrorType for ConverterSpi<F> {
    type Error = Infallible;
}

impl<F: FnMut(usize) -> u16> SpiDevice for ConverterSpi<F> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        self.pins(false, false, false);
        for operation in operations {
            let Operation::TransferInPlace(bytes) = operation else {
                panic!("the A/D's driver exchanges frames in place");
            };
            for byte in bytes.iter_mut() {
                let mut back = 0;
                for place in (0..8).rev() {
                    let din = *byte >> place & 1 == 1;
                    back = back << 1 | u8::from(self.converter.sdo());
                    self.pins(false, true, din);
                    self.pins(false, false, din);
                }
                *byte = back;
            }
        }
        self.pins(true, false, false);
        assert_eq!(self.converter.faults, [""; 0], "what the processor's driver does to the A/D, by its data sheet");
        Ok(())
    }
}
