//! How the bias changes with temperature: a curve's mean slope and its steepest.

use serde::Serialize;
use zerorate_cal::log_fit::AxisFit;
use zerorate_core::drift::Shape;

use crate::soak::SOAK;

/// Points at which a curve's slope is looked at.
const SLOPES: u32 = 400;

/// Bias temperature sensitivity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TemperatureSensitivity {
    /// The slope of the straight line nearest to the curve, rate a degree.
    pub mean: f64,
    /// One standard error of it, by the curve's covariance; NaN of the cubic that stands for a curve beside a history.
    pub mean_standard_error: f64,
    /// The curve's steepest slope, rate a degree, with its sign.
    pub steepest: f64,
    /// One standard error of the slope there by the noise, which does not know how much a curve bends within a piece. Of a curve that is level the steepest piece is the noisiest.
    pub steepest_standard_error: f64,
    /// Where it is.
    pub steepest_at: f64,
}

impl TemperatureSensitivity {
    pub(super) fn of(axis: &AxisFit) -> Self {
        let (min, max) = (axis.calibration.fit.measured.min(), axis.calibration.fit.measured.max());
        let step = (max - min) / f64::from(SLOPES);
        let at = |i: u32| min + step * f64::from(i);
        let drift = axis.calibration.measured_drift();
        let value = |i: u32| drift.evaluate(at(i)).0;
        // A table has one slope from knot to knot.
        let places: Vec<f64> = match &drift.shape {
            Shape::Polynomial(_) => (0..=SLOPES).map(at).collect(),
            Shape::Table(table) => {
                let knots = (0..table.knots().len()).map(|knot| table.knot_temperature(knot));
                [min]
                    .into_iter()
                    .chain(knots.filter(|knot| (min..max).contains(knot) && *knot > min))
                    .chain([max])
                    .collect()
            }
        };
        let slope = |pair: &[f64]| (drift.evaluate(pair[1]).0 - drift.evaluate(pair[0]).0) / (pair[1] - pair[0]);
        let steepest =
            places.windows(2).max_by(|a, b| slope(a).abs().total_cmp(&slope(b).abs())).unwrap_or(&[0.0, 1.0]);
        // Least squares over equally spaced temperatures.
        let middle = f64::midpoint(min, max);
        let squares: f64 = (0..=SLOPES).map(|i| (at(i) - middle).powi(2)).sum();
        let share = |i: u32| (at(i) - middle) / squares;
        // The covariance is of the model's own curve: what stands for it beside a history has none.
        let has_history = axis.calibration.fit.model.history.is_some();
        let error = |shares: &[(f64, f64)]| {
            if has_history {
                return f64::NAN;
            }
            standard_error(&drift.shape, &axis.calibration.fit.statistics.covariance, shares)
        };
        let of_all: Vec<(f64, f64)> = (0..=SLOPES).map(|i| (at(i), share(i))).collect();
        let over = steepest[1] - steepest[0];
        let of_piece = [(steepest[0], -1.0 / over), (steepest[1], 1.0 / over)];
        Self {
            mean: (0..=SLOPES).map(|i| share(i) * value(i)).sum(),
            mean_standard_error: error(&of_all),
            steepest: slope(steepest),
            steepest_standard_error: error(&of_piece),
            steepest_at: f64::midpoint(steepest[0], steepest[1]),
        }
    }
}

/// Whether an axis's temperatures are those of a soak: what they differ by is the thermometer's noise, and a slope over it says
/// nothing of the gyro.
#[must_use]
pub fn is_of_a_soak(axis: &AxisFit) -> bool {
    let measured = axis.calibration.fit.measured;
    measured.max() - measured.min() < SOAK * axis.temperature_unit.min_span()
}

/// What each scaled coefficient, or each knot, of a curve weighs at a temperature.
fn weights(shape: &Shape, temperature: f64) -> Vec<f64> {
    match shape {
        Shape::Polynomial(polynomial) => {
            let x = polynomial.scale().x(temperature);
            std::iter::successors(Some(1.0), |power| Some(power * x)).take(polynomial.coefficients().len()).collect()
        }
        Shape::Table(table) => {
            let pieces = table.knots().len() - 1;
            let place = 0.5 * (table.scale().x(temperature).clamp(-1.0, 1.0) + 1.0) * pieces as f64;
            (0..=pieces).map(|knot| (1.0 - (place - knot as f64).abs()).max(0.0)).collect()
        }
    }
}

/// One standard error of a sum of the curve's values, `(temperature, share)` each; NaN where the covariance is another curve's.
fn standard_error(shape: &Shape, covariance: &[Vec<f64>], shares: &[(f64, f64)]) -> f64 {
    let mut whole = vec![0.0; covariance.len()];
    for (temperature, share) in shares {
        let own = weights(shape, *temperature);
        if own.len() != whole.len() {
            return f64::NAN;
        }
        whole.iter_mut().zip(own).for_each(|(sum, weight)| *sum += share * weight);
    }
    let along = |row: &Vec<f64>| row.iter().zip(&whole).map(|(own, weight)| own * weight).sum::<f64>();
    covariance.iter().zip(&whole).map(|(row, weight)| weight * along(row)).sum::<f64>().max(0.0).sqrt()
}
