//! What a fit of a drift gives: the model, and how well it holds.

use serde::{Deserialize, Serialize};
use zerorate_core::drift::{Drift, History, Memory, Term, ValidRange};

use crate::folds::FOLDS;
use crate::predict::DriftModel;
use crate::residual::ResidualStatistics;
use crate::trend::Trend;

/// A drift that was fitted. Rates and temperatures are in the units of what it was fitted to.
#[derive(Debug, Clone, PartialEq)]
pub struct DriftFit {
    /// The model. Its valid range is how far the curve is believed, which may be beyond what was measured.
    pub model: DriftModel,
    /// The least and the greatest temperature that it was fitted to.
    pub measured: ValidRange,
    /// The best static cubic beside it; `None` where it was not fitted.
    pub static_cubic: Option<StaticCubic>,
    /// Over temperature, coldest first: 95 of 100 group means of this recording are within it of what the model predicts
    /// without its drift in time. Empty where it was not found.
    pub band: Vec<BandPoint>,
    /// The same of the next run, after a zero at its start: wider, for that run was not fitted.
    pub next_run_band: Vec<BandPoint>,
    /// How well it holds.
    pub statistics: FitStatistics,
}

/// A point of a band.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BandPoint {
    /// In the calibration's temperature unit.
    pub temperature: f64,
    /// Rate units, to either side of what the model predicts.
    pub half_width: f64,
}

impl BandPoint {
    /// The half-width at a temperature: on the straight line between two points of a band, and beyond them its end's. NaN of
    /// a band of fewer than two points.
    #[must_use]
    pub fn half_width_at(band: &[Self], temperature: f64) -> f64 {
        let mut pairs = band.windows(2);
        let Some([from, to]) = pairs.find(|pair| temperature <= pair[1].temperature).or(band.windows(2).last()) else {
            return f64::NAN;
        };
        let share = ((temperature - from.temperature) / (to.temperature - from.temperature)).clamp(0.0, 1.0);
        from.half_width + share * (to.half_width - from.half_width)
    }
}

/// The best static cubic: what an autopilot that knows no more than a cubic can hold. Of the same conditioned data and by
/// the same robust loss as the model chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticCubic {
    /// A polynomial of order 3 (of a lower order where the data do not settle three), and its valid range.
    pub drift: Drift,
    /// Residual of the fit of everything.
    pub in_sample: ResidualStatistics,
    /// Residual of the folds, each predicted by the fit of the others; `None` where they do not settle it.
    pub held_out: Option<ResidualStatistics>,
    /// What a device has left over a whole log that it corrects by this cubic, as [`FitStatistics::deployed`] has it of the model
    /// chosen; `None` where there are no such folds.
    pub deployed: Option<ResidualStatistics>,
}

/// How well the whole procedure predicts data that played no part in choosing or fitting: folds, for each of which the
/// choice was made anew from the others. Root mean squares over groups, rate units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// How many folds.
    #[serde(alias = "stretches")]
    pub folds: u64,
    /// Within the recording: with its drift in time.
    pub in_recording: Option<f64>,
    /// As deployed, the history known from the recording's start: no drift in time; the mean of the fold's first groups
    /// (about 30 s) is taken off, as a zero at boot does.
    pub deployed_warm: Option<f64>,
    /// The same, the history starting from nothing at the fold's first group.
    pub deployed_cold: Option<f64>,
    /// The static cubic within the recording.
    pub cubic_in_recording: Option<f64>,
    /// The static cubic as deployed; it has no history, so warm and cold are one.
    pub cubic_deployed: Option<f64>,
}

/// What residuals are residuals of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ResidualOver {
    /// Single rows of a log.
    Rows,
    /// Means of groups.
    Groups,
}

/// How well a drift was fitted. All numbers are in the rate unit, or its square.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FitStatistics {
    /// What the residuals are of.
    pub residual_over: ResidualOver,
    /// How many of them there are.
    pub residuals: u64,
    /// Samples that were fitted, each counted once, in groups or not.
    pub samples_used: u64,
    /// Residual of the fit of everything.
    pub in_sample: ResidualStatistics,
    /// Residual of the folds, each predicted by the fit of the others; `None` where the others do not settle the model.
    pub held_out: Option<ResidualStatistics>,
    /// How many folds.
    #[serde(alias = "held_out_stretches")]
    pub held_out_folds: u64,
    /// Covariance of the scaled coefficients (of a table: of its knots), a row a coefficient, rate units squared.
    pub covariance: Vec<Vec<f64>>,
    /// The models tried, simplest first.
    pub candidates: Vec<Candidate>,
    /// Where the choice was nested: how the whole procedure predicts what it has not seen. `held_out` is then the
    /// residual within the recording by the same folds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nested: Option<HeldOut>,
    /// What a deployed device has left over a whole log like those fitted: the folds of `nested`, less no drift in time, the
    /// history known from the log's start on and no sooner, less the mean of the log's first half minute
    /// ([`crate::boot`]). The zero is taken once, so that this is what a verification of another run finds; the figures in
    /// `nested` take it anew with each fold. `None` where there are no such folds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deployed: Option<ResidualStatistics>,
    /// The same without any model: what a device has left that takes its zero and corrects nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncorrected: Option<ResidualStatistics>,
    /// Of several logs, what is left of each; nothing of one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub by_log: Vec<LogLeft>,
    /// Trends in what the model leaves of the recording, its drift in time not taken off; none in most.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub trends: Vec<Trend>,
}

impl FitStatistics {
    /// Of a drift of which nobody says how well it was fitted.
    #[must_use]
    pub fn unknown() -> Self {
        Self::new(ResidualOver::Groups, 0, ResidualStatistics::NONE, ResidualStatistics::NONE, Vec::new())
    }

    /// Which of the candidates was taken, for people; `None` where there was no choice.
    #[must_use]
    pub fn how_it_was_chosen(&self) -> Option<&'static str> {
        let how = if self.residual_over == ResidualOver::Rows { HOW_PLAIN_CHOOSES } else { HOW_AUTO_CHOOSES };
        (self.candidates.len() > 1).then_some(how)
    }

    /// Of a fit to `residuals` rows or groups, whatever was tried beside it.
    #[must_use]
    pub fn new(
        residual_over: ResidualOver,
        residuals: u64,
        in_sample: ResidualStatistics,
        held_out: ResidualStatistics,
        covariance: Vec<Vec<f64>>,
    ) -> Self {
        Self {
            residual_over,
            residuals,
            samples_used: residuals,
            in_sample,
            held_out: held_out.rms.is_finite().then_some(held_out),
            held_out_folds: FOLDS as u64,
            covariance,
            candidates: Vec::new(),
            nested: None,
            deployed: None,
            uncorrected: None,
            by_log: Vec::new(),
            trends: Vec::new(),
        }
    }
}

/// What is left of one of several logs, as a device has it that takes its zero in the log's first half minute: root mean
/// squares over groups, rate units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LogLeft {
    /// Without a model.
    pub uncorrected: f64,
    /// By a fit of the other logs, which has not seen this one: of two logs, what the one alone leaves of the other. `None`
    /// where the others do not settle a model.
    pub by_the_others: Option<f64>,
    /// By the fit of all, this one among them.
    pub by_all: f64,
    /// How far its rates lie above the fit of all, on average, less the same of the mean of the logs: what differs from one
    /// time it is switched on to another, beside the model's own errors. `None` in a calibration that was made before it was
    /// told.
    #[serde(default)]
    pub offset: Option<f64>,
}

/// Which of the candidates `auto` takes, for people: the last, or a cubic.
pub const HOW_AUTO_CHOOSES: &str = "the last one, whose curve and memories are as strong as the data say, if it leaves, zeroed, \
    at most 5 % more than poly:3 and than the cubic that autopilots get of it. Else a cubic is taken: poly:3 + time \
    where a drift in time was found, or poly:3. No other figure decides. On a board's ramp only temperatures \
    between those of the other folds count";

/// Which of the candidates is taken where every row counts once, for people.
const HOW_PLAIN_CHOOSES: &str = "the simplest one whose held-out rms is within one standard error of the best one's";

/// Why a model without a history is judged too strictly by its folds, for people ([`DriftFit::misses_its_own_branch`]).
pub const A_FOLD_MISSES_ITS_BRANCH: &str = "A model without a history goes between the two ways of a log that went both ways; \
    of an eighth that is left out its own way is missing from the other seven. Where the ways differ, the same run again leaves \
    less than is told here, but no less than in-sample";

/// Of what temperatures the figures of a model with a history are, for people.
pub const A_HISTORY_GOES_BY_AVERAGES: &str = "A model with a history is told of averages of the temperature, as a board takes it. \
    Taken row by row, as by zerorate apply, a noisy or coarse temperature drives the history too, and more is left: zerorate verify \
    of another run tells how much";

/// A model that was tried, and its errors, rate units.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// The model, as `poly:2`, or `poly:3 + 3 plays + time`.
    pub model: String,
    /// Root mean square of the residual of the fit of everything.
    pub in_sample_rms: f64,
    /// Root mean square over all folds, each predicted by the fit of the others; `None` where one could not be fitted.
    pub held_out_rms: Option<f64>,
    /// Standard error of how much `held_out_rms` exceeds the best candidate's, from their differences fold by fold: what
    /// makes a fold hard for all, as hysteresis does, says nothing about which is better. `None` for the best.
    pub held_out_excess_standard_error: Option<f64>,
    /// As deployed: over the folds without drift in time, less the mean of each one's first groups.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deployed_rms: Option<f64>,
    /// With the coldest groups held out, and with the hottest, as many as a fold.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ends_rms: Option<[f64; 2]>,
    /// The held-out groups taken while it was heating, and while it was cooling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_direction_rms: Option<[Option<f64>; 2]>,
    /// Whether it is the one chosen.
    #[serde(default)]
    pub chosen: bool,
}

impl DriftFit {
    /// The drift as a curve without a history, over what was measured and no further: what is told of a drift (peak to peak,
    /// slopes) is told of this. Beside plays the model's own curve has only what those leave it, which no unit shows: then it is
    /// the static cubic, which goes between both ways. Where lags have caught up the unit shows the curve.
    #[must_use]
    pub fn measured_drift(&self) -> Drift {
        let curve = self.cubic_between_ways().map_or(&self.model.drift, |cubic| &cubic.drift);
        Drift { valid: self.measured, ..curve.clone() }
    }

    /// The static cubic of a model with plays, which stands for it where a curve is wanted; `None` of any other model.
    #[must_use]
    pub fn cubic_between_ways(&self) -> Option<&StaticCubic> {
        let is_play = |term: &Term| matches!(term.memory, Memory::Play { .. });
        let has_plays = self.model.history.iter().flat_map(History::terms).any(is_play);
        self.static_cubic.as_ref().filter(|_| has_plays)
    }

    /// Whether its held-out figures ask more of it than another run like this one: a curve without a history, of a log that
    /// went both ways. A fold is one way, and its temperatures are known by the other way alone.
    #[must_use]
    pub fn misses_its_own_branch(&self) -> bool {
        // Of several logs in-sample has their levels in it, and is no bound.
        if !self.statistics.by_log.is_empty() {
            return false;
        }
        let chosen = self.statistics.candidates.iter().find(|candidate| candidate.chosen);
        let ways = chosen.and_then(|candidate| candidate.by_direction_rms);
        self.model.history.is_none() && ways.is_some_and(|ways| ways.iter().all(Option::is_some))
    }

    /// The model that was chosen, terms beside the curve included: `poly:3`, or `poly:3 + 3 plays + time`.
    #[must_use]
    pub fn chosen_model(&self) -> String {
        self.model.to_string()
    }
}

/// A number, where it is one.
pub(crate) fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
