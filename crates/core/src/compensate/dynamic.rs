//! A drift with history in integers alone, and the tap that it asks for.
//!
//! Memories are kept in codes, Q14: 16 bits of code and 14 below it in an `i32`. A lag's step by one group is two
//! multiplications; groups that were lost are stepped over at once, by a power of the same factor. The f64 model that
//! this is held against is [`History`].

use heapless::Vec;

use super::axis::FixedEffects;
use super::fixed::{FixedDrift, Q16, Unrepresentable, to_fixed};
use crate::drift::{Drift, History, KNOWN_FROM, Knowledge, MAX_HISTORY_TERMS, Memory, Term};
use crate::units::{Taps, TemperatureCode, TemperatureScale};

/// Fractional bits of a memory in codes.
const CODE_BITS: u32 = 14;
/// Fractional bits of a weight in counts per code: up to 127 counts a code, in steps that make 0.004 count over all codes.
const WEIGHT_BITS: u32 = 24;
/// One in Q32.
const ONE_Q32: u64 = 1 << 32;
/// One in Q16.
const ONE_Q16: u32 = 1 << 16;

/// The part of a drift that remembers, in the form that the device runs.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedHistory {
    curve: FixedDrift,
    terms: Vec<FixedTerm, MAX_HISTORY_TERMS>,
    known_from: u32,
    /// How far past the middle between two taps the drift must be before the wiper moves, as a share of their distance,
    /// Q16.
    dead_band: i32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct FixedTerm {
    memory: FixedMemory,
    /// Counts per code.
    weight: i32,
    /// Q16.
    share: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FixedMemory {
    /// Codes, Q14.
    Play { half_width: i32 },
    /// `exp(-p / tau)` and `p / tau` for the group period p, Q32.
    Lag { kept: u64, part: u64 },
}

/// What the history of one axis has seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FixedHistoryState {
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

impl FixedHistory {
    /// The device's form of a history beside its static drift. `group_period_s` is the time from group to group, in
    /// seconds; `dead_band` is in taps.
    ///
    /// # Errors
    /// [`Unrepresentable`], when its numbers do not fit.
    pub fn new(
        history: &History,
        drift: &Drift,
        scale: TemperatureScale,
        group_period_s: f64,
        dead_band: f64,
    ) -> Result<Self, Unrepresentable> {
        let curve = Drift { shape: history.curve().clone(), valid: drift.valid };
        let terms: Option<_> = history.terms().iter().map(|term| FixedTerm::new(term, scale, group_period_s)).collect();
        Ok(Self {
            curve: FixedDrift::new(&curve, scale)?,
            terms: terms.ok_or(Unrepresentable::TooLarge)?,
            known_from: share_q16(KNOWN_FROM),
            dead_band: to_fixed(dead_band, 16).ok_or(Unrepresentable::TooLarge)?,
        })
    }

    /// Counts groups that were lost: time passed, and no temperature is known of it.
    pub fn lose(state: &mut FixedHistoryState, groups: u32) {
        state.lost = state.lost.saturating_add(groups);
    }

    /// Takes in the temperature of the group that has closed. The first starts the history.
    pub fn advance(&self, state: &mut FixedHistoryState, code: TemperatureCode) {
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
                FixedMemory::Play { half_width } => {
                    memory.ahead = play(half_width, memory.ahead, rise, seen.least, seen.most, now);
                }
                FixedMemory::Lag { kept, part } => {
                    let (kept, follows) = over_groups(kept, part, groups);
                    memory.ahead = lag(kept, follows, memory.ahead, rise);
                    memory.forgotten = narrow((u64::from(memory.forgotten) * kept) >> 32);
                }
            }
        }
        seen.last = now;
    }

    /// The drift by what was taken in last, from the static drift there, and how far it is known. The static drift
    /// itself before the first temperature.
    #[must_use]
    pub fn drift(&self, state: &FixedHistoryState, fixed: Q16) -> (Q16, Knowledge) {
        let Some(seen) = &state.seen else {
            return (fixed, Knowledge::Uncertain);
        };
        let added: i64 = self
            .terms
            .iter()
            .zip(&seen.memories)
            .map(|(term, memory)| i64::from(term.weight) * i64::from(memory.ahead))
            .sum();
        let curve = i64::from(self.curve.evaluate(TemperatureCode(seen.last)).0);
        let known = self.known_share(seen);
        let by_history = curve + (added >> (WEIGHT_BITS + CODE_BITS - 16)) - i64::from(fixed.0);
        let drift = i64::from(fixed.0) + ((by_history * i64::from(lean_q16(known))) >> 16);
        let knowledge = if known >= self.known_from { Knowledge::Known } else { Knowledge::Uncertain };
        (Q16(saturate(drift)), knowledge)
    }

    fn known_share(&self, seen: &Seen) -> u32 {
        let range = u64::from(seen.most - seen.least) << CODE_BITS;
        let of = |term: &FixedTerm, memory: &TermState| match term.memory {
            FixedMemory::Play { half_width } => {
                ((range << 15) / u64::from(half_width.unsigned_abs())).min(u64::from(ONE_Q16))
            }
            FixedMemory::Lag { .. } => u64::from(ONE_Q16) - (u64::from(memory.forgotten) >> 16),
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
    #[must_use]
    pub(super) fn tap(&self, effects: &FixedEffects, now: Taps, drift_from_centre: i32) -> Taps {
        let wanted = -i64::from(drift_from_centre);
        let effect = |tap: Taps| i64::from(effects.get(tap).0);
        // How far the effect wanted lies beyond the middle from `a` to its neighbour `b`, positive towards `b`.
        let beyond = |a: Taps, b: Taps, band: i64| {
            let step = effect(b) - effect(a);
            let past = 2 * (wanted - effect(a)) - step - ((2 * step * band) >> 16);
            if step >= 0 { past } else { -past }
        };
        let walk = |from: Taps, neighbour: fn(Taps) -> Option<Taps>| {
            let mut tap = from;
            while let Some(next) = neighbour(tap).filter(|&next| beyond(tap, next, 0) > 0) {
                tap = next;
            }
            tap
        };
        let band = i64::from(self.dead_band);
        for neighbour in [above as fn(Taps) -> Option<Taps>, below] {
            if neighbour(now).is_some_and(|next| beyond(now, next, band) > 0) {
                return walk(now, neighbour);
            }
        }
        now
    }
}

impl FixedTerm {
    fn new(term: &Term, scale: TemperatureScale, group_period_s: f64) -> Option<Self> {
        let memory = match term.memory {
            Memory::Play { half_width } => {
                let half_width = to_fixed(half_width / scale.step, CODE_BITS)?;
                FixedMemory::Play { half_width: (half_width > 0).then_some(half_width)? }
            }
            Memory::Lag { time_constant_s } => {
                let x = group_period_s / time_constant_s;
                FixedMemory::Lag { kept: q32(libm::exp(-x))?, part: q32(x).filter(|&part| part > 0)? }
            }
        };
        Some(Self { memory, weight: to_fixed(term.weight * scale.step, WEIGHT_BITS)?, share: share_q16(term.share) })
    }
}

fn above(tap: Taps) -> Option<Taps> {
    Taps::new(tap.get() + 1)
}

fn below(tap: Taps) -> Option<Taps> {
    tap.get().checked_sub(1).and_then(Taps::new)
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
///
/// A memory lies between the least and the most code seen, so `ahead` is below 2^30, and each product below 2^62.
fn lag(kept: u64, follows: u64, ahead: i32, rise: i32) -> i32 {
    let moved = i64::from(ahead) * q32_signed(kept) - ((i64::from(rise) * q32_signed(follows)) << CODE_BITS);
    // Rounded, not cut: a cut of half a step every group would add up over a time constant.
    saturate(moved.saturating_add(1 << 31) >> 32)
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
    a.checked_mul(ONE_Q32).unwrap_or(u64::MAX) / b
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

/// [`crate::drift::belief`] in Q16.
fn belief_q16(known: u64) -> u64 {
    let unknown = u64::from(ONE_Q16) - known;
    let signal = known * known;
    (signal << 16) / (signal + unknown * unknown)
}

/// [`crate::drift::lean`] in Q16.
fn lean_q16(known: u32) -> u32 {
    let known = u64::from(known);
    narrow((((known * known) >> 16) * known) >> 16)
}

/// The nearest Q16 to a share of 0 to 1.
fn share_q16(share: f64) -> u32 {
    to_fixed(share.clamp(0.0, 1.0), 16).map_or(0, i32::unsigned_abs)
}

/// A number of 0 or more in Q32; `None` where it does not fit 62 bits.
fn q32(value: f64) -> Option<u64> {
    let scaled = libm::round(value * 4_294_967_296.0);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // within range, and whole
    (0.0..4.6e18).contains(&scaled).then_some(scaled as u64)
}

fn narrow(value: u64) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

fn saturate(value: i64) -> i32 {
    i32::try_from(value).unwrap_or(if value > 0 { i32::MAX } else { i32::MIN })
}

#[cfg(test)]
mod tests;
