//! What a fit is of: groups in order of time.

use std::ops::Range;

use zerorate_core::drift::ValidRange;

use crate::direction::go_both_ways;
use crate::folds::Fold;

/// What the run after this one will be like: what a calibration is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NextRun {
    /// The same ramp again, as on the bench: the same temperatures. Nothing that belongs to time is told, for a board has no
    /// term that would take it off.
    Same,
    /// One of its own, as a flight's: it may begin a little colder or end a little warmer, and what drifts in time is this
    /// log's alone.
    Another,
}

/// Groups of one rate column, in order of time: one entry of each slice a group.
#[derive(Debug, Clone, Copy)]
pub struct Series<'a> {
    /// Seconds from the recording's first row; NaN without a time column.
    pub time_s: &'a [f64],
    /// Mean temperature; NaN for a group without one.
    pub temperature: &'a [f64],
    /// The same as the sensor showed it, and so as a device goes by it: another where the steps of a coarse one were interpolated.
    pub shown: &'a [f64],
    /// Mean rate; NaN for a group that is not to be fitted: the history runs through its temperature all the same.
    pub rate: &'a [f64],
    /// How much a group counts against the others, above zero; 1 for all where nothing says otherwise.
    pub weight: &'a [f64],
    /// Which uninterrupted log it belongs to: the history begins anew with each.
    pub log: &'a [u32],
    /// What the fit is for.
    pub next: NextRun,
}

impl Series<'_> {
    /// Whether a group is to be fitted.
    #[must_use]
    pub fn is_used(&self, group: usize) -> bool {
        self.rate[group].is_finite() && self.temperature[group].is_finite() && self.weight[group] > 0.0
    }

    /// The temperatures that a next run will see as well, for all that is known: those that had a rate, `measured`, and those that
    /// had none, where a curve is believed. A sensor whose rates are gone may show anything: what is across a hole is not counted.
    pub(crate) fn seen(&self, measured: ValidRange, valid: ValidRange) -> ValidRange {
        /// A hole, as a share of what was measured: an interval of a table.
        const HOLE: f64 = 1.0 / 32.0;
        let hole = HOLE * (measured.max() - measured.min());
        let mut finite: Vec<f64> = self.temperature.iter().copied().filter(|t| t.is_finite()).collect();
        finite.sort_by(f64::total_cmp);
        let further = |end: f64, t: &f64| if (t - end).abs() <= hole { *t } else { end };
        let max = finite.iter().filter(|t| **t > measured.max()).fold(measured.max(), further);
        let min = finite.iter().rev().filter(|t| **t < measured.min()).fold(measured.min(), further);
        ValidRange::new(min.max(valid.min()), max.min(valid.max())).unwrap_or(measured)
    }

    /// Whether a straight drift in time can be told from the rest: in one log, whose temperature goes both ways. Between logs a
    /// rate may jump for reasons of its own.
    pub(crate) fn tells_slope(&self) -> bool {
        let timed = self.time_s.iter().all(|time| time.is_finite());
        timed && self.next == NextRun::Another && self.logs().len() == 1 && self.goes_both_ways()
    }

    /// Whether enough is seen of either way of the temperature for what remembers it to be told from the curve.
    pub(crate) fn goes_both_ways(&self) -> bool {
        go_both_ways(&self.logs().into_iter().map(|log| &self.temperature[log]).collect::<Vec<_>>())
    }

    /// The groups of each log.
    #[must_use]
    pub fn logs(&self) -> Vec<Range<usize>> {
        let begins: Vec<usize> = (0..self.rate.len()).filter(|&group| self.begins(group)).collect();
        let ends = begins.iter().skip(1).copied().chain([self.rate.len()]);
        begins.iter().copied().zip(ends).map(|(begin, end)| begin..end).collect()
    }

    /// The groups of each fold.
    pub(crate) fn folds(&self) -> Vec<Fold> {
        Fold::of_logs(&self.logs())
    }

    /// Whether a group is the first of its log.
    #[must_use]
    pub fn begins(&self, group: usize) -> bool {
        group == 0 || self.log[group] != self.log[group - 1]
    }
}
