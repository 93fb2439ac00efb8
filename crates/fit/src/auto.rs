//! `--model auto` on groups: one model whose strength the data settle, held against plain curves on data that were not
//! fitted.
//!
//! A fit is a function of groups (time, temperature, rate, weight) and of nothing else. The model is by evidence
//! (`evidence`); a line, a quadratic and a cubic stand beside it (`curve`), and where a drift in time was found a cubic with
//! one. What is deployed is a mean of the model and the cubic (`mean`). The numbers that are reported come from folds (`fits`,
//! `nested`): for each of eight the model is fitted anew to the other seven. A model that does worse there than the cubic is
//! dropped for it.

mod band;
mod by_log;
mod curve;
mod fits;
mod levels;
mod mean;
mod nested;

use std::ops::Range;

use zerorate_core::drift::ValidRange;

use crate::drift_fit::{Candidate, DriftFit, FitStatistics, ResidualOver};
use crate::evidence::{Evidence, Likeliest};
use crate::folds::TELLING;
use crate::least_squares::FitError;
use crate::model::Model;
use crate::model_fit::{CUBIC, ModelFit};
use crate::predict::{DriftModel, Predictor, Start};
use crate::residual::ResidualStatistics;
use crate::series::{NextRun, Series};
use crate::trend::trends;
use curve::{Curve, Groups};
use fits::Fits;
use nested::Outer;

/// How far past the measured temperatures a curve chosen by `auto` is believed before it is held, as a fraction of the span
/// at each end. It was tested that far: with the groups at either end held out, as many as a fold. The next flight may
/// start a little colder.
pub const BEYOND: f64 = 1.0 / 8.0;

/// What came of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupFit {
    /// The model and how well it holds.
    pub fit: DriftFit,
    /// Rate less prediction with the drift in time, a group each; NaN for one that was not used.
    pub residuals: Vec<f64>,
}

/// Fits a series: `auto`, or the model asked for alone, without history and drift in time.
///
/// `measured` is the least and greatest temperature of the groups that have a rate. `auto` believes its curve
/// further than that, by a fraction of the span at each end, where it was tested; another model is held at the ends.
///
/// # Errors
/// [`FitError`], when the groups do not settle the model, or no model.
pub fn fit(series: &Series<'_>, measured: ValidRange, asked: Model) -> Result<GroupFit, FitError> {
    let mut made = fit_of_all(series, measured, asked)?;
    made.fit.statistics.by_log = by_log::by_log(series, &made.fit, asked);
    Ok(made)
}

/// The same, without what is left of each of several logs.
fn fit_of_all(series: &Series<'_>, measured: ValidRange, asked: Model) -> Result<GroupFit, FitError> {
    let used = (0..series.rate.len()).filter(|&group| series.is_used(group)).count();
    let coefficients = asked.least_coefficients();
    if used < coefficients {
        return Err(FitError::TooFewRows { rows: used as u64, coefficients });
    }
    let further = asked == Model::Auto && series.next == NextRun::Another;
    let beyond = if further { BEYOND * (measured.max() - measured.min()) } else { 0.0 };
    let valid = ValidRange::new(measured.min() - beyond, measured.max() + beyond).ok_or(FitError::NotFinite)?;
    let groups = Groups { series, measured, valid };
    let plain = |model: Model, in_time: bool| {
        let curve = Curve { model, in_time };
        Attempt::new(series, |keep| curve.fit(groups, keep))
    };
    let undetermined = FitError::Undetermined { coefficients };
    if asked != Model::Auto {
        return Ok(finish(&[plain(asked, false).ok_or(undetermined)?], 0, &groups));
    }
    // A curve that is drawn to nothing is settled by one temperature; a line is not.
    let mut tried = vec![plain(Model::Poly(1), false).ok_or(undetermined)?];
    tried.extend((2..=CUBIC).filter_map(|order| plain(Model::Poly(order), false)));
    let attempt = |(evidence, found): Likeliest<'_>| Attempt::new(series, |keep| evidence.fit(&found, keep));
    let own = Evidence::likeliest(series, measured, valid).and_then(|(together, with_parts_behind)| {
        let (together, behind) = (attempt(together), with_parts_behind.and_then(attempt));
        let is_worse =
            |behind: &Attempt, together: &Attempt| behind.outer.error(series) > TELLING * together.outer.error(series);
        match (behind, together) {
            (Some(behind), Some(together)) if is_worse(&behind, &together) => Some(together),
            (behind, together) => behind.or(together),
        }
    });
    let Some(own) = own else { return Ok(finish(&tried, tried.len() - 1, &groups)) };
    let cubic = tried.len() - 1;
    // The bench's next run is this one again: there is nothing to be careful about, and its cubic goes to no autopilot.
    let own = if series.next == NextRun::Another { own.mean_with(&tried[cubic], &groups) } else { own };
    let exported = own.outer.cubic_error(series);
    let is_worse = own.outer.error(series) > TELLING * exported.min(tried[cubic].outer.error(series));
    // A drift in time is no part of what is deployed, but a curve fitted as if there were none is bent by it.
    let told = own.fits.whole.model.time_drift.is_some() && series.tells_slope();
    tried.extend(plain(Model::Poly(CUBIC), true).filter(|_| told));
    let plainest = tried.len() - 1;
    tried.push(own);
    Ok(finish(&tried, if is_worse { plainest } else { tried.len() - 1 }, &groups))
}

/// What is told of the one that was chosen of some.
fn finish(tried: &[Attempt], chosen: usize, groups: &Groups<'_>) -> GroupFit {
    let in_recording = |attempt: &&Attempt| attempt.outer.figures().in_recording.unwrap_or(f64::INFINITY);
    let best = tried.iter().min_by(|a, b| in_recording(a).total_cmp(&in_recording(b))).unwrap_or(&tried[chosen]);
    let candidate = |(place, attempt): (usize, &Attempt)| Candidate {
        chosen: place == chosen,
        ..attempt.candidate(groups.series, best)
    };
    let candidates = tried.iter().enumerate().map(candidate).collect();
    tried[chosen].finish(groups, candidates)
}

/// A model fitted to everything, and how well its way of fitting predicts what it has not seen.
struct Attempt {
    fits: Fits,
    outer: Outer,
}

impl Attempt {
    /// By `make`, which fits the groups that are kept.
    fn new(series: &Series<'_>, make: impl Fn(&dyn Fn(usize) -> bool) -> Option<ModelFit>) -> Option<Self> {
        Some(Self::of(series, Fits::of(series, make)?))
    }

    fn of(series: &Series<'_>, fits: Fits) -> Self {
        Self { outer: Outer::new(series, &fits), fits }
    }

    /// The mean with a plain cubic, and of its static cubic with it, each by what least is left of the folds. A model that
    /// tells a straight drift in time stays: what the cubic left of the folds has that drift in it, and says little of the two.
    fn mean_with(self, plain: &Self, groups: &Groups<'_>) -> Self {
        let Groups { series, measured, valid } = *groups;
        let of_model = mean::share(self.outer.warm(), plain.outer.warm());
        let is_straight = self.fits.whole.model.time_drift.as_ref().is_some_and(|drift| drift.per_second != 0.0);
        let shares = mean::Shares {
            model: if is_straight { 1.0 } else { of_model },
            cubic: mean::share_of_cubic(self.outer.cubic_deployed(), plain.outer.cubic_deployed(), &series.folds()),
        };
        let seen = series.seen(measured, valid);
        let joined = self.fits.with(&plain.fits, |own, plain| mean::of_two(own, plain, shares, seen));
        joined.map_or(self, |fits| Self::of(series, fits))
    }

    fn candidate(&self, series: &Series<'_>, best: &Self) -> Candidate {
        let in_sample = ResidualStatistics::of(in_recording(&self.fits.whole.model, series)).rms;
        self.outer.candidate(self.fits.whole.model.to_string(), in_sample, series, &best.outer)
    }

    fn finish(&self, groups: &Groups<'_>, candidates: Vec<Candidate>) -> GroupFit {
        let (Groups { series, measured, .. }, Self { fits, outer }) = (*groups, self);
        let made = &fits.whole;
        let residuals = in_recording(&made.model, series);
        let in_sample = ResidualStatistics::of(residuals.iter().copied());
        let deployed = predict(&made.model, Start::Unknown, series, 0..series.rate.len());
        let held_out = match outer.complete() {
            true => ResidualStatistics::by_folds(&outer.residuals, &series.folds()),
            false => ResidualStatistics::NONE,
        };
        let band = band::band(series, measured, &[&deployed]);
        let [a, b] = nested::zeroed_either_way(series, &deployed);
        // What is held out says as much of the next run as what was fitted (Toussaint and Sharpe, *An efficient method for
        // estimating the probability of misclassification*, 1975): a fit that lacks a whole fold is worse than the one that
        // is deployed, and a residual of what was fitted is smaller than one to come. So is its zero: the next run may begin
        // where this one tells little.
        let next_run_band = if outer.complete() {
            let [c, d] = nested::zeroed_either_way(series, &outer.deployed);
            band::band(series, measured, &[&a, &b, &c, &d])
        } else {
            band::band(series, measured, &[&a, &b])
        };
        let used = (0..series.rate.len()).filter(|&group| series.is_used(group)).count() as u64;
        let statistics = FitStatistics {
            candidates,
            nested: Some(outer.figures()),
            deployed: outer.deployed(series, &deployed),
            uncorrected: outer.uncorrected(series),
            trends: trends(&deployed, series),
            ..FitStatistics::new(ResidualOver::Groups, used, in_sample, held_out, made.covariance.clone())
        };
        let static_cubic = nested::static_cubic(groups, fits, outer);
        GroupFit {
            fit: DriftFit { model: made.model.clone(), measured, static_cubic, band, next_run_band, statistics },
            residuals,
        }
    }
}

/// What a model leaves of the groups of the recording that it was fitted to; NaN for a group that was not used.
fn in_recording(model: &DriftModel, series: &Series<'_>) -> Vec<f64> {
    predict(model, Start::OwnRecording, series, 0..series.rate.len())
}

/// Rate less prediction of some successive groups, the history starting at the first of them and anew with each log; NaN
/// for a group that was not used. A device has the temperatures that its sensor shows.
fn predict(model: &DriftModel, start: Start, series: &Series<'_>, groups: Range<usize>) -> Vec<f64> {
    let mut predictor = Predictor::new(model, start);
    let temperature = match start {
        Start::Unknown => series.shown,
        Start::OwnRecording => series.temperature,
    };
    groups
        .map(|group| {
            if series.begins(group) {
                predictor = Predictor::new(model, start);
            }
            let bias = predictor.predict(series.time_s[group], temperature[group]).bias;
            if series.is_used(group) { series.rate[group] - bias } else { f64::NAN }
        })
        .collect()
}

/// The rates less the recording's own drift in time.
fn timeless(model: &DriftModel, series: &Series<'_>) -> Vec<f64> {
    let mut began = f64::NAN;
    (0..series.rate.len())
        .map(|group| {
            if series.begins(group) {
                began = series.time_s[group];
            }
            let time_s = series.time_s[group];
            series.rate[group] - model.time_drift.as_ref().map_or(0.0, |drift| drift.at(time_s, time_s - began))
        })
        .collect()
}

#[cfg(test)]
mod tests;
