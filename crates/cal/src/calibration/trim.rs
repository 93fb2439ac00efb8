//! The trim of one axis, and how it stands in the file.

use serde::{Deserialize, Serialize};
use zerorate_core::compensate::{LowPass, Mode};
use zerorate_core::trim::{MAX_TAP_OFFSETS, TapEffects, Trim, TrimLine};
use zerorate_core::units::{Counts, Taps, Volts};
use zerorate_fit::trim::{SupplyPoint, TrimEstimate};

/// The trim of one axis, and what the law makes of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "TrimForm", into = "TrimForm")]
pub struct TrimCalibration {
    /// The model that the law uses.
    pub trim: Trim,
    /// The points of the experiment, in the order of their voltages; none where it was not made.
    pub points: Vec<SupplyPoint>,
    /// The line by each point's own trimmed reading.
    pub paired: Option<TrimEstimate>,
    /// The line by the paper's formula.
    pub paper: Option<TrimEstimate>,
    /// Dead band, taps.
    pub dead_band_taps: f64,
    /// The circuit's low-pass at the board's sampling.
    pub low_pass: LowPass,
    /// What the axis is to do when the board starts.
    pub start_up_mode: Mode,
}

/// A trim model as it stands in the file.
#[derive(Clone, Serialize, Deserialize)]
struct TrimForm {
    line: LineForm,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    tap_effects: Option<EffectsForm>,
    dead_band_taps: f64,
    low_pass: LowPass,
    #[serde(with = "crate::recording::named")]
    start_up_mode: Mode,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    points: Vec<PointForm>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    line_by_own_readings: Option<TrimEstimate>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    line_by_the_papers_formula: Option<TrimEstimate>,
}

/// `N - N0 = a (V - V0) + b` (eq. 2).
#[derive(Clone, Serialize, Deserialize)]
struct LineForm {
    slope_taps_per_count: f64,
    intercept_taps: f64,
    centre_counts: f64,
    middle_tap: Taps,
}

/// One voltage of the trim experiment.
#[derive(Clone, Serialize, Deserialize)]
struct PointForm {
    supply_v: f64,
    at_middle_counts: f64,
    trimmed_counts: f64,
    tap: Taps,
}

impl From<SupplyPoint> for PointForm {
    fn from(SupplyPoint { supply, at_middle, trimmed, tap }: SupplyPoint) -> Self {
        Self { supply_v: supply.0, at_middle_counts: at_middle.0, trimmed_counts: trimmed.0, tap }
    }
}

impl From<PointForm> for SupplyPoint {
    fn from(PointForm { supply_v, at_middle_counts, trimmed_counts, tap }: PointForm) -> Self {
        Self { supply: Volts(supply_v), at_middle: Counts(at_middle_counts), trimmed: Counts(trimmed_counts), tap }
    }
}

/// What each tap adds to the reading at the middle tap.
#[derive(Clone, Serialize, Deserialize)]
struct EffectsForm {
    first_tap: Taps,
    effects_counts: Vec<f64>,
}

impl From<TrimCalibration> for TrimForm {
    fn from(calibration: TrimCalibration) -> Self {
        let TrimCalibration { trim, points, paired, paper, dead_band_taps, low_pass, start_up_mode } = calibration;
        let Trim { line, measured } = trim;
        Self {
            line: LineForm {
                slope_taps_per_count: line.slope_taps_per_count(),
                intercept_taps: line.intercept_taps(),
                centre_counts: line.centre().0,
                middle_tap: line.middle(),
            },
            tap_effects: measured.map(|measured| EffectsForm {
                first_tap: measured.first(),
                effects_counts: measured.effects().iter().map(|effect| effect.0).collect(),
            }),
            dead_band_taps,
            low_pass,
            start_up_mode,
            points: points.into_iter().map(PointForm::from).collect(),
            line_by_own_readings: paired,
            line_by_the_papers_formula: paper,
        }
    }
}

impl TryFrom<TrimForm> for TrimCalibration {
    type Error = String;
    fn try_from(form: TrimForm) -> Result<Self, String> {
        let LineForm { slope_taps_per_count, intercept_taps, centre_counts, middle_tap } = form.line;
        let line = TrimLine::new(slope_taps_per_count, intercept_taps, Counts(centre_counts), middle_tap)
            .ok_or("a trim line has a slope_taps_per_count below zero")?;
        Ok(Self {
            trim: Trim { line, measured: form.tap_effects.map(EffectsForm::checked).transpose()? },
            points: form.points.into_iter().map(SupplyPoint::from).collect(),
            paired: form.line_by_own_readings,
            paper: form.line_by_the_papers_formula,
            dead_band_taps: form.dead_band_taps,
            low_pass: form.low_pass,
            start_up_mode: form.start_up_mode,
        })
    }
}

impl EffectsForm {
    fn checked(self) -> Result<TapEffects, String> {
        let found = self.effects_counts.len();
        let room = usize::from(Taps::LAST.get() - self.first_tap.get()) + 1;
        if found > room.min(MAX_TAP_OFFSETS) {
            return Err(format!(
                "{found} tap effects from tap {} on: a model holds {MAX_TAP_OFFSETS}, and tap {} is the last",
                self.first_tap.get(),
                Taps::LAST.get()
            ));
        }
        let effects: Vec<Counts> = self.effects_counts.into_iter().map(Counts).collect();
        let unsound = || "the tap effects must be at least one, finite, and rise from tap to tap".to_owned();
        TapEffects::new(self.first_tap, &effects).ok_or_else(unsound)
    }
}
