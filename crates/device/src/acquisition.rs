//! Where sets of samples come from.

use heapless::Vec;
use zerorate_core::group::GroupSums;
use zerorate_core::units::Axis;

/// The longest set, scans: what the acquisition port's banks hold (docs/acquisition-port.md).
pub const MAX_SET_LENGTH: usize = 512;

/// One sample of each channel, counts: temperature X, zero-rate X, temperature Y, zero-rate Y (paper, S3).
pub type Scan = [u16; 4];

/// The temperature and zero-rate samples of one axis in a scan.
#[must_use]
pub const fn axis_samples(scan: &Scan, axis: Axis) -> (u16, u16) {
    (scan[2 * axis.index()], scan[2 * axis.index() + 1])
}

/// How sets are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timing {
    /// Microseconds from scan to scan.
    pub scan_period_us: u32,
    /// Scans a set, 1 to [`MAX_SET_LENGTH`].
    pub set_length: u16,
    /// Conversions of each channel that a sample is the mean of: 1, 2, 4, 8 or 16. A port before version 2.2 and a processor
    /// that drives the A/D itself have one, whatever is asked for.
    pub oversampling: u8,
}

impl Timing {
    /// The paper's: 40 groups a minute of 500 samples (S5), a conversion each.
    pub const PAPER: Self = Self { scan_period_us: 3000, set_length: 500, oversampling: 1 };

    /// How long a set takes, microseconds.
    #[must_use]
    pub(crate) const fn period_us(self) -> u64 {
        self.scan_period_us as u64 * self.set_length as u64
    }
}

/// A set as it was read: the raw material of one group.
#[derive(Debug, Clone, Default)]
pub struct Set {
    /// Its number since the acquisition started; lost sets count.
    pub number: u32,
    /// Sets lost since the acquisition started.
    pub lost: u32,
    /// The exact sums of each axis, X then Y.
    pub sums: [GroupSums; 2],
    /// The scans; empty until they are read.
    pub scans: Vec<Scan, MAX_SET_LENGTH>,
}

impl Set {
    /// None yet: the same as the default.
    #[must_use]
    pub const fn new() -> Self {
        Self { number: 0, lost: 0, sums: [GroupSums::NONE; 2], scans: Vec::new() }
    }
}

/// A scan as it was read alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NumberedScan {
    /// Its number since the acquisition started: every scan counts.
    pub number: u32,
    /// Its samples.
    pub scan: Scan,
}

/// What the processor asks of an acquisition, whoever drives the A/D.
pub trait Acquisition {
    /// What can go wrong.
    type Error: core::fmt::Debug;

    /// Starts anew at set 0, which has `first` scans; every further one has as many as `timing` says.
    ///
    /// # Errors
    /// When the acquisition cannot be reached.
    fn start(&mut self, timing: Timing, first: u16) -> Result<(), Self::Error>;

    /// Stops; the set that is being filled is dropped.
    ///
    /// # Errors
    /// When the acquisition cannot be reached.
    fn stop(&mut self) -> Result<(), Self::Error>;

    /// Reads number and sums of the set that waits into `set`; `false` when none waits. Where its scans are to be read
    /// after that it goes on waiting: nothing that the law needs waits for them.
    ///
    /// # Errors
    /// When the acquisition cannot be reached, or what came is not whole.
    fn read_set(&mut self, set: &mut Set, then_scans: bool) -> Result<bool, Self::Error>;

    /// Reads the scans of the set whose sums were just read.
    ///
    /// # Errors
    /// When the acquisition cannot be reached, what came is not whole, or another set has come meanwhile.
    fn read_scans(&mut self, set: &mut Set) -> Result<(), Self::Error>;

    /// Reads the scan that was taken last; `None` before the first, and where this acquisition gives whole sets alone.
    ///
    /// # Errors
    /// When the acquisition cannot be reached, or what came is not whole.
    fn latest_scan(&mut self) -> Result<Option<NumberedScan>, Self::Error>;
}
