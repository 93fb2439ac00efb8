//! What a compensation test left.

use std::fmt;

/// How the axis was compensated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// By the potentiometer alone, as in the paper.
    Trim,
    /// In numbers alone.
    Digital,
    /// By the potentiometer, and the rest in numbers.
    Hybrid,
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Trim => "trim",
            Self::Digital => "digital",
            Self::Hybrid => "hybrid",
        })
    }
}

/// Which way the chamber went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// From cold to hot, as the ramp that was fitted.
    Heating,
    /// From hot to cold.
    Cooling,
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Heating => "heating",
            Self::Cooling => "cooling",
        })
    }
}

/// One compensation test: one axis compensated, the other left alone. All of it is held out: the law comes from another
/// run. The names are those of `summary.json`.
#[derive(Debug, Clone, PartialEq)]
pub struct CompensationTest {
    /// How the axis was compensated.
    pub mode: Mode,
    /// The compensated axis, as `X`.
    pub axis: String,
    /// The control, as `Y`.
    pub control: String,
    /// Which way the chamber went.
    pub direction: Direction,
    /// What the compensated axis did, peak to peak of group means over the hour.
    pub residual_pp_counts: f64,
    /// The same, root mean square about its mean.
    pub residual_rms_counts: f64,
    /// What the control did, peak to peak of group means over the hour.
    pub control_pp_counts: f64,
    /// What the compensated axis did in the full-temperature test, peak to peak: the ratio is of this to the residual.
    pub uncompensated_pp_counts: f64,
    /// What no compensation could beat, peak to peak: the same groups without the plant's true drift and wiper voltage.
    pub floor_pp_counts: f64,
    /// Writes to the wiper, after the first.
    pub wiper_writes: u32,
    /// Tap changes of the noise-free law with the same dead band, after the first.
    pub taps_crossed: u32,
    /// Mean of the compensated axis.
    pub mean_counts: f64,
    /// Largest jump of the corrected samples, low-passed by 20, in the second after a tap change, less its size
    /// elsewhere.
    pub largest_step_counts: f64,
    /// The groups of the hour, in order of time.
    pub points: Vec<TestPoint>,
}

/// A group of a compensation test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TestPoint {
    /// Time since the ramp began.
    pub elapsed_s: f64,
    /// Mean temperature reading of the compensated axis.
    pub temperature_counts: f64,
    /// Mean corrected reading of the compensated axis.
    pub compensated_counts: f64,
    /// Mean reading of the control.
    pub control_counts: f64,
}

impl CompensationTest {
    /// How many times smaller the residual is than the drift of the uncompensated axis.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.uncompensated_pp_counts / self.residual_pp_counts
    }
}
