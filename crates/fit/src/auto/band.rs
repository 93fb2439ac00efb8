//! How far a prediction is from what is measured, over temperature.

use zerorate_core::drift::ValidRange;

use crate::drift_fit::BandPoint;
use crate::series::Series;

/// Points of the band.
const POINTS: usize = 17;

/// The spread of the window in which residuals are gathered about a point, as a share of the span: two points' distance.
const WINDOW: f64 = 1.0 / 8.0;

/// The share of groups that lie within the band.
const COVERED: f64 = 0.95;

/// The band from residuals, one a group (NaN for none): at each point the size that 95 of 100 of those nearby do not
/// exceed, nearness by a normal window. A quantile covers what it says whatever the residuals' distribution: a loop of
/// hysteresis has two values and no tails, a few jumps have tails and no width.
///
/// The residuals are held out, and of the model as it is deployed: they hold the model's error, the coefficients' and what
/// the zero drifts by in time, beside the noise.
pub(super) fn band(series: &Series<'_>, measured: ValidRange, residuals: &[f64]) -> Vec<BandPoint> {
    let span = measured.max() - measured.min();
    let mut sizes: Vec<(f64, f64)> =
        series.temperature.iter().zip(residuals).filter(|(_, r)| r.is_finite()).map(|(t, r)| (r.abs(), *t)).collect();
    sizes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let near = |from: f64, t: f64| (-0.5 * ((t - from) / (WINDOW * span)).powi(2)).exp();
    (0..POINTS)
        .filter_map(|point| {
            let temperature = measured.min() + span * point as f64 / (POINTS - 1) as f64;
            let whole: f64 = sizes.iter().map(|(_, t)| near(temperature, *t)).sum();
            let mut within = 0.0;
            let covers = |&&(_, t): &&(f64, f64)| {
                within += near(temperature, t);
                within >= COVERED * whole
            };
            sizes.iter().find(covers).map(|(half_width, _)| BandPoint { temperature, half_width: *half_width })
        })
        .collect()
}
