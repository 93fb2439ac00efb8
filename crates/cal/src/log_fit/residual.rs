//! Residuals and traces, gathered in one pass.

use zerorate_core::drift::{Drift, Shape};

use super::{Spread, TRACE_POINTS, TracePoint};
use crate::choose::Choice;

/// A running sum of squares and extremes.
#[derive(Debug, Clone, Copy)]
struct Running {
    count: u64,
    squares: f64,
    min: f64,
    max: f64,
}

impl Running {
    const EMPTY: Self = Self { count: 0, squares: 0.0, min: f64::INFINITY, max: f64::NEG_INFINITY };

    fn push(&mut self, residual: f64) {
        self.count += 1;
        self.squares += residual * residual;
        self.min = self.min.min(residual);
        self.max = self.max.max(residual);
    }

    fn spread(&self) -> Spread {
        Spread { rms: (self.squares / self.count as f64).sqrt(), pp: self.max - self.min }
    }
}

/// Sums for one trace point.
#[derive(Debug, Clone, Copy, Default)]
struct Bin {
    count: u64,
    sums: TracePoint,
}

/// The residuals of one axis, in-sample and held out, and its trace.
pub(crate) struct Residuals<'a> {
    curve: &'a Shape,
    without: Vec<Option<Shape>>,
    rows: u64,
    in_sample: Running,
    held_out: Running,
    /// Every stretch with rows had a fit of the others.
    complete: bool,
    bins: Vec<Bin>,
}

impl<'a> Residuals<'a> {
    /// For a record of `rows` rows or groups.
    pub(crate) fn new(choice: &Choice, drift: &'a Drift, rows: u64) -> Self {
        Self {
            curve: &drift.shape,
            without: choice.without.iter().map(|solution| solution.as_ref()?.shape()).collect(),
            rows,
            in_sample: Running::EMPTY,
            held_out: Running::EMPTY,
            complete: true,
            bins: vec![Bin::default(); rows.clamp(1, TRACE_POINTS) as usize],
        }
    }

    /// Takes in one row or group of a stretch.
    // A bin's number is below 2000.
    #[allow(clippy::cast_possible_truncation)]
    pub(crate) fn push(&mut self, row: u64, stretch: usize, time_s: f64, temperature: f64, rate: f64) {
        let residual = rate - evaluate(self.curve, temperature);
        self.in_sample.push(residual);
        match &self.without[stretch] {
            Some(shape) => self.held_out.push(rate - evaluate(shape, temperature)),
            None => self.complete = false,
        }
        let bins = self.bins.len() as u64;
        let place = (row * bins / self.rows.max(1)).min(bins - 1) as usize;
        self.bins[place].add(TracePoint { time_s, temperature, rate, residual });
    }

    /// In-sample, held out, trace.
    pub(crate) fn finish(self) -> (Spread, Spread, Vec<TracePoint>) {
        let held_out = if self.complete { self.held_out.spread() } else { Spread { rms: f64::NAN, pp: f64::NAN } };
        let trace = self.bins.iter().filter(|bin| bin.count > 0).map(Bin::mean).collect();
        (self.in_sample.spread(), held_out, trace)
    }
}

/// The curve at a temperature, not held at the ends of a valid range: a stretch may be the only one at its end.
fn evaluate(shape: &Shape, temperature: f64) -> f64 {
    match shape {
        Shape::Polynomial(polynomial) => polynomial.evaluate(temperature),
        Shape::Table(table) => table.evaluate(temperature),
    }
}

/// The trace of some groups, in order of time; one whose residual is NaN was not fitted, and is left out.
// A bin's number is below 2000.
#[allow(clippy::cast_possible_truncation)]
pub(crate) fn trace(groups: impl ExactSizeIterator<Item = TracePoint>) -> Vec<TracePoint> {
    let rows = groups.len() as u64;
    let mut bins = vec![Bin::default(); rows.clamp(1, TRACE_POINTS) as usize];
    let count = bins.len() as u64;
    for (row, point) in (0_u64..).zip(groups).filter(|(_, point)| point.residual.is_finite()) {
        bins[(row * count / rows.max(1)).min(count - 1) as usize].add(point);
    }
    bins.iter().filter(|bin| bin.count > 0).map(Bin::mean).collect()
}

impl Bin {
    fn add(&mut self, point: TracePoint) {
        self.count += 1;
        self.sums.time_s += point.time_s;
        self.sums.temperature += point.temperature;
        self.sums.rate += point.rate;
        self.sums.residual += point.residual;
    }

    fn mean(&self) -> TracePoint {
        let mean = |sum: f64| sum / self.count as f64;
        TracePoint {
            time_s: mean(self.sums.time_s),
            temperature: mean(self.sums.temperature),
            rate: mean(self.sums.rate),
            residual: mean(self.sums.residual),
        }
    }
}
