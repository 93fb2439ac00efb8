//! A drift with history in integers alone, and the tap that it asks for.
//!
//! Memories are kept in codes, Q14: 16 bits of code and 14 below it in an `i32`. A lag's step by one group is two
//! multiplications; groups that were lost are stepped over at once, by a power of the same factor. The f64 model that
//! this is held against is [`History`].

use heapless::Vec;

use super::effects::{FixedEffects, Side};
use super::fixed::FixedDrift;
use super::numbers::{CODE_BITS, HistoryNumbers, MemoryNumbers, TermNumbers, WEIGHT_BITS};
use super::q16::Q16;
use crate::drift::{KNOWN_FROM, Knowledge, MAX_HISTORY_TERMS};
use crate::units::{Taps, TemperatureCode};

/// The furthest that a memory can be from the temperature: all codes, Q14. So no product with a part of one leaves 62 bits.
const FURTHEST: i64 = (u16::MAX as i64) << CODE_BITS;
/// One in Q32.
const ONE_Q32: u64 = 1 << 32;
/// One in Q16.
const ONE_Q16: u32 = 1 << 16;
/// [`KNOWN_FROM`] in Q16.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // 0 to 1
const KNOWN_FROM_Q16: u32 = (KNOWN_FROM * 65_536.0 + 0.5) as u32;

/// The part of a drift that remembers, in the form that the device runs, checked.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FixedHistory {
    curve: FixedDrift,
    terms: Vec<TermNumbers, MAX_HISTORY_TERMS>,
    /// How far past the middle between two taps the drift must be before the wiper moves, as a share of their distance,
    /// Q16.
    dead_band: i32,
}

/// What the history of one axis has seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct FixedHistoryState {
    seen: Option<Seen>,
    lost: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Seen {
    last: u16,
    least: u16,
    most: u16,
    memories: [TermState; MAX_HISTORY_TERMS],
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct TermState {
    /// m - T, codes, Q14.
    ahead: i32,
    /// Of a lag: what it still holds of its unknown start, Q32 less one step.
    forgotten: u32,
}

impl FixedHistoryState {
    /// Counts groups that were lost: time passed, and no temperature is known of it.
    pub(super) fn lose(&mut self, groups: u32) {
        self.lost = self.lost.saturating_add(groups);
    }
}

impl FixedHistory {
    /// A history by its numbers, over the codes of its static drift. `dead_band` is in taps, Q16. `None` where the numbers
    /// make no curve, a term remembers nothing, or the shares are not those of one whole.
    pub(super) fn from_numbers(numbers: &HistoryNumbers, first: u16, last: u16, dead_band: i32) -> Option<Self> {
        let is_sound = |term: &TermNumbers| match term.memory {
            MemoryNumbers::Play { half_width } => half_width > 0,
            MemoryNumbers::Lag { kept, part } => kept <= ONE_Q32 && part > 0,
        };
        let shares: u64 = numbers.terms.iter().map(|term| u64::from(term.share)).sum();
        // Each was rounded by half a step.
        let is_whole = shares.abs_diff(u64::from(ONE_Q16)) <= MAX_HISTORY_TERMS as u64;
        if !is_whole || !numbers.terms.iter().all(is_sound) {
            return None;
        }
        let curve = FixedDrift::over(first, last, &numbers.curve)?;
        Some(Self { curve, terms: numbers.terms.clone(), dead_band })
    }

    /// Takes in the temperature of the group that has closed. The first starts the history.
    pub(super) fn advance(&self, state: &mut FixedHistoryState, code: TemperatureCode) {
        let (first, last) = self.curve.range();
        let now = code.0.clamp(first.0, last.0);
        let groups = core::mem::take(&mut state.lost).saturating_add(1);
        let Some(seen) = &mut state.seen else {
            let memories = [TermState { ahead: 0, forgotten: u32::MAX }; MAX_HISTORY_TERMS];
            state.seen = Some(Seen { last: now, least: now, most: now, memories });
            return;
        };
        seen.least = seen.least.min(now);
        seen.most = seen.most.max(now);
        let rise = i32::from(now) - i32::from(seen.last);
        for (term, memory) in self.terms.iter().zip(&mut seen.memories) {
            match term.memory {
                MemoryNumbers::Play { half_width } => {
                    memory.ahead = play(half_width, memory.ahead, rise, seen.least, seen.most, now);
                }
                MemoryNumbers::Lag { kept, part } => {
                    let (kept, follows) = over_groups(kept, part, groups);
                    memory.ahead = lag(kept, follows, memory.ahead, rise);
                    memory.forgotten = narrow((u64::from(memory.forgotten) * kept) >> 32);
                }
            }
        }
        seen.last = now;
    }

    /// The drift by what was taken in last, and how far it is known; the static drift `fixed` before the first temperature.
    pub(super) fn drift(&self, state: &FixedHistoryState, fixed: Q16) -> (Q16, Knowledge) {
        let Some(seen) = &state.seen else {
            return (fixed, Knowledge::Uncertain);
        };
        let sum = |of: fn(&TermNumbers) -> i32| -> i64 {
            let terms = self.terms.iter().zip(&seen.memories);
            terms.map(|(term, memory)| i64::from(of(term)) * i64::from(memory.ahead)).fold(0, i64::saturating_add)
        };
        let known = self.known_share(seen);
        let curve = self.curve_behind(seen, sum(|term| term.behind) >> WEIGHT_BITS);
        let drift = curve + (sum(|term| term.weight) >> (WEIGHT_BITS + CODE_BITS - 16));
        let knowledge = if known >= KNOWN_FROM_Q16 { Knowledge::Known } else { Knowledge::Uncertain };
        (Q16(saturate(drift)), knowledge)
    }

    /// The curve where what drifts is: so far from the last code, codes, Q14, and never outside of what was seen. Between two
    /// codes on the straight line from the one to the other, Q16.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between two codes that were seen
    fn curve_behind(&self, seen: &Seen, ahead: i64) -> i64 {
        let [least, last, most] = [seen.least, seen.last, seen.most].map(|code| i64::from(code) << CODE_BITS);
        let inside = last.saturating_add(ahead).clamp(least, most);
        let code = (inside >> CODE_BITS) as u16;
        let past = inside - (i64::from(code) << CODE_BITS);
        let [below, above] =
            [code, code.saturating_add(1)].map(|code| i64::from(self.curve.evaluate(TemperatureCode(code)).0));
        below + (((above - below) * past) >> CODE_BITS)
    }

    fn known_share(&self, seen: &Seen) -> u32 {
        let range = u64::from(seen.most - seen.least) << CODE_BITS;
        let of = |term: &TermNumbers, memory: &TermState| match term.memory {
            MemoryNumbers::Play { half_width } => {
                ((range << 15) / u64::from(half_width.unsigned_abs())).min(u64::from(ONE_Q16))
            }
            MemoryNumbers::Lag { .. } => u64::from(ONE_Q16) - (u64::from(memory.forgotten) >> 16),
        };
        let sum: u64 = self
            .terms
            .iter()
            .zip(&seen.memories)
            .map(|(term, memory)| u64::from(term.share) * belief_q16(of(term, memory)))
            .sum();
        narrow(sum >> 16).min(ONE_Q16)
    }

    /// The tap for a drift: `now` while the drift lies within half the way to its neighbours and the dead band; else the
    /// tap whose effect brings the reading nearest the centre, the end tap where none does.
    pub(super) fn tap(&self, effects: &FixedEffects, now: Taps, drift_from_centre: i32) -> Taps {
        for side in Side::BOTH {
            if side.of(now).is_some() && effects.past_middle(now, side, drift_from_centre, self.dead_band) > 0 {
                let mut tap = now;
                while let Some(next) = side.of(tap)
                    && effects.past_middle(tap, side, drift_from_centre, 0) > 0
                {
                    tap = next;
                }
                return tap;
            }
        }
        now
    }
}

/// A play's m - T; see the f64 form.
fn play(half_width: i32, ahead: i32, rise: i32, least: u16, most: u16, now: u16) -> i32 {
    if i64::from(most - least) << CODE_BITS < 2 * i64::from(half_width) {
        // The middle of two codes, times 2^14.
        (i32::from(least) + i32::from(most) - 2 * i32::from(now)) << (CODE_BITS - 1)
    } else {
        let followed = i64::from(ahead) - (i64::from(rise) << CODE_BITS);
        saturate(followed.clamp(-i64::from(half_width), i64::from(half_width)))
    }
}

/// A lag's m - T after a straight run of `rise` codes: `ahead kept - rise follows`, both Q32.
fn lag(kept: u64, follows: u64, ahead: i32, rise: i32) -> i32 {
    let moved = i64::from(ahead) * q32_signed(kept) - ((i64::from(rise) * q32_signed(follows)) << CODE_BITS);
    // Rounded, not cut: a cut of half a step every group would add up over a time constant.
    let rounded = (moved + (1 << 31)) >> 32;
    // A lag lies between the least and the most code seen, unless its numbers are no lag's.
    saturate(rounded.clamp(-FURTHEST, FURTHEST))
}

/// `exp(-n x)` and `(1 - exp(-n x)) / (n x)` from `exp(-x)` and x, Q32: the power by squaring.
fn over_groups(kept: u64, part: u64, groups: u32) -> (u64, u64) {
    let (mut power, mut square, mut left) = (ONE_Q32, kept, groups);
    while left > 0 {
        if left & 1 == 1 {
            power = q32_product(power, square);
        }
        square = q32_product(square, square);
        left >>= 1;
    }
    // A whole beyond 2^64 is so many time constants that nothing of the rise is left behind.
    let follows = part.checked_mul(u64::from(groups)).map_or(0, |whole| shifted_quotient(ONE_Q32 - power, whole));
    (power, follows.min(ONE_Q32))
}

/// `2^32 a / b` for an `a` of at most 1 in Q32; where that is 1, less one step in 2^64.
fn shifted_quotient(a: u64, b: u64) -> u64 {
    a.saturating_mul(ONE_Q32) / b
}

/// Both at most 1, rounded.
fn q32_product(a: u64, b: u64) -> u64 {
    // Only 1 times 1 does not fit.
    a.checked_mul(b).map_or(ONE_Q32, |product| product.saturating_add(1 << 31) >> 32)
}

/// A number of at most 1 in Q32.
fn q32_signed(part: u64) -> i64 {
    i64::try_from(part.min(ONE_Q32)).unwrap_or(0)
}

/// How far a term is believed, as in the f64 form, in Q16.
fn belief_q16(known: u64) -> u64 {
    let unknown = u64::from(ONE_Q16) - known;
    let signal = known * known;
    (signal << 16) / (signal + unknown * unknown)
}

fn narrow(value: u64) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

fn saturate(value: i64) -> i32 {
    i32::try_from(value).unwrap_or(if value > 0 { i32::MAX } else { i32::MIN })
}

#[cfg(test)]
mod tests;
