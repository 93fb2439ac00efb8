//! The numbers that are reported: each fold predicted by a fit that never saw it.

use std::ops::Range;

use zerorate_core::drift::Drift;

use super::curve::Groups;
use super::fits::{Fits, ends};
use super::{in_recording, predict};
use crate::boot::{booted, move_zero, take_zero_off, variance_by_the_zero};
use crate::choose::standard_error;
use crate::drift_fit::{Candidate, HeldOut, StaticCubic, finite};
use crate::folds::{FOLDS, Fold};
use crate::intervals::{self, Interval};
use crate::model_fit::ModelFit;
use crate::predict::Start;
use crate::residual::ResidualStatistics;
use crate::series::{NextRun, Series};

/// The residuals of the folds, a group each; NaN for one that is not used, or in a fold's first half minute where a zero is
/// taken off.
pub(super) struct Outer {
    /// Within the recording: with the drift in time.
    pub residuals: Vec<f64>,
    /// As deployed, the history known from the recording's start, with the zero as it is.
    pub deployed: Vec<f64>,
    /// The same, and a zero taken off.
    warm: Vec<f64>,
    cold: Vec<f64>,
    cubic: Vec<f64>,
    cubic_deployed: Vec<f64>,
    /// With the cold and the hot end held out, root mean squares; NaN where the rest does not settle it.
    ends: [f64; 2],
    /// Whether the fit that predicts a group has seen its temperature, or warmer and colder ones.
    between: Vec<bool>,
    failed: bool,
}

impl Outer {
    /// What is left of every fold and of each end of temperature by the fits without it.
    pub(super) fn new(series: &Series<'_>, fits: &Fits) -> Self {
        let groups = series.rate.len();
        let nothing = || vec![f64::NAN; groups];
        let mut outer = Self {
            residuals: nothing(),
            deployed: nothing(),
            warm: nothing(),
            cold: nothing(),
            cubic: nothing(),
            cubic_deployed: nothing(),
            ends: [0, 1].map(|end| of_end(series, &ends(series)[end], fits.ends[end].as_ref())),
            between: vec![false; groups],
            failed: false,
        };
        for (fold, made) in series.folds().iter().zip(&fits.folds) {
            outer.failed |= made.is_none() && fold.rows().any(|group| series.is_used(group));
            outer.see(series, fold);
            if let Some(made) = made {
                outer.predict(series, made, fold);
            }
        }
        outer
    }

    /// Marks the groups of a fold that lie between the temperatures of the others.
    fn see(&mut self, series: &Series<'_>, fold: &Fold) {
        let (least, most) = temperatures(series, |group| !fold.has(group));
        for group in fold.rows() {
            self.between[group] = (least..=most).contains(&series.temperature[group]);
        }
    }

    fn predict(&mut self, series: &Series<'_>, made: &ModelFit, fold: &Fold) {
        let known = in_recording(&made.model, series);
        let warm = predict(&made.model, Start::Unknown, series, 0..series.rate.len());
        for out in fold.parts() {
            let used: Vec<usize> = out.clone().filter(|&group| series.is_used(group)).collect();
            let cold = predict(&made.model, Start::Unknown, series, out.clone());
            for &group in &used {
                self.residuals[group] = known[group];
                self.deployed[group] = warm[group];
                self.warm[group] = warm[group];
                self.cold[group] = cold[group - out.start];
                if let Some(cubic) = &made.cubic {
                    self.cubic[group] = series.rate[group] - cubic.evaluate(series.shown[group]).0;
                }
            }
            self.cubic_deployed[out.clone()].copy_from_slice(&self.cubic[out.clone()]);
            for residuals in [&mut self.warm, &mut self.cold, &mut self.cubic_deployed] {
                take_zero_off(residuals, series.time_s, &used);
            }
        }
    }

    /// What is left as deployed, a zero taken off.
    pub(super) fn warm(&self) -> &[f64] {
        &self.warm
    }

    /// The same of the static cubic.
    pub(super) fn cubic_deployed(&self) -> &[f64] {
        &self.cubic_deployed
    }

    pub(super) fn complete(&self) -> bool {
        !self.failed && self.residuals.iter().any(|residual| residual.is_finite())
    }

    /// The rms as deployed, by which models are compared; infinite where a fold could not be predicted.
    pub(super) fn error(&self, series: &Series<'_>) -> f64 {
        self.error_of(&self.warm, series)
    }

    /// The same of the cubic that is exported.
    pub(super) fn cubic_error(&self, series: &Series<'_>) -> f64 {
        self.error_of(&self.cubic_deployed, series)
    }

    /// The end of a ramp is predicted from the rest of it, which is further than the same ramp goes again.
    fn error_of(&self, left: &[f64], series: &Series<'_>) -> f64 {
        let counts = |group: &usize| series.next == NextRun::Another || self.between[*group];
        let rms = ResidualStatistics::of((0..left.len()).filter(counts).map(|group| left[group])).rms;
        if self.complete() && rms.is_finite() { rms } else { f64::INFINITY }
    }

    /// What a deployed device has left of the groups: as the `folds` leave it, but for the zero at the start of each log. Where the
    /// rest of the log tells nothing of the start's temperatures, the rest can but go on in its own way, and all of the log would
    /// be wrong by what the start is. A device was calibrated there: its zero is as the fit of all leaves it, `all`.
    fn left_of_device(&self, series: &Series<'_>, folds: &[f64], all: &[f64]) -> Vec<f64> {
        let mut left = folds.to_vec();
        for log in known_by_log(series, &left) {
            for &group in &log[..booted(series.time_s, &log)] {
                if !self.between[group] {
                    left[group] = all[group];
                }
            }
        }
        left
    }

    /// What a deployed device has left over whole logs like these; `all` is what the fit of all leaves, as deployed.
    pub(super) fn deployed(&self, series: &Series<'_>, all: &[f64]) -> Option<ResidualStatistics> {
        self.of_whole_logs(series, &self.left_of_device(series, &self.deployed, all))
    }

    /// The same of a device that corrects by the static cubic; `all` is what the cubic of all leaves.
    pub(super) fn deployed_by_cubic(&self, series: &Series<'_>, all: &[f64]) -> Option<ResidualStatistics> {
        let is_whole = (0..all.len()).all(|group| self.cubic[group].is_finite() == self.deployed[group].is_finite());
        is_whole.then(|| self.of_whole_logs(series, &self.left_of_device(series, &self.cubic, all))).flatten()
    }

    /// What it has left without a model.
    pub(super) fn uncorrected(&self, series: &Series<'_>) -> Option<ResidualStatistics> {
        self.of_whole_logs(series, series.rate)
    }

    /// What is left of the predicted groups where the zero is taken once, where each log begins, and not anew with each
    /// fold: a device is switched on once a log.
    fn of_whole_logs(&self, series: &Series<'_>, left: &[f64]) -> Option<ResidualStatistics> {
        let predicted = predicted(left, &self.deployed);
        let (left, logs) = zeroed_logs(series, &predicted);
        let by_zeros = logs.iter().map(|log| variance_by_the_zero(&left, series.time_s, log)).sum();
        // Each log has a zero of its own, so that their ends say nothing of each other: the largest of any one.
        let pp = |log: &Vec<usize>| ResidualStatistics::of(log.iter().map(|&group| left[group])).pp;
        let pp = logs.iter().map(pp).fold(f64::NAN, f64::max);
        let left = ResidualStatistics::by_folds(&left, &series.folds())
            .varied_by(by_zeros, left.iter().filter(|left| left.is_finite()).count());
        (self.complete() && left.rms.is_finite()).then_some(ResidualStatistics { pp, ..left })
    }

    pub(super) fn figures(&self) -> HeldOut {
        let rms = |values: &[f64]| {
            Some(ResidualStatistics::of(values.iter().copied()).rms).filter(|rms| rms.is_finite() && self.complete())
        };
        HeldOut {
            folds: FOLDS as u64,
            in_recording: rms(&self.residuals),
            deployed_warm: rms(&self.warm),
            deployed_cold: rms(&self.cold),
            cubic_in_recording: rms(&self.cubic),
            cubic_deployed: rms(&self.cubic_deployed),
        }
    }

    /// How it stands among the others, `best` the one that predicts the recording best.
    pub(super) fn candidate(&self, model: String, in_sample: f64, series: &Series<'_>, best: &Self) -> Candidate {
        let (own, least) = (self.figures(), best.figures().in_recording);
        let excess: Vec<f64> =
            self.squares(series).iter().zip(best.squares(series)).map(|(own, best)| own - best).collect();
        // a - b = (a^2 - b^2) / (a + b)
        let error = standard_error(&excess) / (own.in_recording.zip(least).map_or(f64::NAN, |(a, b)| a + b));
        let directions = directions(series);
        let in_direction = |wanted: usize| {
            let all = self.residuals.iter().zip(&directions);
            ResidualStatistics::of(all.filter(|(_, own)| **own == Some(wanted)).map(|(residual, _)| *residual)).rms
        };
        Candidate {
            model,
            in_sample_rms: in_sample,
            held_out_rms: own.in_recording,
            held_out_excess_standard_error: finite(error).filter(|error| *error > 0.0),
            deployed_rms: own.deployed_warm,
            ends_rms: Some(self.ends).filter(|ends| ends.iter().all(|end| end.is_finite())),
            by_direction_rms: Some([0, 1].map(|direction| finite(in_direction(direction)))),
            chosen: false,
        }
    }

    /// The mean square of each fold within the recording.
    fn squares(&self, series: &Series<'_>) -> Vec<f64> {
        let of = |fold: &Fold| ResidualStatistics::of(fold.rows().map(|group| self.residuals[group])).rms.powi(2);
        series.folds().iter().map(of).filter(|square| square.is_finite()).collect()
    }
}

/// The coldest and the warmest of the groups that are used and `kept`.
pub(super) fn temperatures(series: &Series<'_>, kept: impl Fn(usize) -> bool) -> Interval {
    let used = (0..series.rate.len()).filter(|&group| kept(group) && series.is_used(group));
    intervals::ends(used.map(|group| series.temperature[group]))
}

/// What a fit without an end of temperature leaves of it, root mean square; NaN without one.
fn of_end(series: &Series<'_>, end: &[usize], made: Option<&ModelFit>) -> f64 {
    made.map_or(f64::NAN, |made| {
        let left = in_recording(&made.model, series);
        ResidualStatistics::of(end.iter().map(|&group| left[group])).rms
    })
}

/// The mean of what is left of the groups that were predicted.
pub(super) fn level(left: &[f64]) -> f64 {
    let known: Vec<f64> = left.iter().copied().filter(|left| left.is_finite()).collect();
    ResidualStatistics::about_mean(&known).1
}

/// What is left of the groups that were predicted; NaN of the others, which are none of a device's.
pub(super) fn predicted(left: &[f64], deployed: &[f64]) -> Vec<f64> {
    left.iter().zip(deployed).map(|(left, own)| if own.is_finite() { *left } else { f64::NAN }).collect()
}

/// What is left once a zero was taken where each log begins; NaN while it is taken.
pub(super) fn zeroed(series: &Series<'_>, left: &[f64]) -> Vec<f64> {
    zeroed_logs(series, left).0
}

/// The same, and the groups of each log of which something was left.
fn zeroed_logs(series: &Series<'_>, left: &[f64]) -> (Vec<f64>, Vec<Vec<usize>>) {
    let logs = known_by_log(series, left);
    let mut zeroed = left.to_vec();
    logs.iter().for_each(|log| take_zero_off(&mut zeroed, series.time_s, log));
    (zeroed, logs)
}

/// The same with two zeros that its noise might have made as well, a standard deviation to either side: the next run's start
/// has noise of its own.
pub(super) fn zeroed_either_way(series: &Series<'_>, left: &[f64]) -> [Vec<f64>; 2] {
    let (zeroed, logs) = zeroed_logs(series, left);
    [1.0, -1.0].map(|side| {
        let mut other = zeroed.clone();
        logs.iter().for_each(|log| move_zero(&mut other, series.time_s, log, side));
        other
    })
}

/// The groups of which something is left, log by log.
fn known_by_log(series: &Series<'_>, left: &[f64]) -> Vec<Vec<usize>> {
    let known: Vec<usize> = (0..left.len()).filter(|&group| left[group].is_finite()).collect();
    let of_one_log = |&a: &usize, &b: &usize| series.log[a] == series.log[b];
    known.chunk_by(of_one_log).map(<[usize]>::to_vec).collect()
}

/// The static cubic of everything, with what it leaves of the rates less the recording's own drift in time.
pub(super) fn static_cubic(groups: &Groups<'_>, fits: &Fits, outer: &Outer) -> Option<StaticCubic> {
    let Groups { series, measured, valid } = *groups;
    let drift = fits.whole.cubic.clone()?;
    let timeless = super::timeless(&fits.whole.model, series);
    let residual = |cubic: &Drift, group: usize| timeless[group] - cubic.evaluate(series.temperature[group]).0;
    let used = (0..series.rate.len()).filter(|&group| series.is_used(group));
    let in_sample = ResidualStatistics::of(used.map(|group| residual(&drift, group)));
    let mut held_out = Vec::new();
    for (fold, made) in series.folds().iter().zip(&fits.folds) {
        let out = fold.rows().filter(|&group| series.is_used(group));
        match made.as_ref().and_then(|made| made.cubic.as_ref()) {
            Some(cubic) => held_out.extend(out.map(|group| residual(cubic, group))),
            None => held_out.extend(out.map(|_| f64::INFINITY)),
        }
    }
    let whole = held_out.iter().all(|residual| residual.is_finite()) && !held_out.is_empty();
    let held_out = whole.then(|| ResidualStatistics::of(held_out));
    let of_all = |group: usize| match series.is_used(group) {
        true => series.rate[group] - drift.evaluate(series.shown[group]).0,
        false => f64::NAN,
    };
    let deployed = outer.deployed_by_cubic(series, &(0..series.rate.len()).map(of_all).collect::<Vec<_>>());
    // Autopilots hold a curve at the ends of what it is for.
    let drift = Drift { valid: series.seen(measured, valid), ..drift };
    Some(StaticCubic { drift, in_sample, held_out, deployed })
}

/// Which way the temperature goes at each group: 0 heating, 1 cooling, by the change over a few groups of its log on either
/// side.
fn directions(series: &Series<'_>) -> Vec<Option<usize>> {
    /// Groups to either side.
    const REACH: usize = 3;
    /// A change smaller than this share of the span over them is a soak.
    const STILL: f64 = 0.002;
    let (coldest, hottest) = intervals::ends(series.temperature.iter().copied().filter(|t| t.is_finite()));
    let span = hottest - coldest;
    let of_group = |log: &Range<usize>, group: usize| {
        let before = series.temperature[group.saturating_sub(REACH).max(log.start)];
        let after = series.temperature[(group + REACH).min(log.end - 1)];
        let change = after - before;
        (change.abs() > STILL * span).then(|| usize::from(change < 0.0))
    };
    series.logs().into_iter().flat_map(|log| log.clone().map(move |group| of_group(&log, group))).collect()
}
