//! How far a prediction is from what is measured, over temperature.

use zerorate_core::drift::ValidRange;

use crate::drift_fit::BandPoint;
use crate::series::Series;

/// Points of the band.
const POINTS: usize = 17;

/// The spread of the window in which residuals are gathered about a point, as a share of the span: two points' distance.
const WINDOW: f64 = 1.0 / 8.0;

/// 95 of 100 values of a normal distribution lie within this many standard deviations.
const COVERS_95: f64 = 1.96;

/// The band from residuals, one a group (NaN for none): at each point their root mean square nearby, by a normal window,
/// times 1.96. Held-out residuals hold the model's error and the coefficients' as well as the noise.
pub(super) fn band(series: &Series<'_>, valid: ValidRange, residuals: &[f64]) -> Vec<BandPoint> {
    let span = valid.max() - valid.min();
    (0..POINTS)
        .filter_map(|point| {
            let temperature = valid.min() + span * point as f64 / (POINTS - 1) as f64;
            let (mut squares, mut weights) = (0.0, 0.0);
            for (t, residual) in series.temperature.iter().zip(residuals).filter(|(_, r)| r.is_finite()) {
                let weight = (-0.5 * ((t - temperature) / (WINDOW * span)).powi(2)).exp();
                squares += weight * residual * residual;
                weights += weight;
            }
            let half_width = COVERS_95 * (squares / weights).sqrt();
            half_width.is_finite().then_some(BandPoint { temperature, half_width })
        })
        .collect()
}
