//! What was found out about one axis before it was compensated.

use zerorate_fit::drift_fit::Candidate;

/// One axis: its ramp, its drift, its trim.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibratedAxis {
    /// The axis, as `X`.
    pub name: String,
    /// The groups of the full-temperature test's hour, in order of time.
    pub ramp: Vec<RampPoint>,
    /// The fit of the drift.
    pub drift: DriftFacts,
    /// The fit of the trim.
    pub trim: TrimFacts,
}

/// A group of the full-temperature test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RampPoint {
    /// Time since the ramp began.
    pub elapsed_s: f64,
    /// Mean temperature reading.
    pub temperature_counts: f64,
    /// Mean zero-rate output at the middle tap.
    pub zro_counts: f64,
    /// The fitted curve at this temperature.
    pub fitted_counts: f64,
}

/// The fitted drift.
#[derive(Debug, Clone, PartialEq)]
pub struct DriftFacts {
    /// The model chosen, as `poly:2`.
    pub model: String,
    /// Whether it remembers its temperatures; the coefficients are then of the curve for when it does not know them yet.
    pub remembers: bool,
    /// The polynomial's coefficients, counts over counts of temperature to the power of the place; empty for a table.
    pub raw_coefficients: Vec<f64>,
    /// The valid range.
    pub temperature_counts: [f64; 2],
    /// Peak to peak of the group means over the hour.
    pub drift_pp_counts: f64,
    /// Residual, root mean square, in-sample.
    pub fit_rms_counts: f64,
    /// Residual, root mean square, held out.
    pub held_out_rms_counts: f64,
    /// Against the plant's truth: the largest distance of the curve from the deterministic drift of this run.
    pub curve_error_counts: Option<f64>,
    /// The models compared, simplest first; may be empty.
    pub candidates: Vec<Candidate>,
}

/// The fitted trim.
#[derive(Debug, Clone, PartialEq)]
pub struct TrimFacts {
    /// The 21 points, in order of voltage.
    pub points: Vec<TrimPoint>,
    /// By the paper's formula: dV against the mean of the trimmed readings.
    pub paper: TrimLine,
    /// By the better one: each point against its own trimmed reading. This one is deployed.
    pub better: TrimLine,
    /// The plant's truth: its local slope, taps a count.
    pub plant_slope_taps_per_count: Option<f64>,
    /// How far each tap of the working range is from the line.
    pub taps: Vec<TapDeviation>,
}

/// One voltage of the trim experiment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrimPoint {
    /// Reading at the middle tap less the trimmed reading of the same voltage.
    pub delta_counts: f64,
    /// Taps from the middle one to the one at which the reading is nearest the centre.
    pub delta_taps: f64,
}

/// dN = a (V - V0) + b.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrimLine {
    /// a, taps a count.
    pub slope_taps_per_count: f64,
    /// b, taps.
    pub intercept_taps: f64,
    /// V0: the mean of the trimmed readings, or the centre aimed at.
    pub centre_counts: f64,
}

/// One tap's own effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TapDeviation {
    /// The tap, 0 to 1023.
    pub tap: u16,
    /// Measured effect less that of the line.
    pub deviation_counts: f64,
}

/// A curve as points, temperature and value, in order of temperature.
pub type Curve = Vec<(f64, f64)>;

impl CalibratedAxis {
    /// The fitted curve over the recorded temperatures, counts against counts.
    #[must_use]
    pub fn fitted_curve(&self) -> Curve {
        let mut curve: Curve = self.ramp.iter().map(|point| (point.temperature_counts, point.fitted_counts)).collect();
        curve.sort_by(|a, b| a.0.total_cmp(&b.0));
        curve
    }
}
