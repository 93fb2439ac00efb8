//! What was fitted, point by point: for figures, and for what is told of the whole.

use crate::robust::median;

/// Points in the trace of a fit of rows, at most: rows can be without number.
const BINS: u64 = 2000;

/// A group, or the mean over some successive rows of a fit of rows.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct TracePoint {
    /// Which uninterrupted log it belongs to, counted from 0: from one to the next the rate may jump. 0 in a fit of rows.
    pub log: u32,
    /// Seconds from the log's first row; NaN if not known.
    pub time_s: f64,
    /// In the temperature column's unit.
    pub temperature: f64,
    /// The first of its rows, and the one after the last; `None` where it is no group of rows, as in a fit of rows or of a bench's
    /// groups.
    pub rows: Option<(u64, u64)>,
    /// Rate less the steps taken out, in the rate column's unit.
    pub rate: f64,
    /// Rate less the fitted curve.
    pub residual: f64,
}

/// The groups that were fitted, each as it is: what is told of groups must not be told of means of them.
#[must_use]
pub fn of_groups(groups: impl Iterator<Item = TracePoint>) -> Vec<TracePoint> {
    groups.filter(|point| point.residual.is_finite()).collect()
}

/// The time from one point to the next, seconds, as a rule; `None` without times.
#[must_use]
pub fn period_s(trace: &[TracePoint]) -> Option<f64> {
    let mut steps: Vec<f64> = trace.windows(2).map(|pair| pair[1].time_s - pair[0].time_s).collect();
    Some(median(&mut steps)).filter(|period| period.is_finite())
}

/// A trace of rows on its way: successive rows gathered in equal bins.
#[derive(Debug, Clone)]
pub struct Trace {
    rows: u64,
    bins: Vec<(u64, TracePoint)>,
}

impl Trace {
    /// Of a record of so many rows.
    // At most 2000.
    #[must_use]
    #[allow(clippy::cast_possible_truncation)]
    pub fn new(rows: u64) -> Self {
        Self { rows, bins: vec![(0, TracePoint::default()); rows.clamp(1, BINS) as usize] }
    }

    /// Takes in a row of the record; one whose residual is NaN was not fitted, and is left out.
    // A bin's number is below 2000.
    #[allow(clippy::cast_possible_truncation)]
    pub fn push(&mut self, row: u64, point: &TracePoint) {
        if !point.residual.is_finite() {
            return;
        }
        let bins = self.bins.len() as u64;
        let (count, sums) = &mut self.bins[(row * bins / self.rows.max(1)).min(bins - 1) as usize];
        *count += 1;
        sums.time_s += point.time_s;
        sums.temperature += point.temperature;
        sums.rate += point.rate;
        sums.residual += point.residual;
    }

    /// The points, in order.
    #[must_use]
    pub fn finish(self) -> Vec<TracePoint> {
        let mean = |(count, sums): (u64, TracePoint)| {
            let mean = |sum: f64| sum / count as f64;
            TracePoint {
                log: 0,
                time_s: mean(sums.time_s),
                temperature: mean(sums.temperature),
                rows: None,
                rate: mean(sums.rate),
                residual: mean(sums.residual),
            }
        };
        self.bins.into_iter().filter(|(count, _)| *count > 0).map(mean).collect()
    }
}
