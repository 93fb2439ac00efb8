//! One axis of a calibration.

use serde::{Deserialize, Serialize};
use zerorate_core::compensate::{LowPass, Mode};
use zerorate_core::drift::{Drift, History};
use zerorate_core::trim::Trim;

use super::form::{AxisForm, TrimForm};
use super::model::{BandPoint, HeldOut, StaticCubic, TimeDrift};
use crate::choose::{Candidate, Choice, Model, STRETCHES};
use crate::log::Sensor;
use crate::log_fit::{AxisFit, Spread};
use crate::table::RateUnit;
use crate::trim_fit::TrimEstimate;

/// One axis: its drift, how well it was fitted, and its trim where it has one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "AxisForm", into = "AxisForm")]
pub struct AxisCalibration {
    /// Zero-rate output over temperature, in `rate_unit` and the calibration's temperature unit. With a history this is
    /// the static curve for when the history is not known.
    pub drift: Drift,
    /// What the drift remembers of its temperatures; `None` where it is a function of temperature alone.
    pub history: Option<History>,
    /// The recording's own drift in time; `None` where the model chosen has none.
    pub time_drift: Option<TimeDrift>,
    /// The best static cubic beside the model chosen; `None` where it was not fitted.
    pub static_cubic: Option<StaticCubic>,
    /// The prediction band over temperature, coldest first; empty where it was not found.
    pub band: Vec<BandPoint>,
    /// The unit of the drift and of every residual: counts on the analogue board.
    pub rate_unit: RateUnit,
    /// The sensor, where the log tells of sensors.
    pub sensor: Option<Sensor>,
    /// Where the drift is 0 by definition, in the calibration's temperature unit: an accelerometer at rest shows its
    /// constant and gravity together. `None` where the constant is part of the drift.
    pub reference_temperature: Option<f64>,
    /// How well the drift was fitted; `None` where it was not fitted here.
    pub fit: Option<FitStatistics>,
    /// The trim part's model; `None` without one.
    pub trim: Option<TrimCalibration>,
    /// What to look at, a sentence each.
    pub warnings: Vec<String>,
}

/// What the residuals of a fit are residuals of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ResidualOver {
    /// Single rows of a log.
    Rows,
    /// Means of groups.
    Groups,
}

/// How well a drift was fitted. All numbers are in the axis's rate unit, or its square.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FitStatistics {
    /// What the residuals are of.
    pub residual_over: ResidualOver,
    /// How many of them there are.
    pub residuals: u64,
    /// Samples that were fitted, each counted once, in groups or not.
    pub samples_used: u64,
    /// Residual of the fit of everything.
    pub in_sample: Spread,
    /// Residual of contiguous stretches, each predicted by the fit of the others; `None` where the others do not settle
    /// the model.
    pub held_out: Option<Spread>,
    /// How many stretches.
    pub held_out_stretches: u64,
    /// Covariance of the scaled coefficients (of a table: of its knots), a row a coefficient, rate units squared.
    pub covariance: Vec<Vec<f64>>,
    /// The models tried, simplest first.
    pub candidates: Vec<CandidateStatistics>,
    /// Where the choice was nested: how the whole procedure predicts what it has not seen. `held_out` is then the
    /// residual within the recording by the same stretches.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nested: Option<HeldOut>,
}

/// A model that was tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CandidateStatistics {
    /// The model, as `poly:2`, or `poly:3 + plays + lags + time`.
    pub model: String,
    /// Root mean square of the residual of the fit of everything.
    pub in_sample_rms: f64,
    /// Root mean square over the held-out stretches; `None` where one could not be predicted.
    pub held_out_rms: Option<f64>,
    /// Standard error of how much `held_out_rms` exceeds the best candidate's, stretch by stretch; 0 for the best.
    pub held_out_excess_standard_error: Option<f64>,
    /// As deployed: over the held-out stretches without drift in time, less the mean of each one's first groups.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deployed_rms: Option<f64>,
    /// With the coldest and with the hottest eighth of the groups held out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ends_rms: Option<[f64; 2]>,
    /// The held-out groups taken while it was heating, and while it was cooling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_direction_rms: Option<[Option<f64>; 2]>,
    /// How strongly its weights were drawn to zero: a share of the data's own weight.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ridge: Option<f64>,
    /// Whether it is the one chosen.
    #[serde(default)]
    pub chosen: bool,
}

/// The trim of one axis, and what the law makes of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "TrimForm", into = "TrimForm")]
pub struct TrimCalibration {
    /// The model that the law uses.
    pub trim: Trim,
    /// The line by each point's own trimmed reading.
    pub better: Option<TrimEstimate>,
    /// The line by the paper's formula.
    pub paper: Option<TrimEstimate>,
    /// Dead band, taps.
    pub dead_band_taps: f64,
    /// The circuit's low-pass at the board's sampling.
    pub low_pass: LowPass,
    /// What the axis is to do when the board starts.
    pub start_up_mode: Mode,
}

impl AxisCalibration {
    /// The axis of a log or of a recording, without a trim; `over` says what the fit was of.
    #[must_use]
    pub fn of_fit(axis: &AxisFit, over: ResidualOver) -> Self {
        Self {
            drift: axis.drift.clone(),
            history: axis.history.clone(),
            time_drift: axis.time_drift,
            static_cubic: axis.static_cubic.clone(),
            band: axis.band.clone(),
            rate_unit: axis.rate_unit,
            sensor: axis.sensor,
            reference_temperature: axis.reference_temperature,
            fit: Some(FitStatistics {
                nested: axis.nested,
                ..FitStatistics::new(&axis.choice, over, axis.samples_used, axis.in_sample, axis.held_out)
            }),
            trim: None,
            warnings: Vec::new(),
        }
    }

    /// The model: the drift's shape and size.
    #[must_use]
    pub fn model(&self) -> Model {
        Model::of_shape(&self.drift.shape)
    }

    /// The model that was chosen, terms beside the curve included: `poly:3`, or `poly:3 + 3 plays + time`.
    #[must_use]
    pub fn chosen_model(&self) -> String {
        let candidates = self.fit.iter().flat_map(|fit| &fit.candidates);
        let chosen = candidates.into_iter().find(|candidate| candidate.chosen);
        chosen.map_or_else(|| self.model().to_string(), |candidate| candidate.model.clone())
    }
}

impl CandidateStatistics {
    /// Candidates as they stand in files.
    #[must_use]
    pub fn of(candidates: &[Candidate]) -> Vec<Self> {
        candidates.iter().map(Self::of_one).collect()
    }

    fn of_one(candidate: &Candidate) -> Self {
        let further = candidate.further;
        Self {
            model: candidate.to_string(),
            in_sample_rms: candidate.in_sample_rms,
            held_out_rms: finite(candidate.held_out_rms),
            held_out_excess_standard_error: finite(candidate.standard_error),
            deployed_rms: further.and_then(|further| finite(further.deployed_rms)),
            ends_rms: further.map(|f| f.ends_rms).filter(|ends| ends.iter().all(|end| end.is_finite())),
            by_direction_rms: further.map(|further| further.by_direction_rms.map(finite)),
            ridge: further.map(|further| further.ridge),
            chosen: candidate.chosen,
        }
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

impl FitStatistics {
    fn new(choice: &Choice, over: ResidualOver, samples_used: u64, in_sample: Spread, held_out: Spread) -> Self {
        Self {
            residual_over: over,
            residuals: choice.solution.rows,
            samples_used,
            in_sample,
            held_out: held_out.rms.is_finite().then_some(held_out),
            held_out_stretches: STRETCHES as u64,
            covariance: choice.solution.covariance.clone(),
            candidates: CandidateStatistics::of(&choice.candidates),
            nested: None,
        }
    }
}
