//! Heating less cooling at equal temperature.

use std::collections::BTreeMap;
use zerorate_cal::units::{RateScale, WrittenRate};

use serde::Serialize;
use zerorate_cal::log_fit::AxisFit;
use zerorate_fit::robust::noise;
use zerorate_fit::shrinkage::shrunk;
use zerorate_fit::trace::TracePoint;

use super::span;

/// Bins of temperature in which the two directions are compared.
const BINS: usize = 40;

/// Bins that both directions must have, at least, for a hysteresis.
const LEAST_BINS: usize = 5;

/// Beyond so many standard errors a difference is told from noise: of normal noise the largest of forty is in one log in some
/// 400 (Bonferroni).
const TELLING: f64 = 4.0;

/// Thermal hysteresis of the bias.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Hysteresis {
    /// Heating less cooling on average over the temperatures that both directions have, rate.
    pub mean: f64,
    /// Its standard error, by the noise from one average to the next.
    pub mean_standard_error: f64,
    /// Heating less cooling where it is likely to be largest: each temperature's difference drawn towards the mean by the share of
    /// noise in how they scatter ([`shrunk`]).
    pub largest: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Where that is.
    pub at: f64,
    /// Root mean square over those temperatures, less what noise makes.
    pub rms: f64,
    /// The largest over the peak to peak of the bias, 0 to 1 and more; NaN, in JSON null, where the bias does not change.
    pub share: f64,
    /// The mean less the drift in time that the fit found, where that makes another: one cycle does not tell the two
    /// apart.
    pub less_drift_in_time: Option<f64>,
}

/// Heating less cooling in one bin.
struct Difference {
    bin: usize,
    value: f64,
    /// For noise of one from one average to the next.
    error: f64,
}

impl Hysteresis {
    /// The two directions, bin by bin; `less_drift_in_time` is what the curve leaves of each point but for that drift.
    pub(super) fn of(
        axis: &AxisFit,
        points: &[TracePoint],
        warming: &[bool],
        less_drift_in_time: &[f64],
        asked: Option<WrittenRate>,
    ) -> Result<Self, String> {
        let ((min, max), unit) = (span(points), axis.temperature_unit);
        if max - min < unit.min_span() {
            return Err(format!(
                "the temperature spans {:.1} {} and too little for it: let it warm and cool by {:.0}",
                max - min,
                unit.name(),
                unit.min_span()
            ));
        }
        // Less the curve, so that a bin's width is no hysteresis.
        let curve = axis.calibration.drift();
        let recorded: Vec<f64> = points.iter().map(|point| point.rate - curve.evaluate(point.temperature).0).collect();
        let both = differences(points, warming, &recorded);
        if both.len() < LEAST_BINS {
            return Err(
                "the log holds one direction of the temperature, or one before and one after an interruption; let it warm and cool over the same range in one go".to_owned()
            );
        }
        let noise = noise(&points.iter().map(|point| point.residual).collect::<Vec<_>>());
        let largest = both.iter().max_by(|a, b| a.value.abs().total_cmp(&b.value.abs())).ok_or("no temperature")?;
        let (standard_error, (mean, mean_error)) = (noise * largest.error, mean_of(&both));
        let mean_standard_error = noise * mean_error;
        let is_noise = |value: f64, error: f64| value.abs() <= TELLING * error;
        if is_noise(largest.value, standard_error) && is_noise(mean, mean_standard_error) {
            let scale = RateScale::of(axis.calibration.rate_unit, &[mean, mean_standard_error], asked);
            return Err(format!(
                "heating and cooling differ nowhere by more than {TELLING:.0} standard errors, on average by {} ± {}",
                scale.number(mean),
                scale.told(mean_standard_error)
            ));
        }
        // The largest of many noisy bins is the noisiest: each counts as what it is likely to be.
        let (values, errors): (Vec<f64>, Vec<f64>) = both.iter().map(|own| (own.value, noise * own.error)).unzip();
        let likely = shrunk(&values, &errors).into_iter().zip(&both);
        let ((largest, standard_error), place) =
            likely.max_by(|(a, _), (b, _)| a.0.abs().total_cmp(&b.0.abs())).ok_or("no temperature")?;
        let squares: f64 = both.iter().map(|own| own.value.powi(2) - (noise * own.error).powi(2)).sum();
        let less = mean_of(&differences(points, warming, less_drift_in_time)).0;
        Ok(Self {
            mean,
            mean_standard_error,
            largest,
            standard_error,
            at: min + (max - min) * (place.bin as f64 + 0.5) / BINS as f64,
            rms: (squares.max(0.0) / both.len() as f64).sqrt(),
            share: largest.abs() / axis.calibration.measured_drift().peak_to_peak(),
            less_drift_in_time: Some(less).filter(|less| !is_noise(less - mean, mean_standard_error)),
        })
    }
}

/// The mean over the bins, each counting alike, and its error for noise of one.
fn mean_of(differences: &[Difference]) -> (f64, f64) {
    let bins = differences.len() as f64;
    let value = differences.iter().map(|own| own.value).sum::<f64>() / bins;
    (value, differences.iter().map(|own| own.error.powi(2)).sum::<f64>().sqrt() / bins)
}

/// Heating less cooling in each bin, within a log: from one log to the next the rate may jump for reasons of its own.
fn differences(points: &[TracePoint], warming: &[bool], left: &[f64]) -> Vec<Difference> {
    let (min, max) = span(points);
    let mut bins: BTreeMap<(usize, u32), [(f64, f64); 2]> = BTreeMap::new();
    for ((point, warming), left) in points.iter().zip(warming).zip(left) {
        // Below 40.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bin = (((point.temperature - min) / (max - min) * BINS as f64) as usize).min(BINS - 1);
        let (sum, count) = &mut bins.entry((bin, point.log)).or_default()[usize::from(*warming)];
        *sum += left;
        *count += 1.0;
    }
    let of_log = |((bin, _), [cooling, heating]): (&(usize, u32), &[(f64, f64); 2])| {
        let value = heating.0 / heating.1 - cooling.0 / cooling.1;
        value.is_finite().then(|| (*bin, value, (1.0 / heating.1 + 1.0 / cooling.1).sqrt()))
    };
    let of_logs: Vec<(usize, f64, f64)> = bins.iter().filter_map(of_log).collect();
    // Each log's difference counts by how well it is known.
    let joined = |logs: &[(usize, f64, f64)]| {
        let weight = |error: f64| error.powi(-2);
        let weights: f64 = logs.iter().map(|(_, _, error)| weight(*error)).sum();
        let sum: f64 = logs.iter().map(|(_, value, error)| value * weight(*error)).sum();
        Difference { bin: logs[0].0, value: sum / weights, error: weights.sqrt().recip() }
    };
    of_logs.chunk_by(|a, b| a.0 == b.0).map(joined).collect()
}
