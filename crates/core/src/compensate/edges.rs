//! The static law as a table of edges: the temperatures at which the tap changes, solved for by the host.
//!
//! Over the temperature codes the nearest tap is constant on intervals. The table holds them in order, each with its
//! tap and the two codes up to which a dead band holds on to it. An update is a compare with the two edges of the
//! present interval; only when the temperature has left them is the table searched. Since the interval, and not only
//! the tap, is the state, a drift that turns round and comes back to a tap needs no special case.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use super::interval::{Interval, MAX_INTERVALS};
use super::refused::EdgeError;
use crate::units::{Taps, TemperatureCode};

/// Every temperature code's tap, and how long a dead band holds it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct EdgeTable {
    pub(super) intervals: Vec<Interval, MAX_INTERVALS>,
}

impl EdgeTable {
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

    /// Checks the table against a law of any form: in order, and in agreement with it at both sides of every edge.
    /// `strays` says that a tap is not a code's, or, with the dead band, that it is not held there.
    pub(super) fn check_by(&self, strays: impl Fn(Taps, TemperatureCode, bool) -> bool) -> Result<(), EdgeError> {
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
            let held = [interval.hold_down_to, interval.hold_up_to];
            for (code, is_held) in [(interval.first, false), (last, false), (held[0], true), (held[1], true)] {
                let code = TemperatureCode(code);
                if strays(interval.tap, code, is_held) {
                    return Err(EdgeError::Disagrees { code });
                }
            }
        }
        Ok(())
    }
}
