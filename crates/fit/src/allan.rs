//! Allan deviation of a rate at constant temperature, and the coefficients that are read off it.
//!
//! The rate is a *frequency* in the sense of NIST Special Publication 1065 (W. J. Riley, *Handbook of Frequency Stability
//! Analysis*, 2008): its overlapping Allan variance at the averaging time `tau = m tau0` is the mean of
//! `(mean of samples k+m..k+2m - mean of samples k..k+m)^2 / 2` over all `k` (5.2.4 there). The names of the coefficients
//! are those of IEEE Std 952-1997, annex C: angle random walk N, bias instability B, rate random walk K.
//!
//! A sample that is no number is a gap: averages that would need it are left out.

mod coefficients;
mod confidence;
mod filter;
mod trend;

use serde::Serialize;
use thiserror::Error;

use coefficients::noises;
pub use coefficients::{Coefficient, Coefficients};
pub use confidence::{LEVEL, Noise};
use confidence::{degrees_of_freedom, interval};

/// Samples that a curve needs: fewer give no confidence at any averaging time.
pub const LEAST_SAMPLES: usize = 32;

/// The longest averaging time, as a part of the record: at a third of it two independent differences are left.
const LONGEST: usize = 3;

/// Averaging times an octave.
const PER_OCTAVE: f64 = 3.0;

/// The Allan deviation at one averaging time. Deviations are in the rate's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AllanPoint {
    /// Averaging time, seconds.
    pub tau_s: f64,
    /// Overlapping Allan deviation.
    pub deviation: f64,
    /// Its lower bound at the confidence [`LEVEL`].
    pub low: f64,
    /// Its upper bound.
    pub high: f64,
    /// Equivalent degrees of freedom of the variance, for the noise there.
    pub degrees_of_freedom: f64,
    /// The noise that is the largest part there.
    pub noise: Noise,
}

/// The Allan deviation over averaging time, and what it says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Allan {
    /// Time between samples, seconds.
    pub period_s: f64,
    /// Samples that are numbers.
    pub samples: u64,
    /// The curve, shortest averaging time first.
    pub points: Vec<AllanPoint>,
    /// Below this averaging time samples resemble their neighbours, as behind the gyro's own filter, and nothing is read off
    /// the curve, seconds; none where no filter shows.
    pub filtered_below_s: Option<f64>,
    /// Whether the curve rises by a smooth trend in time or with temperature, which is no noise.
    pub smooth_trend: bool,
    /// N, B and K, by the curve from there on; what is seen is read of the record less its smooth trend.
    pub coefficients: Coefficients,
}

/// Why there is no Allan deviation.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum NoAllan {
    /// Too few samples.
    #[error("{samples} samples in a row: an Allan deviation takes {LEAST_SAMPLES} at least; record for longer")]
    TooShort {
        /// Samples that are numbers.
        samples: usize,
    },
    /// The time between samples is no time.
    #[error("the time between samples is not known, or not above zero: the log needs a time column that rises")]
    NoPeriod {
        /// The time between samples, seconds.
        period_s: f64,
    },
    /// The temperature changed: what would be found is drift, not noise.
    #[error(
        "the temperature goes from {min:.1} to {max:.1} {unit}: on a ramp the Allan deviation shows the drift, not the noise; take a soak, or the residuals of a calibration"
    )]
    Ramp {
        /// The least temperature, in its own unit.
        min: f64,
        /// The greatest.
        max: f64,
        /// The temperature's unit.
        unit: &'static str,
    },
    /// The rate never changes.
    #[error("the rate never changes: the sensor is stuck, or the column is another")]
    Constant,
}

/// Running sums of a record with gaps, from which an average over any window is one subtraction.
#[derive(Debug)]
struct Sums {
    /// Sum of the samples before each place, less their mean; a gap adds nothing.
    sums: Vec<f64>,
    /// Numbers before each place.
    counts: Vec<usize>,
}

impl Sums {
    fn of(rates: &[f64]) -> Self {
        let finite = || rates.iter().copied().filter(|rate| rate.is_finite());
        // Less the mean, so that nothing of a small noise is lost beside a large bias.
        let mean = finite().sum::<f64>() / finite().count().max(1) as f64;
        let (mut sum, mut count) = (0.0, 0);
        let (mut sums, mut counts) = (vec![0.0], vec![0]);
        for rate in rates {
            if rate.is_finite() {
                sum += rate - mean;
                count += 1;
            }
            sums.push(sum);
            counts.push(count);
        }
        Self { sums, counts }
    }

    fn len(&self) -> usize {
        self.sums.len() - 1
    }

    /// The sum of squares of differences of neighbouring means over `m` samples, each pair beginning `stride` after the one
    /// before it, and how many there were.
    fn squares(&self, m: usize, stride: usize) -> (f64, u64) {
        let mut squares = 0.0;
        let mut pairs = 0;
        for k in (0..=self.len().saturating_sub(2 * m)).step_by(stride) {
            if self.len() >= 2 * m && self.counts[k + 2 * m] - self.counts[k] == 2 * m {
                let difference = (self.sums[k + 2 * m] - 2.0 * self.sums[k + m] + self.sums[k]) / m as f64;
                squares += difference * difference;
                pairs += 1;
            }
        }
        (squares, pairs)
    }
}

impl Allan {
    /// The Allan deviation of evenly spaced rates at constant temperature, or of residuals; NaN marks a gap.
    ///
    /// # Errors
    /// [`NoAllan`], when the record is too short, has no time or never changes.
    pub fn of(rates: &[f64], period_s: f64) -> Result<Self, NoAllan> {
        Self::beside(rates, None, period_s)
    }

    /// The same with the temperatures of the rates, as many: what goes with them is no noise.
    ///
    /// # Errors
    /// [`NoAllan`], when the record is too short, has no time or never changes.
    pub fn of_soak(rates: &[f64], temperatures: &[f64], period_s: f64) -> Result<Self, NoAllan> {
        Self::beside(rates, Some(temperatures), period_s)
    }

    fn beside(rates: &[f64], temperatures: Option<&[f64]>, period_s: f64) -> Result<Self, NoAllan> {
        if !(period_s.is_finite() && period_s > 0.0) {
            return Err(NoAllan::NoPeriod { period_s });
        }
        let sums = Sums::of(rates);
        let samples = sums.counts[sums.len()];
        if samples < LEAST_SAMPLES {
            return Err(NoAllan::TooShort { samples });
        }
        let found = variances(&sums, samples / LONGEST);
        if found.is_empty() {
            return Err(NoAllan::TooShort { samples });
        }
        if found.iter().any(|(_, deviation, _)| *deviation <= 0.0) {
            return Err(NoAllan::Constant);
        }
        let point = |(m, deviation, pairs): (usize, f64, u64), noise| {
            let degrees_of_freedom = degrees_of_freedom(noise, pairs, m);
            let (low, high) = interval(deviation, degrees_of_freedom);
            AllanPoint { tau_s: m as f64 * period_s, deviation, low, high, degrees_of_freedom, noise }
        };
        let points_of = |found: &[(usize, f64, u64)], filtered: usize| -> Vec<AllanPoint> {
            let first: Vec<AllanPoint> = found.iter().map(|found| point(*found, Noise::AngleRandomWalk)).collect();
            let noises = noises(&first[filtered..], filtered > 0);
            let noises = vec![Noise::Filtered; filtered].into_iter().chain(noises);
            found.iter().zip(noises).map(|(found, noise)| point(*found, noise)).collect()
        };
        let first: Vec<AllanPoint> = found.iter().map(|found| point(*found, Noise::AngleRandomWalk)).collect();
        let filtered = filter::end(&first);
        let points = points_of(&found, filtered);
        let left = Sums::of(&trend::without(rates, temperatures));
        let level = variances(&left, samples / trend::READ);
        let level = if level.len() > filtered && level.iter().all(|(_, deviation, _)| *deviation > 0.0) {
            points_of(&level, filtered).split_off(filtered)
        } else {
            Vec::new()
        };
        let filtered_below_s = (filtered > 0).then(|| points[filtered].tau_s);
        let (coefficients, smooth_trend) = Coefficients::of(&points[filtered..], &level, filtered > 0);
        Ok(Self { period_s, samples: samples as u64, points, filtered_below_s, smooth_trend, coefficients })
    }

    /// The Allan deviation at a time of a second, where the curve spans it, by interpolation; for comparisons.
    #[must_use]
    pub fn at(&self, tau_s: f64) -> Option<f64> {
        let after = self.points.iter().position(|point| point.tau_s >= tau_s * (1.0 - 1e-9))?;
        let (b, a) = (self.points[after], self.points[after.saturating_sub(1)]);
        if after == 0 || b.tau_s <= tau_s {
            return ((b.tau_s / tau_s - 1.0).abs() < 1e-6).then_some(b.deviation);
        }
        let part = libm::log(tau_s / a.tau_s) / libm::log(b.tau_s / a.tau_s);
        Some(a.deviation * libm::pow(b.deviation / a.deviation, part))
    }
}

/// Averaging factors with their Allan deviations and the differences that these are of.
fn variances(sums: &Sums, longest: usize) -> Vec<(usize, f64, u64)> {
    let found = averaging(longest).into_iter().filter_map(|m| {
        let (squares, pairs) = sums.squares(m, 1);
        (pairs > 1).then(|| (m, (squares / (2.0 * pairs as f64)).sqrt(), pairs))
    });
    found.collect()
}

/// Averaging factors, a few an octave, up to the longest.
// Factors are far below 2^53, and above zero.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn averaging(longest: usize) -> Vec<usize> {
    let mut factors: Vec<usize> =
        (0..).map(|i| libm::exp2(f64::from(i) / PER_OCTAVE).round() as usize).take_while(|m| *m <= longest).collect();
    factors.dedup();
    factors
}

#[cfg(test)]
mod tests;
