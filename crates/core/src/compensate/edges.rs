//! The static law as a table of edges: the temperatures at which the tap changes, solved for by the host.
//!
//! Over the temperature codes the nearest tap is constant on intervals. The table holds them in order, each with its
//! tap and the two codes up to which a dead band holds on to it. An update is a compare with the two edges of the
//! present interval; only when the temperature has left them is the table searched. Since the interval, and not only
//! the tap, is the state, a drift that turns round and comes back to a tap needs no special case.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use super::law::StaticLaw;
use crate::units::{Taps, TemperatureCode};

/// The most intervals a table holds: at 31 counts a tap, 2000 counts of drift one way, or 1000 up and down again.
pub const MAX_INTERVALS: usize = 64;

/// A run of temperature codes with one nearest tap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Interval {
    /// The first code whose nearest tap this is; the interval ends before the next one's first.
    pub first: u16,
    /// Going colder from this interval, the last code at which the dead band still holds the tap.
    pub hold_down_to: u16,
    /// Going hotter from this interval, the last code at which the dead band still holds the tap.
    pub hold_up_to: u16,
    /// The tap.
    pub tap: Taps,
}

/// Every temperature code's tap, and how long a dead band holds it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct EdgeTable {
    intervals: Vec<Interval, MAX_INTERVALS>,
}

/// Why a law cannot be a table of edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EdgeError {
    /// At this code the law asks for a position (in taps) that the part does not have.
    OutOfTaps {
        /// The temperature code.
        code: TemperatureCode,
        /// The position asked for, taps; the part has 0 to 1023.
        position: f64,
    },
    /// The drift crosses more taps than the table holds.
    TooManyIntervals {
        /// The code at which the table was full.
        code: TemperatureCode,
    },
    /// The stored table does not say what the stored law says at this code.
    Disagrees {
        /// The temperature code.
        code: TemperatureCode,
    },
    /// The stored table is not in order: empty, not starting at code 0, not ascending, or holding less than itself.
    Malformed {
        /// The interval that is wrong.
        index: usize,
    },
}

impl core::fmt::Display for EdgeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::OutOfTaps { code, position } => write!(
                f,
                "at temperature code {} the law asks for tap {position:.1}; the part has 0 to 1023: the drift is larger than the trim can take",
                code.0
            ),
            Self::TooManyIntervals { code } => write!(
                f,
                "the drift crosses more than {MAX_INTERVALS} taps (the table was full at temperature code {}): use mode digital, or a coarser trim",
                code.0
            ),
            Self::Disagrees { code } => {
                write!(f, "the table of edges and the law disagree at temperature code {}", code.0)
            }
            Self::Malformed { index } => {
                write!(f, "the table of edges is out of order at interval {index}")
            }
        }
    }
}

impl core::error::Error for EdgeError {}

impl EdgeTable {
    /// Solves a law for its edges, piece by monotone piece.
    ///
    /// # Errors
    /// [`EdgeError::OutOfTaps`] and [`EdgeError::TooManyIntervals`], when the law cannot be tabled.
    pub fn solve(law: &StaticLaw) -> Result<Self, EdgeError> {
        let pieces = Pieces::of(law);
        let mut intervals: Vec<Interval, MAX_INTERVALS> = Vec::new();
        for (first, last) in pieces.iter() {
            let mut code = first;
            loop {
                let tap = tap_at(law, code)?;
                if intervals.last().is_none_or(|before| before.tap != tap) {
                    let interval = Interval { first: code, hold_down_to: code, hold_up_to: code, tap };
                    intervals
                        .push(interval)
                        .map_err(|_| EdgeError::TooManyIntervals { code: TemperatureCode(code) })?;
                }
                let changed = |c: u16| law.tap(TemperatureCode(c)) != Some(tap);
                match first_where(code, last, changed) {
                    Some(next) => code = next,
                    None => break,
                }
            }
        }
        for index in 0..intervals.len() {
            let Interval { first, tap, .. } = intervals[index];
            let last = intervals.get(index + 1).map_or(u16::MAX, |next| next.first - 1);
            intervals[index].hold_up_to = pieces.hold_up(law, tap, last);
            intervals[index].hold_down_to = pieces.hold_down(law, tap, first);
        }
        Ok(Self { intervals })
    }

    /// The intervals, coldest first.
    #[must_use]
    pub fn intervals(&self) -> &[Interval] {
        &self.intervals
    }

    /// The index of the interval that a code lies in, whatever came before.
    #[cold]
    #[inline(never)]
    #[must_use]
    pub fn find(&self, code: TemperatureCode) -> usize {
        self.intervals.partition_point(|interval| interval.first <= code.0).saturating_sub(1)
    }

    /// The interval after a group at a temperature code, from the one before it: two compares unless an edge was
    /// crossed.
    #[must_use]
    pub fn next(&self, index: usize, code: TemperatureCode) -> usize {
        match self.intervals.get(index) {
            Some(now) if now.hold_down_to <= code.0 && code.0 <= now.hold_up_to => index,
            _ => self.find(code),
        }
    }

    /// The neighbour of an interval that a code lies in, if it lies in one: the code is known not to be held by the
    /// interval itself.
    #[inline]
    pub(super) fn neighbour(&self, index: usize, code: TemperatureCode) -> Option<(usize, &Interval)> {
        let all = self.intervals();
        let is_hotter = all.get(index)?.first <= code.0;
        let neighbour = if is_hotter { index.wrapping_add(1) } else { index.wrapping_sub(1) };
        let interval = all.get(neighbour)?;
        let after = all.get(neighbour.wrapping_add(1));
        let is_in = interval.first <= code.0 && after.is_none_or(|after| code.0 < after.first);
        is_in.then_some((neighbour, interval))
    }

    /// Checks a table against the law: in order, and in agreement with it at both sides of every edge.
    ///
    /// # Errors
    /// [`EdgeError::Malformed`] and [`EdgeError::Disagrees`].
    pub fn check(&self, law: &StaticLaw) -> Result<(), EdgeError> {
        self.check_by(|tap, code| law.tap(code) != Some(tap), |tap, code| law.leaves(tap, code))
    }

    /// The same, of any form of the law: `is_wrong` says that a tap is not a code's, `leaves` that the dead band does not
    /// hold it there.
    pub(super) fn check_by(
        &self,
        is_wrong: impl Fn(Taps, TemperatureCode) -> bool,
        leaves: impl Fn(Taps, TemperatureCode) -> bool,
    ) -> Result<(), EdgeError> {
        if self.intervals.first().is_none_or(|interval| interval.first != 0) {
            return Err(EdgeError::Malformed { index: 0 });
        }
        for (index, interval) in self.intervals.iter().enumerate() {
            let next = self.intervals.get(index + 1);
            let last = next.map_or(Some(u16::MAX), |next| next.first.checked_sub(1));
            let last = last.filter(|&last| {
                interval.first <= last && interval.hold_down_to <= interval.first && last <= interval.hold_up_to
            });
            let last = last.filter(|_| next.is_none_or(|next| next.tap != interval.tap));
            let last = last.ok_or(EdgeError::Malformed { index })?;
            for code in [interval.first, last].map(TemperatureCode) {
                if is_wrong(interval.tap, code) {
                    return Err(EdgeError::Disagrees { code });
                }
            }
            for code in [interval.hold_down_to, interval.hold_up_to].map(TemperatureCode) {
                if leaves(interval.tap, code) {
                    return Err(EdgeError::Disagrees { code });
                }
            }
        }
        Ok(())
    }
}

fn tap_at(law: &StaticLaw, code: u16) -> Result<Taps, EdgeError> {
    let code = TemperatureCode(code);
    law.tap(code).ok_or_else(|| EdgeError::OutOfTaps { code, position: law.position(code) })
}

/// The runs of temperature codes on which the law is monotone: between the turning points of its drift.
struct Pieces {
    /// The last code of each piece.
    lasts: Vec<u16, { crate::drift::MAX_TURNING_POINTS + 1 }>,
}

impl Pieces {
    fn of(law: &StaticLaw) -> Self {
        let mut lasts = Vec::new();
        for temperature in law.drift.turning_points() {
            // The last code at or below the turning point.
            let code = libm::floor((temperature - law.temperature_scale.zero) / law.temperature_scale.step);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped to 16 bits
            let code = code.clamp(0.0, f64::from(u16::MAX)) as u16;
            if code < u16::MAX && lasts.last().is_none_or(|&before| before < code) {
                let _ = lasts.push(code);
            }
        }
        let _ = lasts.push(u16::MAX);
        Self { lasts }
    }

    /// First and last code of each piece, coldest first.
    fn iter(&self) -> impl DoubleEndedIterator<Item = (u16, u16)> {
        let firsts = core::iter::once(0).chain(self.lasts.iter().map(|last| last.saturating_add(1)));
        let pairs: Vec<(u16, u16), { crate::drift::MAX_TURNING_POINTS + 1 }> =
            firsts.zip(self.lasts.iter().copied()).collect();
        pairs.into_iter()
    }

    /// Going hotter from a code, the last one at which the dead band holds the tap.
    fn hold_up(&self, law: &StaticLaw, tap: Taps, from: u16) -> u16 {
        for (first, last) in self.iter().filter(|&(_, last)| last >= from) {
            if let Some(left) = first_where(first.max(from), last, |c| law.leaves(tap, TemperatureCode(c))) {
                return left - 1;
            }
        }
        u16::MAX
    }

    /// Going colder from a code, the last one at which the dead band holds the tap.
    fn hold_down(&self, law: &StaticLaw, tap: Taps, from: u16) -> u16 {
        for (first, last) in self.iter().rev().filter(|&(first, _)| first <= from) {
            // The same search, mirrored.
            let (near, far) = (u16::MAX - last.min(from), u16::MAX - first);
            if let Some(left) = first_where(near, far, |c| law.leaves(tap, TemperatureCode(u16::MAX - c))) {
                return u16::MAX - left + 1;
            }
        }
        0
    }
}

/// The first code from `from` to `to` where a condition holds that, where it does not hold at `from`, once it holds, holds to
/// the end: by bisection. It may hold at `from` and not next to it: behind a turn that just reaches another tap.
fn first_where(from: u16, to: u16, condition: impl Fn(u16) -> bool) -> Option<u16> {
    if condition(from) {
        return Some(from);
    }
    let (mut low, mut high) = (from, to);
    if !condition(high) {
        return None;
    }
    while low < high {
        let middle = low.midpoint(high);
        if condition(middle) { high = middle } else { low = middle + 1 }
    }
    Some(high)
}
