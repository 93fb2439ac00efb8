//! What the report of a calibration shows. The bench fills it; nothing in it is computed from the plant's truth unless its
//! docstring says so, and nothing of it depends on the day: equal contents make equal bytes.

mod axis;
mod compensation;

pub use axis::{CalibratedAxis, Curve, DriftFacts, RampPoint, TapDeviation, TrimFacts, TrimLine, TrimPoint};
pub use compensation::{CompensationTest, Direction, Mode, TestPoint};

use zerorate_cal::quality::Verdict;

/// A whole calibration: the ramp, the fits, the tests.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationReport {
    /// What was calibrated, and on what.
    pub unit: UnitFacts,
    /// What came of it.
    pub verdict: Verdict,
    /// The axes, X first.
    pub axes: Vec<CalibratedAxis>,
    /// The compensation tests, in the order run. The headline takes those of the first one's axis, heating.
    pub tests: Vec<CompensationTest>,
    /// The comparison with soaks, if it was made.
    pub soaks: Option<SoakComparison>,
    /// What was checked, in the order to be read.
    pub checks: Vec<Check>,
    /// What to look at, a sentence each.
    pub warnings: Vec<String>,
}

/// The unit, the bench and the set-up.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitFacts {
    /// The unit's serial number.
    pub serial: String,
    /// The device and what it ran on, as `native device, MAX5494`.
    pub device: String,
    /// The simulated plant's name, as `paper`; none on a real bench.
    pub plant: Option<String>,
    /// The seed of the simulated plant; none on a real bench.
    pub seed: Option<u64>,
    /// The reading aimed at.
    pub centre_counts: f64,
    /// The tap at which drift was recorded.
    pub middle_tap: u16,
    /// Samples averaged to a group, each channel.
    pub group_samples: u32,
    /// Groups a minute.
    pub groups_per_minute: f64,
    /// Counts in one deg/s; with it the headline is given in deg/s as well.
    pub scale_counts_per_dps: Option<f64>,
    /// Further facts, label and value: firmware, set-up file, hashes of the recordings.
    pub further: Vec<(String, String)>,
}

/// One ramp beside the soaks it replaces.
#[derive(Debug, Clone, PartialEq)]
pub struct SoakComparison {
    /// Chamber time of the ramp, its first soak included, hours.
    pub ramp_hours: f64,
    /// Chamber time of all soaks and the ways between them, hours.
    pub soak_hours: f64,
    /// The axes, in the order of [`CalibrationReport::axes`].
    pub axes: Vec<AxisSoaks>,
}

/// The soaks of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisSoaks {
    /// The axis, as `X`.
    pub name: String,
    /// The soaks, coldest first.
    pub points: Vec<SoakPoint>,
    /// The largest distance between the curve through the soaks and that of the ramp, over the temperatures of both.
    pub largest_difference_counts: f64,
}

/// The mean of one soak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SoakPoint {
    /// The chamber's set point.
    pub chamber_c: f64,
    /// The gyro's own temperature reading.
    pub temperature_counts: f64,
    /// The zero-rate output.
    pub zro_counts: f64,
    /// The ramp's fitted curve at that temperature.
    pub ramp_counts: f64,
}

/// Something that was checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// What, in words.
    pub what: String,
    /// The limit, with its unit.
    pub limit: String,
    /// What was measured, with its unit.
    pub measured: String,
    /// Whether it is within the limit.
    pub pass: bool,
}
