//! The number that is reported: each stretch predicted by a choice and a fit that never saw it.

use std::ops::Range;

use zerorate_core::drift::Drift;

use super::score::BOOT_S;
use super::{Made, Prepared, Series, Thinned, spread};
use crate::calibration::{HeldOut, StaticCubic};
use crate::choose::{Model, STRETCHES};

/// The residuals of the outer stretches, a group each; NaN for one that is not used, or in a stretch's first half minute
/// where a zero is taken off.
pub(super) struct Outer {
    /// Within the recording: with the drift in time.
    pub residuals: Vec<f64>,
    warm: Vec<f64>,
    cold: Vec<f64>,
    cubic: Vec<f64>,
    cubic_deployed: Vec<f64>,
    /// The static cubics of the stretches.
    cubics: Vec<Option<Drift>>,
    failed: bool,
}

impl Outer {
    pub(super) fn complete(&self) -> bool {
        !self.failed && self.residuals.iter().any(|residual| residual.is_finite())
    }

    pub(super) fn figures(&self) -> HeldOut {
        let rms =
            |values: &[f64]| Some(spread(values.iter().copied()).rms).filter(|rms| rms.is_finite() && self.complete());
        HeldOut {
            stretches: STRETCHES as u64,
            in_recording: rms(&self.residuals),
            deployed_warm: rms(&self.warm),
            deployed_cold: rms(&self.cold),
            cubic_in_recording: rms(&self.cubic),
            cubic_deployed: rms(&self.cubic_deployed),
        }
    }
}

/// The groups of an outer stretch.
fn stretch(place: usize, groups: usize) -> Range<usize> {
    place * groups / STRETCHES..(place + 1) * groups / STRETCHES
}

/// Predicts every stretch.
pub(super) fn outer(whole: &Prepared<'_>, coarse: &Prepared<'_>, thinned: &Thinned, asked: Model) -> Outer {
    let series = whole.series;
    let groups = series.rate.len();
    let nothing = || vec![f64::NAN; groups];
    let mut outer = Outer {
        residuals: nothing(),
        warm: nothing(),
        cold: nothing(),
        cubic: nothing(),
        cubic_deployed: nothing(),
        cubics: Vec::new(),
        failed: false,
    };
    for place in 0..STRETCHES {
        let out = stretch(place, groups);
        let used: Vec<usize> = out.clone().filter(|&group| series.is_used(group)).collect();
        if used.is_empty() {
            outer.cubics.push(None);
            continue;
        }
        // A coarse group that holds any group of the stretch is no part of the choice.
        let coarse_out = out.start / thinned.factor..out.end.div_ceil(thinned.factor);
        let made = coarse
            .choose(asked, |group| !coarse_out.contains(&group))
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
        let known = made.fitted.in_recording(series);
        let warm = made.fitted.deployed(series, 0..out.end);
        let cold = made.fitted.deployed(series, out.clone());
        for &group in used {
            let rate = series.rate[group];
            self.residuals[group] = rate - known[group];
            self.warm[group] = rate - warm[group];
            self.cold[group] = rate - cold[group - out.start];
            if let Some(cubic) = &made.cubic {
                self.cubic[group] = rate - cubic.evaluate(series.temperature[group]).0;
            }
        }
        self.cubic_deployed[out.clone()].copy_from_slice(&self.cubic[out.clone()]);
        for residuals in [&mut self.warm, &mut self.cold, &mut self.cubic_deployed] {
            take_zero_off(residuals, series, used);
        }
    }
}

/// Takes off the mean of the first half minute, and leaves that out.
fn take_zero_off(residuals: &mut [f64], series: &Series<'_>, used: &[usize]) {
    let first = used[0];
    let within = |&&group: &&usize| series.time_s[group] - series.time_s[first] < BOOT_S;
    let booted = used.iter().take_while(within).count().clamp(1, (used.len() / 2).max(1));
    let zero = used[..booted].iter().map(|&group| residuals[group]).sum::<f64>() / booted as f64;
    for (place, &group) in used.iter().enumerate() {
        residuals[group] = if place < booted { f64::NAN } else { residuals[group] - zero };
    }
}

/// The static cubic of everything, with what it leaves of the rates less the recording's drift in time.
pub(super) fn static_cubic(prepared: &Prepared<'_>, made: &Made, outer: &Outer) -> Option<StaticCubic> {
    let (series, drift) = (prepared.series, made.cubic.clone()?);
    let groups = series.rate.len();
    let residual = |cubic: &Drift, group: usize| {
        let timeless = series.rate[group] - made.fitted.time_drift.map_or(0.0, |drift| drift.at(series.time_s[group]));
        timeless - cubic.evaluate(series.temperature[group]).0
    };
    let used = |range: Range<usize>| range.filter(|&group| series.is_used(group));
    let in_sample = spread(used(0..groups).map(|group| residual(&drift, group)));
    let mut held_out = Vec::new();
    for (place, cubic) in outer.cubics.iter().enumerate() {
        match cubic {
            Some(cubic) => held_out.extend(used(stretch(place, groups)).map(|group| residual(cubic, group))),
            None => held_out.extend(used(stretch(place, groups)).map(|_| f64::INFINITY)),
        }
    }
    let whole = held_out.iter().all(|residual| residual.is_finite()) && !held_out.is_empty();
    let held_out = whole.then(|| spread(held_out.into_iter()));
    // Autopilots hold a curve at the ends of what was measured.
    let drift = Drift { valid: prepared.features.measured, ..drift };
    Some(StaticCubic { drift, in_sample, held_out })
}
