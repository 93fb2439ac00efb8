//! What a drift is made of, a column each: a curve by its knots, memories, and what belongs to one recording alone.

use std::ops::Range;

use nalgebra::DMatrix;
use zerorate_core::drift::{MAX_KNOTS, Memory, Scale, Shape, ValidRange};

use super::memories::Memories;
use super::start_up::{self, START_SECONDS};
use crate::series::{NextRun, Series};

/// The intervals of the curve's table: as many as a device holds.
const INTERVALS: usize = MAX_KNOTS - 1;

/// What a drift in time comes to at last, of a log that goes both ways.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Slow {
    /// It dies away with the longest time constant.
    Dying,
    /// It goes on as a straight line, with a spread of its own.
    Straight,
}

/// What a column belongs to. Columns of a kind have one spread.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// Level and slope: whatever the data say.
    Free,
    /// The curve's second and third order.
    Powers,
    /// The bends of the curve at its knots.
    Bends,
    Plays,
    Lags,
    /// The parts of what drifts that are where the lags are.
    Behind,
    /// What follows switching on.
    Start,
    /// A slow drift in time.
    Time,
    /// The offsets of several logs.
    Logs,
}

/// A curve that was found before, and the spread of the rates that it was found of: what a part that is behind would add is
/// told by it.
#[derive(Debug, Clone)]
pub(super) struct Before {
    pub curve: Shape,
    pub spread: f64,
}

impl Before {
    /// What a part that is wholly behind adds, `ahead` being the memory's `m - T`.
    fn adds(&self, temperature: f64, ahead: f64) -> f64 {
        (self.curve.evaluate(temperature + ahead) - self.curve.evaluate(temperature)) / self.spread
    }
}

/// The columns of a series, all of the order of one: the curve's first, then the memories' and of the parts that are behind,
/// then the recording's own.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    /// The temperatures of the curve's knots.
    pub table: Scale,
    pub measured: ValidRange,
    /// The temperatures that a static curve is for.
    pub seen: ValidRange,
    /// What each column of the curve is at each knot.
    pub shapes: DMatrix<f64>,
    pub memories: Vec<Memory>,
    /// The curve by which parts are told that are behind; `None` where none are looked for.
    pub before: Option<Before>,
    /// The middle of a log, seconds from its start: what follows switching on is told from there.
    pub middle_s: f64,
    /// A column each.
    pub kinds: Vec<Kind>,
    /// A column of the matrix a group.
    pub rows: DMatrix<f64>,
}

impl Columns {
    /// The columns of a series whose used rates span `measured`; the table's knots span `valid`; of the `memories` that can be
    /// told of it. With a curve that was found `before`, parts that are behind are looked for. `None` with a straight drift in time where none can be told.
    pub(super) fn new(
        series: &Series<'_>,
        measured: ValidRange,
        valid: ValidRange,
        memories: &Memories,
        slow: Slow,
        before: Option<Before>,
    ) -> Option<Self> {
        let straight = slow == Slow::Straight;
        if straight && !series.tells_slope() {
            return None;
        }
        let scale = Scale::spanning(measured.min(), measured.max())?;
        let table = Scale::spanning(valid.min(), valid.max())?;
        let (shapes, bends) = curve(scale, table);
        let mut kinds = vec![Kind::Free, Kind::Free, Kind::Powers, Kind::Powers];
        kinds.extend(vec![Kind::Bends; bends]);
        let timed = series.time_s.iter().all(|time| time.is_finite());
        let both = series.goes_both_ways();
        kinds.extend(memories.which.iter().map(|memory| Kind::of(*memory)));
        let lags = kinds.iter().filter(|kind| **kind == Kind::Lags).count();
        let before = before.filter(|_| lags > 0);
        kinds.extend(vec![Kind::Behind; if before.is_some() { lags } else { 0 }]);
        let starts = START_SECONDS.len() - usize::from(straight);
        kinds.extend(vec![Kind::Start; if both && timed && series.next == NextRun::Another { starts } else { 0 }]);
        kinds.extend(straight.then_some(Kind::Time));
        let logs = series.logs().len();
        kinds.extend(vec![Kind::Logs; if logs > 1 { logs } else { 0 }]);
        let rows = DMatrix::zeros(kinds.len(), series.rate.len());
        let (middle_s, which) = (middle(series), memories.which.clone());
        let seen = series.seen(measured, valid);
        let mut columns = Self { table, measured, seen, shapes, memories: which, before, middle_s, kinds, rows };
        columns.fill(series, &memories.ahead);
        Some(columns)
    }

    /// How many columns the curve has.
    pub(super) fn curve(&self) -> usize {
        self.shapes.ncols()
    }

    /// Whether there are lags to be told.
    pub(super) fn has_lags(&self) -> bool {
        self.count(Kind::Lags) > 0
    }

    /// The columns of a memory: what it adds, and how much is behind with it where that is looked for.
    pub(super) fn of_memory(&self, memory: usize) -> (usize, Option<usize>) {
        let behind = self.kinds.iter().position(|kind| *kind == Kind::Behind);
        let lag = memory.checked_sub(self.count(Kind::Plays));
        (self.curve() + memory, behind.zip(lag).map(|(first, lag)| first + lag))
    }

    /// How many columns are of a kind.
    fn count(&self, kind: Kind) -> usize {
        self.kinds.iter().filter(|own| **own == kind).count()
    }

    /// What a memory's `m - T` is divided by.
    pub(super) fn amplitude(&self) -> f64 {
        0.5 * (self.measured.max() - self.measured.min())
    }

    /// Fills the rows; `ahead` is each memory's `m - T`.
    fn fill(&mut self, series: &Series<'_>, ahead: &DMatrix<f64>) {
        let (starts, logs) = (self.count(Kind::Start), self.count(Kind::Logs));
        let is_straight = self.count(Kind::Time) > 0;
        let in_the_middle = start_up::left(self.middle_s);
        let (mut began, mut log) = (f64::NAN, 0);
        for (group, (&time, &temperature)) in series.time_s.iter().zip(series.temperature).enumerate() {
            if series.begins(group) {
                (began, log) = (time, log + 1);
            }
            let mut values = self.curve_at(temperature);
            let ahead: Vec<f64> = ahead.column(group).iter().copied().collect();
            values.extend(ahead.iter().map(|ahead| ahead / self.amplitude()));
            let lags = &ahead[self.count(Kind::Plays)..];
            let wholly_behind = |known: &Before| lags.iter().map(|&ahead| known.adds(temperature, ahead)).collect();
            values.extend(self.before.as_ref().map_or_else(Vec::new, wholly_behind));
            let left = start_up::left(time - began);
            values.extend(left.iter().zip(in_the_middle).map(|(left, middle)| left - middle).take(starts));
            let along = (time - began) / self.middle_s - 1.0;
            values.extend(is_straight.then_some(along));
            values.extend((1..=logs).map(|own| f64::from(u8::from(own == log))));
            self.rows.column_mut(group).copy_from_slice(&values);
        }
    }

    /// The curve's columns at a temperature: on the straight line between two knots, as a device has it.
    fn curve_at(&self, temperature: f64) -> Vec<f64> {
        let place = 0.5 * (self.table.x(temperature).clamp(-1.0, 1.0) + 1.0) * INTERVALS as f64;
        if place.is_nan() {
            return vec![0.0; self.curve()];
        }
        // A place between 0 and the number of intervals.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let knot = (place as usize).min(INTERVALS - 1);
        let past = place - knot as f64;
        let value = |column| self.shapes[(knot, column)] * (1.0 - past) + self.shapes[(knot + 1, column)] * past;
        (0..self.curve()).map(value).collect()
    }
}

impl Kind {
    fn of(memory: Memory) -> Self {
        match memory {
            Memory::Play { .. } => Self::Plays,
            Memory::Lag { .. } => Self::Lags,
        }
    }
}

/// The middle of a log, of several on average, seconds from its start.
fn middle(series: &Series<'_>) -> f64 {
    let logs = series.logs();
    let length = |log: &Range<usize>| series.time_s[log.end - 1] - series.time_s[log.start];
    0.5 * logs.iter().map(length).sum::<f64>() / logs.len() as f64
}

/// The curve's columns at the knots of `table`, and how many of them are bends: level, slope, second and third order of
/// what was measured, continued along their tangents, and a bend at every knot inside of it.
fn curve(measured: Scale, table: Scale) -> (DMatrix<f64>, usize) {
    let at = |knot: usize| measured.x(table.temperature(2.0 * knot as f64 / INTERVALS as f64 - 1.0));
    let knots: Vec<f64> = (0..=INTERVALS).map(at).collect();
    let inner: Vec<f64> = knots.iter().copied().filter(|knot| knot.abs() < 1.0).collect();
    let shapes = DMatrix::from_fn(knots.len(), 4 + inner.len(), |knot, column| match column {
        0 => 1.0,
        1 => knots[knot],
        2 | 3 => continued(column, knots[knot]),
        bend => bent(knots[knot], inner[bend - 4]),
    });
    (shapes, inner.len())
}

/// A Legendre polynomial between -1 and 1, and its tangents beyond, smaller the higher its order.
fn continued(order: usize, x: f64) -> f64 {
    let inside = x.clamp(-1.0, 1.0);
    let (value, slope) = match order {
        2 => (1.5 * inside * inside - 0.5, 3.0 * inside),
        _ => (2.5 * inside.powi(3) - 1.5 * inside, 7.5 * inside * inside - 1.5),
    };
    (value + slope * (x - inside)) / libm::pow(order as f64, 1.5)
}

/// A line that is bent at a knot, and nothing at either end of what was measured.
fn bent(x: f64, knot: f64) -> f64 {
    (x - knot).max(0.0) - (x + 1.0) * (1.0 - knot) / 2.0
}
