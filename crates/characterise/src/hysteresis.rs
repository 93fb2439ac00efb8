//! Heating less cooling at equal temperature.

use std::collections::BTreeMap;

use serde::Serialize;
use zerorate_cal::log_fit::AxisFit;
use zerorate_cal::trace::TracePoint;
use zerorate_fit::robust::noise;

use super::span;

/// Bins of temperature in which the two directions are compared.
const BINS: usize = 40;

/// Bins that both directions must have, at least, for a hysteresis.
const LEAST_BINS: usize = 5;

/// The largest of so many differences is told from noise alone beyond so many of its standard errors: of normal noise one log
/// in some 400 has one (Bonferroni).
const TELLING: f64 = 4.0;

/// Thermal hysteresis of the bias.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Hysteresis {
    /// Heating less cooling where it is largest, rate.
    pub largest: f64,
    /// Its standard error, by the noise from one average to the next.
    pub standard_error: f64,
    /// Where that is.
    pub at: f64,
    /// Root mean square over the temperatures that both directions have.
    pub rms: f64,
    /// The largest over the peak to peak of the bias, 0 to 1 and more; NaN, in JSON null, where the bias does not change.
    pub share: f64,
}

/// Heating less cooling in one bin.
struct Difference {
    bin: usize,
    value: f64,
    /// For noise of one from one average to the next.
    error: f64,
}

impl Hysteresis {
    /// The two directions, bin by bin.
    pub(super) fn of(axis: &AxisFit, points: &[TracePoint], warming: &[bool]) -> Result<Self, String> {
        let ((min, max), excess) = (span(points), excess(axis, points));
        let both = differences(points, warming, &excess);
        if both.len() < LEAST_BINS {
            return Err(
                "the log holds one direction of the temperature, or one before and one after an interruption; let it warm and cool over the same range in one go".to_owned()
            );
        }
        let residuals: Vec<f64> = points.iter().map(|point| point.residual).collect();
        let noise = noise(&residuals);
        let largest = both.iter().max_by(|a, b| a.value.abs().total_cmp(&b.value.abs())).ok_or("no temperature")?;
        let standard_error = noise * largest.error;
        if largest.value.abs() <= TELLING * standard_error {
            return Err(format!(
                "heating and cooling differ nowhere by more than their noise: by {:.1e} at most, of which noise alone makes ± {standard_error:.1e} {}",
                largest.value.abs(),
                axis.calibration.rate_unit
            ));
        }
        let squares: f64 = both.iter().map(|difference| difference.value.powi(2)).sum();
        Ok(Self {
            largest: largest.value,
            standard_error,
            at: min + (max - min) * (largest.bin as f64 + 0.5) / BINS as f64,
            rms: (squares / both.len() as f64).sqrt(),
            share: largest.value.abs() / axis.calibration.measured_drift().peak_to_peak(),
        })
    }
}

/// The rates less the curve, so that a bin's width is no hysteresis, and less the log's own drift in time, so that what goes
/// on between heating and cooling is none: what the model leaves, and what it says that the drift remembers.
fn excess(axis: &AxisFit, points: &[TracePoint]) -> Vec<f64> {
    let biases = axis.calibration.fit.model.biases(points.iter().map(|point| (point.time_s, point.temperature)));
    let curve = axis.calibration.drift();
    let excess = |(point, bias): (&TracePoint, f64)| point.residual + bias - curve.evaluate(point.temperature).0;
    points.iter().zip(biases).map(excess).collect()
}

/// Heating less cooling in each bin, within a log: from one log to the next the rate may jump for reasons of its own.
fn differences(points: &[TracePoint], warming: &[bool], excess: &[f64]) -> Vec<Difference> {
    let (min, max) = span(points);
    let mut bins: BTreeMap<(usize, u32), [(f64, f64); 2]> = BTreeMap::new();
    for ((point, warming), excess) in points.iter().zip(warming).zip(excess) {
        // Below 40.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bin = (((point.temperature - min) / (max - min) * BINS as f64) as usize).min(BINS - 1);
        let (sum, count) = &mut bins.entry((bin, point.log)).or_default()[usize::from(*warming)];
        *sum += excess;
        *count += 1.0;
    }
    let of_log = |((bin, _), [cooling, heating]): (&(usize, u32), &[(f64, f64); 2])| {
        let value = heating.0 / heating.1 - cooling.0 / cooling.1;
        value.is_finite().then(|| (*bin, value, (1.0 / heating.1 + 1.0 / cooling.1).sqrt()))
    };
    let of_logs: Vec<(usize, f64, f64)> = bins.iter().filter_map(of_log).collect();
    // Each log's difference counts by how well it is known.
    let mean = |logs: &[(usize, f64, f64)]| {
        let weight = |error: f64| error.powi(-2);
        let weights: f64 = logs.iter().map(|(_, _, error)| weight(*error)).sum();
        let sum: f64 = logs.iter().map(|(_, value, error)| value * weight(*error)).sum();
        Difference { bin: logs[0].0, value: sum / weights, error: weights.sqrt().recip() }
    };
    of_logs.chunk_by(|a, b| a.0 == b.0).map(mean).collect()
}
