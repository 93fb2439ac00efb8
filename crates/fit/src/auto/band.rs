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

/// The band from residuals, one of each group (NaN for none), of any number of predictions. Its shape is their root
/// mean square nearby, by a normal window; its size is what 95 of 100 of them do not exceed (normalised conformal
/// prediction: Papadopoulos et al. 2008; Lei et al. 2018), whatever their distribution: a loop of hysteresis has two
/// values and no tails, a few jumps have tails and no width. They hold what the model's error and the zero's drift in
/// time are in them, beside the noise.
pub(super) fn band(series: &Series<'_>, measured: ValidRange, residuals: &[&[f64]]) -> Vec<BandPoint> {
    let span = measured.max() - measured.min();
    let known: Vec<Residual> = residuals.iter().flat_map(|residuals| known(series, residuals)).collect();
    let nearby = |temperature: f64| {
        let near = |own: &Residual| libm::exp(-0.5 * ((own.temperature - temperature) / (WINDOW * span)).powi(2));
        let (squares, weights) = known
            .iter()
            .fold((0.0, 0.0), |(squares, weights), own| (squares + near(own) * own.size.powi(2), weights + near(own)));
        (squares / weights).sqrt()
    };
    let points: Vec<BandPoint> = (0..POINTS)
        .map(|point| measured.min() + span * point as f64 / (POINTS - 1) as f64)
        .map(|temperature| BandPoint { temperature, half_width: nearby(temperature) })
        .collect();
    let mut ratios: Vec<f64> =
        known.iter().map(|own| own.size / BandPoint::half_width_at(&points, own.temperature)).collect();
    ratios.sort_by(f64::total_cmp);
    let covered = COVERED * ratios.len() as f64;
    let factor =
        ratios.iter().zip(1_u32..).find(|(_, count)| f64::from(*count) >= covered).map_or(f64::NAN, |own| *own.0);
    let sized = points.into_iter().map(|point| BandPoint { half_width: factor * point.half_width, ..point });
    sized.filter(|point| point.half_width.is_finite()).collect()
}

struct Residual {
    size: f64,
    temperature: f64,
}

/// The residuals that are one, of all groups.
fn known(series: &Series<'_>, residuals: &[f64]) -> impl Iterator<Item = Residual> {
    let all = series.temperature.iter().zip(residuals).filter(|(_, residual)| residual.is_finite());
    all.map(|(&temperature, residual)| Residual { size: residual.abs(), temperature })
}
