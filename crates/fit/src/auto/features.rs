//! The columns that candidates are made of, one row a group.

use zerorate_core::drift::{
    Drift, History, HistoryState, MAX_ORDER, Memory, Polynomial, Scale, Shape, Term, ValidRange,
};

use crate::series::Series;

/// Half-widths of the plays as shares of the span of temperature, a factor of four apart. The smallest still stands
/// clear of a sensor's noise and of steps of one degree on a span of 40; the largest is known after four fifths of the
/// span: a wider one would never be known in a recording of this span.
pub(super) const PLAY_SHARES: [f64; 3] = [1.0 / 40.0, 1.0 / 10.0, 1.0 / 2.5];

/// Time constants of the lags, seconds, a factor of four apart: a package against its board, a board in its box, a box in
/// its room. A group of 10 s still resolves the first.
pub(super) const LAG_SECONDS: [f64; 3] = [60.0, 240.0, 960.0];

/// The intervals of the table among the candidates of `auto`.
pub(super) const TABLE_INTERVALS: usize = 16;

/// Both directions must travel this share of the span for a history, or a drift in time, to be told from the curve.
const TRAVEL: f64 = 1.0 / 3.0;

/// A turn smaller than this share of the span is noise.
const TURN: f64 = 0.05;

/// The columns, all of the order of one: powers as Legendre polynomials, the knots of a table, plays over their half-width,
/// lags over half the span, time from -1 to 1 over the recording.
#[derive(Debug, Clone)]
pub(super) struct Features {
    pub scale: Scale,
    /// The least and greatest temperature that has a rate.
    pub measured: ValidRange,
    /// The temperatures over which a polynomial of these columns may be believed.
    pub valid: ValidRange,
    pub intervals: usize,
    /// Plays then lags; none where the recording does not hold both directions.
    pub memories: Vec<Memory>,
    /// Time at -1 and at 1, seconds; `None` where there is no drift in time to be told.
    pub time: Option<(f64, f64)>,
    pub columns: usize,
    /// Row-major.
    pub rows: Vec<f64>,
}

impl Features {
    /// The columns of a series whose used rates span `measured`. `beyond` is how far past it the curve may be believed,
    /// a share of the span at each end.
    pub(super) fn new(series: &Series<'_>, measured: ValidRange, beyond: f64, intervals: usize) -> Option<Self> {
        let valid = measured;
        let scale = Scale::spanning(valid.min(), valid.max())?;
        let both = holds_both_directions(series.temperature, valid);
        let timed = series.time_s.iter().all(|time| time.is_finite());
        // Between logs a rate may jump for reasons of its own.
        let one_log = series.log.first() == series.log.last();
        let span = valid.max() - valid.min();
        let mut memories = Vec::new();
        if both {
            memories.extend(PLAY_SHARES.map(|share| Memory::Play { half_width: share * span }));
        }
        let ends = series.time_s.first().copied().zip(series.time_s.last().copied()).filter(|_| timed);
        let time = ends.filter(|(first, last)| both && one_log && series.drifts_in_time && last > first);
        if both && timed {
            memories.extend(LAG_SECONDS.map(|time_constant_s| Memory::Lag { time_constant_s }));
        }
        let columns = MAX_ORDER + 1 + intervals + 1 + memories.len() + 1;
        let valid = ValidRange::new(measured.min() - beyond * span, measured.max() + beyond * span)?;
        let mut features = Self { scale, measured, valid, intervals, memories, time, columns, rows: Vec::new() };
        features.fill(series);
        Some(features)
    }

    /// The column of a Legendre polynomial, of a knot, of a memory, of time.
    pub(super) fn power(order: usize) -> usize {
        order
    }

    pub(super) fn knot(node: usize) -> usize {
        MAX_ORDER + 1 + node
    }

    pub(super) fn memory(&self, place: usize) -> usize {
        MAX_ORDER + 2 + self.intervals + place
    }

    pub(super) fn time_column(&self) -> usize {
        self.columns - 1
    }

    pub(super) fn row(&self, group: usize) -> &[f64] {
        &self.rows[group * self.columns..(group + 1) * self.columns]
    }

    /// What a memory's `m - T` is divided by.
    pub(super) fn amplitude(&self, memory: Memory) -> f64 {
        match memory {
            Memory::Play { half_width } => half_width,
            Memory::Lag { .. } => self.scale.half_span(),
        }
    }

    fn fill(&mut self, series: &Series<'_>) {
        // A history whose weights are all nothing, for its memories alone.
        let shares = 1.0 / self.memories.len() as f64;
        let terms: Vec<Term> =
            self.memories.iter().map(|&memory| Term { memory, weight: 0.0, share: shares }).collect();
        let flat = Polynomial::new(self.scale, &[0.0, 0.0]).map(Shape::Polynomial);
        let history = flat.clone().and_then(|shape| History::new(shape, &terms));
        let drift = flat.map(|shape| Drift { shape, valid: self.valid });
        let mut state = HistoryState::default();
        let mut before = f64::NAN;
        let mut rows = Vec::with_capacity(series.temperature.len() * self.columns);
        for (group, (&time, &temperature)) in series.time_s.iter().zip(series.temperature).enumerate() {
            if series.begins(group) {
                state = HistoryState::default();
            }
            let held = temperature.clamp(self.valid.min(), self.valid.max());
            let x = self.scale.x(held);
            rows.extend(legendre(x));
            // A table is held at its end knots.
            let place = 0.5 * (x.clamp(-1.0, 1.0) + 1.0) * self.intervals as f64;
            rows.extend((0..=self.intervals).map(|node| (1.0 - (place - node as f64).abs()).max(0.0)));
            if let Some((history, drift)) = history.as_ref().zip(drift.as_ref()) {
                history.advance(drift, &mut state, temperature, time - before);
                let ahead = history.ahead(&state);
                rows.extend(self.memories.iter().zip(ahead).map(|(&m, ahead)| ahead / self.amplitude(m)));
            }
            before = time;
            let along = self.time.map_or(0.0, |(first, last)| 2.0 * (time - first) / (last - first) - 1.0);
            rows.push(along);
        }
        self.rows = rows;
    }
}

/// P0 to P5 at x.
pub(super) fn legendre(x: f64) -> [f64; MAX_ORDER + 1] {
    let mut p = [1.0; MAX_ORDER + 1];
    p[1] = x;
    for n in 1..MAX_ORDER {
        let k = n as f64;
        p[n + 1] = ((2.0 * k + 1.0) * x * p[n] - k * p[n - 1]) / (k + 1.0);
    }
    p
}

/// The coefficients of 1, x, x^2, ... of a sum of Legendre polynomials.
pub(super) fn powers_of_legendre(weights: &[f64]) -> Vec<f64> {
    // The coefficients of P0 to P5, by the recurrence of `legendre`.
    let mut p = vec![vec![0.0; MAX_ORDER + 1]; MAX_ORDER + 1];
    (p[0][0], p[1][1]) = (1.0, 1.0);
    for n in 1..MAX_ORDER {
        let k = n as f64;
        for power in 0..=MAX_ORDER {
            let raised = if power > 0 { p[n][power - 1] } else { 0.0 };
            p[n + 1][power] = ((2.0 * k + 1.0) * raised - k * p[n - 1][power]) / (k + 1.0);
        }
    }
    (0..weights.len()).map(|power| weights.iter().zip(&p).map(|(weight, p)| weight * p[power]).sum()).collect()
}

/// Whether the temperature goes up and down by a third of its span or more, turns of noise not counted.
fn holds_both_directions(temperature: &[f64], valid: ValidRange) -> bool {
    let span = valid.max() - valid.min();
    let margin = TURN * span;
    let (mut up, mut down) = (0.0, 0.0);
    let mut finite = temperature.iter().copied().filter(|t| t.is_finite());
    let Some(mut follower) = finite.next() else { return false };
    for t in finite {
        let next = follower.clamp(t - margin, t + margin);
        if next > follower {
            up += next - follower
        } else {
            down += follower - next
        }
        follower = next;
    }
    up.min(down) >= TRAVEL * span
}
