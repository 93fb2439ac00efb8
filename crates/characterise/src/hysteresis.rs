//! Heating less cooling at equal temperature.

use serde::Serialize;
use zerorate_cal::trace::TracePoint;

use super::span;

/// Bins of temperature in which the two directions are compared.
const BINS: usize = 40;

/// Bins that both directions must have, at least, for a hysteresis.
const LEAST_BINS: usize = 5;

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

impl Hysteresis {
    /// The two directions, bin by bin.
    pub(super) fn of(points: &[TracePoint], warming: &[bool], pp: f64) -> Result<Self, String> {
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
        Ok(Self {
            largest,
            at: min + (max - min) * (bin as f64 + 0.5) / BINS as f64,
            rms: (both.iter().map(|(_, difference)| difference * difference).sum::<f64>() / both.len() as f64).sqrt(),
            share: largest.abs() / pp,
        })
    }
}
