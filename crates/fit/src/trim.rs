//! The trim part's model from the black-box experiment (S8; paper, 2.3, eq. 2 to 5).
//!
//! The gyro is taken off and a fine supply stands in for it. At each supply voltage the reading is taken at the middle
//! tap, then the tap is searched that brings it nearest to the centre aimed at. Two straight lines come of it:
//!
//! - the paper's: `dV_i = V_i - V0` with `V0` the mean of the trimmed readings (eq. 3, 4). Each trimmed reading is off
//!   the centre by up to half a tap, and that scatters the slope: by 0.17 % over +-1000 counts, 0.74 % over +-220, for
//!   parts of the paper's gain in even steps of voltage (docs/paper.md, "What the paper leaves open"), and by twice that
//!   where the voltages fall anywhere against the taps;
//! - paired: each point against its own trimmed reading, `dV_i = V_i - V_i0`. What is left is the unevenness
//!   of the part's taps and the noise of the readings.

mod effects;
mod error;

use serde::{Deserialize, Serialize};
use zerorate_core::drift::Scale;
use zerorate_core::trim::{TapEffects, Trim, TrimLine};
use zerorate_core::units::{Counts, Taps, Volts};

use crate::least_squares::{Basis, Fit, Solution};
pub use effects::{TapReading, tap_effects};
pub use error::TrimFitError;

/// Points that a line with an estimate of its scatter needs.
pub const LEAST_POINTS: usize = 3;

/// How far a trimmed reading may stay from the centre aimed at, in taps: half a tap by rounding, one more for uneven
/// taps (MAX5494 data sheet: DNL +-1 LSB). Further away, the search did not reach the centre.
pub const REACH_TAPS: f64 = 1.5;

/// How far a point may lie off the paired line, in taps: +-2 by the part (MAX5494 data sheet: INL +-2 LSB), one more
/// for noise and the middle tap's own error. Further away, a reading was not what it should be.
pub const STRAY_TAPS: f64 = 3.0;

/// One supply voltage of the experiment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SupplyPoint {
    /// What the supply was set to; only to name the point.
    pub supply: Volts,
    /// `V_i`: the reading at the middle tap.
    pub at_middle: Counts,
    /// `V_i0`: the reading at the tap found.
    pub trimmed: Counts,
    /// `N_i`: the tap found.
    pub tap: Taps,
}

/// A straight line `dN = a dV + b` (eq. 2) with what is known of its errors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TrimEstimate {
    /// `a`, taps per count; below zero, since a higher tap raises the reading.
    pub slope_taps_per_count: f64,
    /// Standard error of `a`.
    pub slope_standard_error_taps_per_count: f64,
    /// `b`, taps.
    pub intercept_taps: f64,
    /// Standard error of `b`.
    pub intercept_standard_error_taps: f64,
    /// `V0`, counts: the mean of the trimmed readings (eq. 4).
    pub centre_counts: f64,
    /// Standard error of `V0`.
    pub centre_standard_error_counts: f64,
    /// Root mean square of the residual `dN_i - (a dV_i + b)`, in-sample, taps.
    pub residual_rms_taps: f64,
}

impl TrimEstimate {
    /// How far one tap moves the reading: `-1/a`.
    #[must_use]
    pub fn counts_per_tap(&self) -> Counts {
        Counts(-1.0 / self.slope_taps_per_count)
    }
}

/// The outcome of the experiment on one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct TrimFit {
    /// The paper's line.
    pub paper: TrimEstimate,
    /// Each point against its own trimmed reading.
    pub paired: TrimEstimate,
    /// `N0`, the tap at which `V_i` was read.
    pub middle: Taps,
    /// The centre that the tap search aimed at.
    pub aim: Counts,
    /// The points, for the figure.
    pub points: Vec<SupplyPoint>,
}

impl TrimFit {
    /// The trim model for the law: the paired line about a centre, and the measured effects where there are any.
    ///
    /// In eq. (2) `V0` is where `dV` is counted from. The paired line knows only differences of readings, so it holds
    /// about any centre: `aim` makes the compensated reading what the circuit was laid out for, `paired.centre_counts`
    /// what the paper would have taken.
    ///
    /// # Errors
    /// [`TrimFitError::Centre`], when the centre is not finite.
    pub fn trim(&self, centre: Counts, measured: Option<TapEffects>) -> Result<Trim, TrimFitError> {
        let line = TrimLine::new(self.paired.slope_taps_per_count, self.paired.intercept_taps, centre, self.middle);
        Ok(Trim { line: line.ok_or(TrimFitError::Centre)?, measured })
    }
}

/// Fits both lines to the points of one axis. `aim` is the centre that the tap search went for (8200 in the paper),
/// `middle` the tap at which `V_i` was read (`N0`, 511).
///
/// # Errors
/// [`TrimFitError`], when the points do not settle a line, or the experiment did not go as it should: it names the
/// supply voltage at which.
pub fn fit_trim(points: &[SupplyPoint], aim: Counts, middle: Taps) -> Result<TrimFit, TrimFitError> {
    if points.len() < LEAST_POINTS {
        return Err(TrimFitError::TooFewPoints { found: points.len() });
    }
    if let Some(point) = points.iter().find(|point| !(point.at_middle.0.is_finite() && point.trimmed.0.is_finite())) {
        return Err(TrimFitError::NotFinite { supply_v: point.supply.0 });
    }
    let first = points[0].tap;
    if points.iter().all(|point| point.tap == first) {
        return Err(TrimFitError::OneTap { tap: first.get() });
    }
    let centre = Mean::of(points.iter().map(|point| point.trimmed.0));
    let paired = estimate(points, middle, centre, |point| point.at_middle - point.trimmed)?;
    if paired.slope_taps_per_count >= 0.0 {
        return Err(TrimFitError::WrongSign { slope_taps_per_count: paired.slope_taps_per_count });
    }
    check_reach(points, aim, paired.counts_per_tap())?;
    check_strays(points, middle, &paired)?;
    let paper = estimate(points, middle, centre, |point| point.at_middle - Counts(centre.mean))?;
    Ok(TrimFit { paper, paired, middle, aim, points: points.to_vec() })
}

/// Least squares of `dN_i = N_i - N0` (eq. 5) on a `dV_i`.
fn estimate(
    points: &[SupplyPoint],
    middle: Taps,
    centre: Mean,
    difference: impl Fn(&SupplyPoint) -> Counts,
) -> Result<TrimEstimate, TrimFitError> {
    let differences: Vec<f64> = points.iter().map(|point| difference(point).0).collect();
    let least = differences.iter().copied().fold(f64::INFINITY, f64::min);
    let most = differences.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let scale = Scale::spanning(least, most).ok_or(TrimFitError::OneReading { reading: points[0].at_middle.0 })?;
    let mut fit = Fit::new(scale, Basis::Powers(1));
    for (point, dv) in points.iter().zip(&differences) {
        fit.push(*dv, shift_taps(point, middle));
    }
    let solution = fit.finish()?;
    let (slope_error, intercept_error) = standard_errors(&solution);
    let raw = solution.raw_coefficients();
    Ok(TrimEstimate {
        slope_taps_per_count: raw[1],
        slope_standard_error_taps_per_count: slope_error,
        intercept_taps: raw[0],
        intercept_standard_error_taps: intercept_error,
        centre_counts: centre.mean,
        centre_standard_error_counts: centre.standard_error,
        residual_rms_taps: solution.rms,
    })
}

/// `dN_i` (eq. 5), taps.
fn shift_taps(point: &SupplyPoint, middle: Taps) -> f64 {
    f64::from(point.tap.get()) - f64::from(middle.get())
}

/// Standard errors of slope and intercept. With `x = (dV - m) / h` the slope is `c1 / h` and the intercept
/// `c0 - c1 m / h`.
fn standard_errors(solution: &Solution) -> (f64, f64) {
    let (m, h) = (solution.scale.centre(), solution.scale.half_span());
    let covariance = &solution.covariance;
    let lever = m / h;
    let intercept = covariance[0][0] - 2.0 * lever * covariance[0][1] + lever * lever * covariance[1][1];
    (covariance[1][1].sqrt() / h, intercept.sqrt())
}

fn check_reach(points: &[SupplyPoint], aim: Counts, counts_per_tap: Counts) -> Result<(), TrimFitError> {
    for point in points {
        let off_taps = (point.trimmed - aim).0 / counts_per_tap.0;
        if off_taps.abs() > REACH_TAPS {
            return Err(TrimFitError::NotReached {
                supply_v: point.supply.0,
                tap: point.tap.get(),
                trimmed: point.trimmed.0,
                aim: aim.0,
                off_taps,
            });
        }
    }
    Ok(())
}

fn check_strays(points: &[SupplyPoint], middle: Taps, paired: &TrimEstimate) -> Result<(), TrimFitError> {
    for point in points {
        let by_line = paired.slope_taps_per_count * (point.at_middle - point.trimmed).0 + paired.intercept_taps;
        let off_taps = shift_taps(point, middle) - by_line;
        if off_taps.abs() > STRAY_TAPS {
            return Err(TrimFitError::Stray { supply_v: point.supply.0, at_middle: point.at_middle.0, off_taps });
        }
    }
    Ok(())
}

/// A mean and its standard error.
#[derive(Debug, Clone, Copy)]
struct Mean {
    mean: f64,
    standard_error: f64,
}

impl Mean {
    /// Of two numbers or more.
    fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        let count = values.clone().count() as f64;
        let mean = values.clone().sum::<f64>() / count;
        let variance = values.map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
        Self { mean, standard_error: (variance / count).sqrt() }
    }
}

#[cfg(test)]
mod tests;
