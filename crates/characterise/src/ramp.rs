//! What is left in proportion to the speed of the temperature.

use serde::Serialize;
use zerorate_fit::folds::{FOLDS, fold_of_row, jackknife_error};
use zerorate_fit::trace::TracePoint;

use super::span;

/// The ramp's speed must vary by this part of its size at equal temperature and direction: otherwise what it does cannot be
/// told from the curve or from hysteresis.
const LEAST_VARIATION: f64 = 0.2;

/// Bias temperature-ramp sensitivity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RampSensitivity {
    /// Rate for a degree a second.
    pub value: f64,
    /// Its standard error, by leaving out one fold of the log at a time (jackknife).
    pub standard_error: f64,
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

impl RampSensitivity {
    /// The residual against the speed of the temperature, beside a cubic of temperature for each direction: what the curve may have
    /// taken, and a hysteresis, which is another at each temperature. In equal cycles that goes with the speed as well.
    pub(super) fn of(points: &[TracePoint], warming: &[bool]) -> Result<Self, String> {
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
                "at each temperature it changed at one speed in each direction; let it change fast and slowly over the same range, the same way"
                    .to_owned(),
            );
        }
        let without: Vec<f64> = (0..FOLDS).map(|fold| regression(&rows, Some(fold)).0).collect();
        Ok(Self { value, standard_error: jackknife_error(&without) })
    }
}

/// The slope of residual over speed beside the other terms, and how much of the speed these do not explain, root mean
/// square: by making each term orthogonal to those before it, the speed last.
fn regression(rows: &[Ramp], without: Option<usize>) -> (f64, f64) {
    let kept: Vec<&Ramp> = (0..rows.len())
        .filter(|i| without != Some(fold_of_row(*i as u64, rows.len() as u64)))
        .map(|i| &rows[i])
        .collect();
    let of_direction =
        |warming: bool, power: i32| move |row: &Ramp| if row.warming == warming { row.x.powi(power) } else { 0.0 };
    let curves = [true, false].into_iter().flat_map(|warming| (0..=3).map(move |power| of_direction(warming, power)));
    let columns = curves.map(|term| kept.iter().map(|row| term(row)).collect::<Vec<f64>>());
    let speed = kept.iter().map(|row| row.speed).collect::<Vec<f64>>();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut before: Vec<Vec<f64>> = Vec::new();
    for mut column in columns.chain([speed]) {
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
