//! The number that is reported: each fold predicted by a choice and a fit that never saw it.

use std::ops::Range;

use zerorate_core::drift::Drift;

use super::candidates::Among;
use super::thinned::Thinned;
use super::{Made, Prepared, in_recording, predict};
use crate::boot::take_zero_off;
use crate::drift_fit::{HeldOut, StaticCubic};
use crate::folds::{FOLDS, TELLING, rows_of_fold};
use crate::predict::Start;
use crate::residual::ResidualStatistics;
use crate::series::Series;

/// The residuals of the outer folds, a group each; NaN for one that is not used, or in a fold's first half minute
/// where a zero is taken off.
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
    /// The static cubics of the folds.
    cubics: Vec<Option<Drift>>,
    failed: bool,
}

impl Outer {
    pub(super) fn complete(&self) -> bool {
        !self.failed && self.residuals.iter().any(|residual| residual.is_finite())
    }

    /// Whether what was chosen predicts new data worse than the static cubic, as deployed.
    pub(super) fn is_worse_than_the_cubic(&self) -> bool {
        let figures = self.figures();
        figures.deployed_warm.zip(figures.cubic_deployed).is_some_and(|(chosen, cubic)| chosen > TELLING * cubic)
    }

    /// What a deployed device has left over whole logs like these.
    pub(super) fn deployed(&self, series: &Series<'_>) -> Option<ResidualStatistics> {
        self.of_whole_logs(series, &self.deployed)
    }

    /// What it has left without a model.
    pub(super) fn uncorrected(&self, series: &Series<'_>) -> Option<ResidualStatistics> {
        self.of_whole_logs(series, series.rate)
    }

    /// What is left of the predicted groups where the zero is taken once, where each log begins, and not anew with each
    /// fold: a device is switched on once a log.
    fn of_whole_logs(&self, series: &Series<'_>, left: &[f64]) -> Option<ResidualStatistics> {
        let predicted: Vec<usize> = (0..left.len()).filter(|&group| self.deployed[group].is_finite()).collect();
        let mut zeroed = left.to_vec();
        for log in predicted.chunk_by(|&a, &b| series.log[a] == series.log[b]) {
            take_zero_off(&mut zeroed, series.time_s, log);
        }
        // A group that was not predicted is none of a device's.
        zeroed
            .iter_mut()
            .zip(&self.deployed)
            .filter(|(_, own)| !own.is_finite())
            .for_each(|(left, _)| *left = f64::NAN);
        let left = ResidualStatistics::by_folds(&zeroed);
        (self.complete() && left.rms.is_finite()).then_some(left)
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
}

/// Predicts every fold.
pub(super) fn outer(whole: &Prepared<'_>, coarse: &Prepared<'_>, thinned: &Thinned, among: Among) -> Outer {
    let series = whole.series;
    let groups = series.rate.len();
    let nothing = || vec![f64::NAN; groups];
    let mut outer = Outer {
        residuals: nothing(),
        deployed: nothing(),
        warm: nothing(),
        cold: nothing(),
        cubic: nothing(),
        cubic_deployed: nothing(),
        cubics: Vec::new(),
        failed: false,
    };
    for fold in 0..FOLDS {
        let out = rows_of_fold(fold, groups);
        let used: Vec<usize> = out.clone().filter(|&group| series.is_used(group)).collect();
        if used.is_empty() {
            outer.cubics.push(None);
            continue;
        }
        // A coarse group that holds any group of the fold is no part of the choice.
        let made = coarse
            .choose(among, |group| !thinned.holds_any(group, &out))
            .and_then(|chosen| whole.fit(&chosen.spec, |group| !out.contains(&group)));
        let Some(made) = made else {
            outer.failed = true;
            outer.cubics.push(None);
            continue;
        };
        outer.predict(series, &made, &out, &used);
        outer.cubics.push(made.cubic);
    }
    outer
}

impl Outer {
    fn predict(&mut self, series: &Series<'_>, made: &Made, out: &Range<usize>, used: &[usize]) {
        let known = in_recording(&made.model, series);
        let warm = predict(&made.model, Start::Unknown, series, 0..out.end);
        let cold = predict(&made.model, Start::Unknown, series, out.clone());
        for &group in used {
            self.residuals[group] = known[group];
            self.deployed[group] = warm[group];
            self.warm[group] = warm[group];
            self.cold[group] = cold[group - out.start];
            if let Some(cubic) = &made.cubic {
                self.cubic[group] = series.rate[group] - cubic.evaluate(series.temperature[group]).0;
            }
        }
        self.cubic_deployed[out.clone()].copy_from_slice(&self.cubic[out.clone()]);
        for residuals in [&mut self.warm, &mut self.cold, &mut self.cubic_deployed] {
            take_zero_off(residuals, series.time_s, used);
        }
    }
}

/// The static cubic of everything, with what it leaves of the rates less the recording's drift in time.
pub(super) fn static_cubic(prepared: &Prepared<'_>, made: &Made, outer: &Outer) -> Option<StaticCubic> {
    let (series, drift) = (prepared.series, made.cubic.clone()?);
    let groups = series.rate.len();
    let residual = |cubic: &Drift, group: usize| {
        let timeless = series.rate[group] - made.model.time_drift.map_or(0.0, |drift| drift.at(series.time_s[group]));
        timeless - cubic.evaluate(series.temperature[group]).0
    };
    let used = |range: Range<usize>| range.filter(|&group| series.is_used(group));
    let in_sample = ResidualStatistics::of(used(0..groups).map(|group| residual(&drift, group)));
    let mut held_out = Vec::new();
    for (fold, cubic) in outer.cubics.iter().enumerate() {
        match cubic {
            Some(cubic) => held_out.extend(used(rows_of_fold(fold, groups)).map(|group| residual(cubic, group))),
            None => held_out.extend(used(rows_of_fold(fold, groups)).map(|_| f64::INFINITY)),
        }
    }
    let whole = held_out.iter().all(|residual| residual.is_finite()) && !held_out.is_empty();
    let held_out = whole.then(|| ResidualStatistics::of(held_out));
    // Autopilots hold a curve at the ends of what was measured.
    let drift = Drift { valid: prepared.features.measured, ..drift };
    Some(StaticCubic { drift, in_sample, held_out })
}
