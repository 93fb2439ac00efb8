//! What a fitted log says of a sensor beside its curve, under the names of IEEE Std 952-1997 and 528-2019: bias temperature
//! sensitivity, thermal hysteresis, bias temperature-ramp sensitivity, and the noise of the residual.
//!
//! Each is given where the recording holds it, and else the reason why it does not.

mod soak;

use serde::{Serialize, Serializer};

use zerorate_fit::allan::{Allan, NoAllan};
use zerorate_fit::direction::warming;
use zerorate_fit::folds::{FOLDS, fold_of_row};
use zerorate_fit::robust::median;

use crate::log_fit::AxisFit;
use crate::trace::TracePoint;
pub use soak::{AxisNoise, NoiseOf, noise};

/// Bins of temperature in which the two directions are compared.
const BINS: usize = 40;

/// Bins that both directions must have, at least, for a hysteresis.
const LEAST_BINS: usize = 5;

/// Points at which a curve's slope is looked at.
const SLOPES: u32 = 400;

/// The ramp's speed must vary by this part of its size at equal temperature and direction: otherwise what it does cannot be
/// told from the curve or from hysteresis.
const LEAST_VARIATION: f64 = 0.2;

/// What a fitted log says of one axis. Rates and temperatures are in the log's units.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Characteristics {
    /// How the bias changes with temperature.
    pub temperature_sensitivity: TemperatureSensitivity,
    /// Heating less cooling at equal temperature.
    #[serde(serialize_with = "or_reason")]
    pub hysteresis: Result<Hysteresis, String>,
    /// What is left in proportion to the speed of the temperature.
    #[serde(serialize_with = "or_reason")]
    pub ramp_sensitivity: Result<RampSensitivity, String>,
    /// The noise of the residual, over averaging times from the spacing of the averages on.
    #[serde(serialize_with = "or_reason")]
    pub residual_noise: Result<Allan, String>,
}

/// What was found, or why nothing was: `{"none": "the log holds one direction alone"}`.
pub(crate) fn or_reason<T: Serialize, S: Serializer>(found: &Result<T, String>, to: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Nothing<'a> {
        none: &'a str,
    }
    match found {
        Ok(found) => found.serialize(to),
        Err(none) => Nothing { none }.serialize(to),
    }
}

/// Bias temperature sensitivity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TemperatureSensitivity {
    /// The slope of the straight line nearest to the curve, rate a degree.
    pub mean: f64,
    /// The curve's steepest slope, rate a degree, with its sign.
    pub steepest: f64,
    /// Where it is.
    pub steepest_at: f64,
}

/// Thermal hysteresis of the bias.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Hysteresis {
    /// Heating less cooling where it is largest, rate.
    pub largest: f64,
    /// Where that is.
    pub at: f64,
    /// Root mean square over the temperatures that both directions have.
    pub rms: f64,
    /// The largest over the peak to peak of the bias, 0 to 1 and more; NaN, in JSON null, where the bias does not change.
    pub share: f64,
}

/// Bias temperature-ramp sensitivity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RampSensitivity {
    /// Rate for a degree a second.
    pub value: f64,
    /// Its standard error, by leaving out one fold of the log at a time (jackknife).
    pub standard_error: f64,
}

impl Characteristics {
    /// Of one fitted axis.
    #[must_use]
    pub fn of(axis: &AxisFit) -> Self {
        let points: Vec<TracePoint> = axis
            .trace
            .iter()
            .copied()
            .filter(|point| point.temperature.is_finite() && point.rate.is_finite())
            .collect();
        let temperatures: Vec<f64> = points.iter().map(|point| point.temperature).collect();
        let warming = warming(&temperatures);
        Self {
            temperature_sensitivity: temperature_sensitivity(axis),
            hysteresis: hysteresis(&points, &warming, axis.calibration.measured_drift().peak_to_peak()),
            ramp_sensitivity: ramp_sensitivity(&points, &warming),
            residual_noise: residual_noise(&points).map_err(|error| error.to_string()),
        }
    }
}

fn temperature_sensitivity(axis: &AxisFit) -> TemperatureSensitivity {
    let (min, max) = (axis.calibration.fit.measured.min(), axis.calibration.fit.measured.max());
    let step = (max - min) / f64::from(SLOPES);
    let at = |i: u32| min + step * f64::from(i);
    let value = |i: u32| axis.calibration.drift().evaluate(at(i)).0;
    let slope = |i: u32| (value(i + 1) - value(i)) / step;
    let steepest = (0..SLOPES).max_by(|a, b| slope(*a).abs().total_cmp(&slope(*b).abs())).unwrap_or(0);
    // Least squares over equally spaced temperatures.
    let middle = f64::midpoint(min, max);
    let (products, squares) = (0..=SLOPES).fold((0.0, 0.0), |(products, squares), i| {
        (products + (at(i) - middle) * value(i), squares + (at(i) - middle).powi(2))
    });
    TemperatureSensitivity {
        mean: products / squares,
        steepest: slope(steepest),
        steepest_at: at(steepest) + step / 2.0,
    }
}

/// The two directions, bin by bin.
fn hysteresis(points: &[TracePoint], warming: &[bool], pp: f64) -> Result<Hysteresis, String> {
    let (min, max) = span(points);
    let mut bins = vec![[(0.0, 0.0); 2]; BINS];
    for (point, warming) in points.iter().zip(warming) {
        // Below 40.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bin = (((point.temperature - min) / (max - min) * BINS as f64) as usize).min(BINS - 1);
        let (sum, count) = &mut bins[bin][usize::from(*warming)];
        *sum += point.rate;
        *count += 1.0;
    }
    let both: Vec<(usize, f64)> = bins
        .iter()
        .enumerate()
        .filter(|(_, [cooling, heating])| cooling.1 > 0.0 && heating.1 > 0.0)
        .map(|(bin, [cooling, heating])| (bin, heating.0 / heating.1 - cooling.0 / cooling.1))
        .collect();
    if both.len() < LEAST_BINS {
        return Err(
            "the log holds one direction of the temperature; let it warm and cool over the same range".to_owned()
        );
    }
    let (bin, largest) = both.iter().copied().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or((0, 0.0));
    Ok(Hysteresis {
        largest,
        at: min + (max - min) * (bin as f64 + 0.5) / BINS as f64,
        rms: (both.iter().map(|(_, difference)| difference * difference).sum::<f64>() / both.len() as f64).sqrt(),
        share: largest.abs() / pp,
    })
}

fn span(points: &[TracePoint]) -> (f64, f64) {
    let temperatures = points.iter().map(|point| point.temperature);
    temperatures.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), t| (min.min(t), max.max(t)))
}

/// What one point says of the ramp.
#[derive(Debug, Clone, Copy)]
struct Ramp {
    warming: bool,
    /// Temperature, -1 to 1 over the log's span.
    x: f64,
    /// Degrees a second.
    speed: f64,
    residual: f64,
}

/// The residual against the speed of the temperature, beside a constant for each direction (hysteresis) and a cubic of
/// temperature (what the curve may have taken).
fn ramp_sensitivity(points: &[TracePoint], warming: &[bool]) -> Result<RampSensitivity, String> {
    let (min, max) = span(points);
    let speed = |i: usize| {
        let (before, after) = (&points[i.saturating_sub(1)], &points[(i + 1).min(points.len() - 1)]);
        (after.temperature - before.temperature) / (after.time_s - before.time_s)
    };
    let rows: Vec<Ramp> = (0..points.len())
        .map(|i| Ramp {
            warming: warming[i],
            x: 2.0 * (points[i].temperature - min) / (max - min) - 1.0,
            speed: speed(i),
            residual: points[i].residual,
        })
        .filter(|row| row.speed.is_finite() && row.residual.is_finite())
        .collect();
    if rows.len() < 4 * FOLDS {
        return Err("the log has no time, or too little of it".to_owned());
    }
    let size = (rows.iter().map(|row| row.speed.powi(2)).sum::<f64>() / rows.len() as f64).sqrt();
    let (value, variation) = regression(&rows, None);
    if variation.is_nan() || variation < LEAST_VARIATION * size {
        return Err(
            "at each temperature it always changed at one speed; let it change fast and slowly over the same range"
                .to_owned(),
        );
    }
    // The jackknife: each fold left out once.
    let without: Vec<f64> = (0..FOLDS).map(|fold| regression(&rows, Some(fold)).0).collect();
    let folds = FOLDS as f64;
    let mean = without.iter().sum::<f64>() / folds;
    let variance = without.iter().map(|value| (value - mean).powi(2)).sum::<f64>() * (folds - 1.0) / folds;
    Ok(RampSensitivity { value, standard_error: variance.sqrt() })
}

/// The slope of residual over speed beside the other terms, and how much of the speed these do not explain, root mean
/// square: by making each term orthogonal to those before it, the speed last.
fn regression(rows: &[Ramp], without: Option<usize>) -> (f64, f64) {
    let kept: Vec<&Ramp> = (0..rows.len())
        .filter(|i| without != Some(fold_of_row(*i as u64, rows.len() as u64)))
        .map(|i| &rows[i])
        .collect();
    let terms: [fn(&Ramp) -> f64; 6] = [
        |row| f64::from(u8::from(row.warming)),
        |row| f64::from(u8::from(!row.warming)),
        |row| row.x,
        |row| row.x.powi(2),
        |row| row.x.powi(3),
        |row| row.speed,
    ];
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut before: Vec<Vec<f64>> = Vec::new();
    for term in terms {
        let mut column: Vec<f64> = kept.iter().map(|row| term(row)).collect();
        for other in &before {
            let squares = dot(other, other);
            // A direction that the log does not have is a column of zeros.
            if squares > 0.0 {
                let share = dot(&column, other) / squares;
                column.iter_mut().zip(other).for_each(|(value, other)| *value -= share * other);
            }
        }
        before.push(column);
    }
    let speed = before.pop().unwrap_or_default();
    let residuals: Vec<f64> = kept.iter().map(|row| row.residual).collect();
    let squares = dot(&speed, &speed);
    (dot(&speed, &residuals) / squares, (squares / kept.len() as f64).sqrt())
}

/// The Allan deviation of the residual, on an even grid of time in which what was left out is a gap.
// Places on a grid of some thousands.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn residual_noise(points: &[TracePoint]) -> Result<Allan, NoAllan> {
    let mut steps: Vec<f64> = points.windows(2).map(|pair| pair[1].time_s - pair[0].time_s).collect();
    let period_s = median(&mut steps);
    if !(period_s.is_finite() && period_s > 0.0) {
        return Err(NoAllan::NoPeriod { period_s });
    }
    let first_s = points[0].time_s;
    let place = |point: &TracePoint| ((point.time_s - first_s) / period_s).round().max(0.0) as usize;
    // A log with hours of gaps has no more places than points, times a few.
    let most = 8 * points.len();
    let mut even = Vec::new();
    for point in points {
        let place = place(point);
        if place < most {
            even.resize(even.len().max(place + 1), f64::NAN);
            even[place] = point.residual;
        }
    }
    Allan::of(&even, period_s)
}

#[cfg(test)]
mod tests;
