//! The acquisition when the processor drives the A/D itself: a scan on every tick of a timer, sets kept in memory.

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::SpiDevice;

use crate::acquisition::{Acquisition, NumberedScan, Set, Timing, axis_samples};
use crate::ad7949::Ad7949;
use zerorate_core::units::Axis;

/// Sets taken scan by scan by the processor.
///
/// The timer's interrupt calls [`tick`](Self::tick) every scan period; when it says that a set is full, the
/// compensator is called. A set that has not been read when the next is full is lost, and counted.
pub struct DirectAcquisition<SPI, DELAY> {
    converter: Ad7949<SPI, DELAY>,
    /// Scans of the set that is being filled, and of those after it.
    filling_length: usize,
    set_length: usize,
    running: bool,
    next_number: u32,
    lost: u32,
    scans: u32,
    latest: Option<NumberedScan>,
    filling: Set,
    waiting: Option<Set>,
}

impl<SPI: SpiDevice, DELAY: DelayNs> DirectAcquisition<SPI, DELAY> {
    /// An acquisition on the A/D's SPI device, stopped.
    #[must_use]
    pub fn new(spi: SPI, delay: DELAY) -> Self {
        let converter = Ad7949::new(spi, delay);
        let set_length = usize::from(Timing::PAPER.set_length);
        let filling = Set::default();
        Self {
            converter,
            filling_length: set_length,
            set_length,
            running: false,
            next_number: 0,
            lost: 0,
            scans: 0,
            latest: None,
            filling,
            waiting: None,
        }
    }

    /// Whether scans are being taken.
    #[must_use]
    pub const fn is_running(&self) -> bool {
        self.running
    }

    /// Takes one scan; `true` when it filled a set.
    ///
    /// # Errors
    /// The SPI's; the scan is then missing from its set, which is longer in time by it.
    pub fn tick(&mut self) -> Result<bool, SPI::Error> {
        if !self.running {
            return Ok(false);
        }
        let scan = self.converter.scan()?;
        self.latest = Some(NumberedScan { number: self.scans, scan });
        self.scans = self.scans.wrapping_add(1);
        for axis in Axis::BOTH {
            let (temperature, zro) = axis_samples(&scan, axis);
            self.filling.sums[axis.index()].push(temperature, zro);
        }
        // A set is handed over before it could outgrow its memory.
        let _ = self.filling.scans.push(scan);
        if self.filling.scans.len() < self.filling_length {
            return Ok(false);
        }
        self.filling_length = self.set_length;
        let mut full = core::mem::take(&mut self.filling);
        full.number = self.next_number;
        self.next_number += 1;
        self.lost += u32::from(self.waiting.is_some());
        full.lost = self.lost;
        self.waiting = Some(full);
        Ok(true)
    }

    /// The number of the set that waits to be read.
    #[must_use]
    pub fn waiting_number(&self) -> Option<u32> {
        self.waiting.as_ref().map(|set| set.number)
    }
}

impl<SPI: SpiDevice, DELAY: DelayNs> Acquisition for DirectAcquisition<SPI, DELAY>
where
    SPI::Error: core::fmt::Debug,
{
    type Error = SPI::Error;

    fn start(&mut self, timing: Timing, first: u16) -> Result<(), Self::Error> {
        let possible = |length| usize::from(length).clamp(1, crate::acquisition::MAX_SET_LENGTH);
        (self.filling_length, self.set_length) = (possible(first), possible(timing.set_length));
        self.next_number = 0;
        self.lost = 0;
        self.scans = 0;
        self.latest = None;
        self.filling = Set::default();
        self.waiting = None;
        self.running = true;
        Ok(())
    }

    fn stop(&mut self) -> Result<(), Self::Error> {
        self.running = false;
        self.filling = Set::default();
        Ok(())
    }

    fn read_set(&mut self, set: &mut Set, then_scans: bool) -> Result<bool, Self::Error> {
        let Some(waiting) = self.waiting.take() else {
            return Ok(false);
        };
        *set = waiting;
        if !then_scans {
            set.scans.clear();
        }
        Ok(true)
    }

    /// They came with the set: what was sampled here need not be fetched.
    fn read_scans(&mut self, _: &mut Set) -> Result<(), Self::Error> {
        Ok(())
    }

    fn latest_scan(&mut self) -> Result<Option<NumberedScan>, Self::Error> {
        Ok(self.latest)
    }
}
