//! How the bias changes with temperature: a curve's mean slope and its steepest.

use serde::Serialize;
use zerorate_cal::log_fit::AxisFit;

/// Points at which a curve's slope is looked at.
const SLOPES: u32 = 400;

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

impl TemperatureSensitivity {
    pub(super) fn of(axis: &AxisFit) -> Self {
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
        Self { mean: products / squares, steepest: slope(steepest), steepest_at: at(steepest) + step / 2.0 }
    }
}
