//! The time of a table's rows: from what is written to seconds from the first row, one way for all who read a table.

use zerorate_fit::spacing::Spacing;

use super::counter::Counter;
use crate::units::TimeUnit;

/// A time between rows below this is none that makes averages shorter: a group lasts 10 s.
const LEAST_GAP_S: f64 = 15.0;

/// A column of times that was read through.
#[derive(Debug)]
pub struct Clock {
    /// The first finite time, in the column's own unit; NaN without one.
    first: f64,
    last: f64,
    counter: Counter,
    /// How far apart the times are.
    spacing: Spacing,
    /// Seconds in one unit; NaN if not known.
    unit_s: f64,
}

impl Default for Clock {
    fn default() -> Self {
        let (counter, spacing) = (Counter::default(), Spacing::default());
        Self { first: f64::NAN, last: f64::NAN, counter, spacing, unit_s: f64::NAN }
    }
}

impl Clock {
    /// Takes in the next finite time as it is written. Refuses one that runs backwards, with the time before.
    pub(super) fn take(&mut self, written: f64) -> Result<(), f64> {
        let time = self.counter.goes_on(written);
        if time < self.last {
            return Err(self.last);
        }
        if self.first.is_nan() {
            self.first = time;
        }
        self.last = time;
        self.spacing.push(time);
        Ok(())
    }

    /// Settles the unit: the one that is `known`, or else the one that the length tells; gives that.
    pub(super) fn settle(&mut self, known: Option<TimeUnit>) -> Option<TimeUnit> {
        let by_length = TimeUnit::by_duration(self.lasts_without_gaps(0.0));
        self.unit_s = known.or(by_length).map_or(f64::NAN, TimeUnit::seconds);
        by_length
    }

    pub(super) fn has_numbers(&self) -> bool {
        !self.first.is_nan()
    }

    pub(super) fn moves(&self) -> bool {
        self.last > self.first
    }

    pub(super) fn was_full(&self) -> bool {
        self.counter.was_full()
    }

    /// The first time, microseconds from where the column counts.
    pub(super) fn first_us(&self) -> f64 {
        self.first * self.unit_s * 1e6
    }

    /// The mean time between so many rows but for the gaps, seconds; NaN if not known: what a log does not have makes its
    /// averages no shorter.
    pub(super) fn step_s(&self, rows: u64) -> f64 {
        let least = LEAST_GAP_S / self.unit_s;
        let (gaps, _) = self.spacing.gaps(least);
        self.lasts_without_gaps(least) * self.unit_s / (rows.max(2 + gaps) - 1 - gaps) as f64
    }

    /// How long the log lasts in the column's own unit, less its gaps of so much at least.
    pub(super) fn lasts_without_gaps(&self, least: f64) -> f64 {
        self.last - self.first - self.spacing.gaps(least).1
    }

    /// Whether times are known in seconds.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.unit_s.is_finite()
    }

    /// The rows once more, from the first.
    #[must_use]
    pub fn again(&self) -> Ticks<'_> {
        Ticks { clock: self, counter: Counter::default() }
    }
}

/// A clock's times, row after row.
#[derive(Debug)]
pub struct Ticks<'a> {
    clock: &'a Clock,
    counter: Counter,
}

impl Ticks<'_> {
    /// The next time as it is written, in seconds from the first row; NaN if not known, as of an infinite one.
    pub fn seconds(&mut self, written: f64) -> f64 {
        let time = self.counter.goes_on(written);
        if time.is_finite() { (time - self.clock.first) * self.clock.unit_s } else { f64::NAN }
    }
}
