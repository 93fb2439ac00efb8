//! A law solved for its edges.

use heapless::Vec;

use super::law::StaticLaw;
use crate::compensate::edges::EdgeTable;
use crate::compensate::interval::{Interval, MAX_INTERVALS};
use crate::compensate::refused::EdgeError;
use crate::drift::MAX_TURNING_POINTS;
use crate::units::{Taps, TemperatureCode};

impl EdgeTable {
    /// Solves a law for its edges, piece by monotone piece.
    ///
    /// # Errors
    /// [`EdgeError::OutOfTaps`] and [`EdgeError::TooManyIntervals`], when the law cannot be tabled.
    pub fn solve(law: &StaticLaw) -> Result<Self, EdgeError> {
        let pieces = Pieces::of(law);
        let mut intervals: Vec<Interval, MAX_INTERVALS> = Vec::new();
        for &(first, last) in &pieces.0 {
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

    /// Checks a table against the law: in order, and in agreement with it at both sides of every edge.
    ///
    /// # Errors
    /// [`EdgeError::Malformed`] and [`EdgeError::Disagrees`].
    pub(in crate::compensate) fn check(&self, law: &StaticLaw) -> Result<(), EdgeError> {
        self.check_by(|tap, code, is_held| if is_held { law.leaves(tap, code) } else { law.tap(code) != Some(tap) })
    }
}

fn tap_at(law: &StaticLaw, code: u16) -> Result<Taps, EdgeError> {
    let code = TemperatureCode(code);
    law.tap(code).ok_or_else(|| EdgeError::OutOfTaps { code, position: law.position(code) })
}

/// First and last code of every run on which the law is monotone, coldest first: between the turning points of its drift.
struct Pieces(Vec<(u16, u16), { MAX_TURNING_POINTS + 1 }>);

impl Pieces {
    fn of(law: &StaticLaw) -> Self {
        let mut pieces = Vec::new();
        let mut first = 0;
        for temperature in law.drift.turning_points() {
            // The last code at or below the turning point.
            let code = libm::floor((temperature - law.temperature_scale.zero) / law.temperature_scale.step);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped to 16 bits
            let last = code.clamp(0.0, f64::from(u16::MAX)) as u16;
            if first <= last && last < u16::MAX {
                let _ = pieces.push((first, last));
                first = last + 1;
            }
        }
        let _ = pieces.push((first, u16::MAX));
        Self(pieces)
    }

    /// Going hotter from a code, the last one at which the dead band holds the tap.
    fn hold_up(&self, law: &StaticLaw, tap: Taps, from: u16) -> u16 {
        held_up_to(self.0.iter().copied(), from, |code| law.leaves(tap, TemperatureCode(code)))
    }

    /// Going colder: the same search, mirrored.
    fn hold_down(&self, law: &StaticLaw, tap: Taps, from: u16) -> u16 {
        let mirrored = self.0.iter().rev().map(|&(first, last)| (u16::MAX - last, u16::MAX - first));
        u16::MAX - held_up_to(mirrored, u16::MAX - from, |code| law.leaves(tap, TemperatureCode(u16::MAX - code)))
    }
}

fn held_up_to(pieces: impl Iterator<Item = (u16, u16)>, from: u16, leaves: impl Fn(u16) -> bool) -> u16 {
    let mut left = pieces
        .filter(|&(_, last)| last >= from)
        .filter_map(|(first, last)| first_where(first.max(from), last, &leaves));
    left.next().map_or(u16::MAX, |left| left - 1)
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
