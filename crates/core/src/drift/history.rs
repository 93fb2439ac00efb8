//! Drift that remembers: thermal hysteresis and lag, as a few operators on the temperature's history.
//!
//! A **play** of half-width r follows the temperature as a pin follows a slot of width 2r: it stays until the slot's edge
//! takes it along (Krasnosel'skii and Pokrovskii, *Systems with Hysteresis*, 1989; a weighted sum of plays is the
//! Prandtl-Ishlinskii model). A **lag** of time constant tau follows it as the inside of a package follows its surface:
//! `tau dm/dt = T - m`. Either has one number of state, m, and adds `weight (m - T)` to the reading: nothing where the
//! memory has caught up with the temperature.
//!
//! What drifts is not always at the temperature that its sensor tells: a part of it may be behind. Then the whole curve is
//! taken where that part is, at `T + behind (m - T)`: what a lag adds grows with the slope of the curve, and where the curve is
//! level it adds nothing. A term has both numbers, for either kind of physics: what is stressed by a gradient, and what is
//! late. What drifts was never colder or hotter than what was seen.
//!
//! What is not known at start-up is data here. A board that has just started has seen one temperature; what its sensor
//! went through before, nobody told it. Until the temperature has travelled 2r the state of a play can be anything
//! between two bounds, and the middle of them is taken; a lag forgets its start as `exp(-t / tau)`. [`known_share`] says
//! how much of the history's weight rests on what was seen: until it is nearly all, the answer is flagged. It is given all the
//! same, for the model was fitted to recordings that began as unknown.
//!
//! [`known_share`]: History::known_share

use heapless::Vec;

use super::curve::{Drift, Shape};
use super::range::Coverage;

/// The most terms of a history: three plays and three lags, or six plays.
pub const MAX_HISTORY_TERMS: usize = 6;

/// From this known share on the history counts as known.
pub(crate) const KNOWN_FROM: f64 = 0.95;

/// What a term remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Memory {
    /// A play of this half-width, in the temperature's unit.
    Play {
        /// r, above zero.
        half_width: f64,
    },
    /// A first-order lag of this time constant.
    Lag {
        /// tau, seconds, above zero.
        time_constant_s: f64,
    },
}

/// One term: `weight (m - T)`, and the curve taken at `T + behind (m - T)`, of several terms their sum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Term {
    /// What m is.
    pub memory: Memory,
    /// Reading per unit of temperature.
    pub weight: f64,
    /// How much of what drifts is where the memory is, and not where the sensor is: 0 none, 1 all.
    pub behind: f64,
    /// How much of the history rests on this term, 0 to 1, all terms together 1: the size of its effect among all.
    pub share: f64,
}

/// The part of a drift that remembers: a curve, where it is taken, and what is added to it.
#[derive(Debug, Clone, PartialEq)]
pub struct History {
    curve: Shape,
    terms: Vec<Term, MAX_HISTORY_TERMS>,
}

/// Whether the history that a correction rests on was seen. Degraded is data, as with [`Coverage`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Knowledge {
    /// There is no history in the model, or it was seen.
    #[default]
    Known,
    /// Too little of it was seen since start-up: the correction is uncertain by up to what it adds.
    Uncertain,
}

/// How far a term is believed at a known share k of it, 0 to 1: `k^2 / (k^2 + (1-k)^2)`, the weight of least mean square
/// error (Wiener's) for a signal that grows with k against an error that grows with 1 - k.
fn belief(known_share: f64) -> f64 {
    let (known, unknown) = (known_share * known_share, (1.0 - known_share) * (1.0 - known_share));
    known / (known + unknown)
}

impl History {
    /// A history. `curve` is its static part. `None` unless there are 1 to 6 terms whose
    /// half-widths and time constants are above zero, whose other numbers are finite, and whose shares are 0 to 1 and add
    /// up to 1 (to 1e-6).
    #[must_use]
    pub fn new(curve: Shape, terms: &[Term]) -> Option<Self> {
        let sound = |term: &Term| {
            let (Memory::Play { half_width: size } | Memory::Lag { time_constant_s: size }) = term.memory;
            let finite = [size, term.weight, term.behind].into_iter().all(f64::is_finite);
            size > 0.0 && finite && (0.0..=1.0).contains(&term.share)
        };
        let shares: f64 = terms.iter().map(|term| term.share).sum();
        if terms.is_empty() || !terms.iter().all(sound) || libm::fabs(shares - 1.0) > 1e-6 {
            return None;
        }
        Some(Self { curve, terms: Vec::from_slice(terms).ok()? })
    }

    /// The static part, in the reading's unit.
    #[must_use]
    pub const fn curve(&self) -> &Shape {
        &self.curve
    }

    /// The terms.
    #[must_use]
    pub fn terms(&self) -> &[Term] {
        &self.terms
    }

    /// Takes in the temperature of a group, or of a row, that is `seconds` later than the last one taken in (groups that
    /// were lost between them included). Between the two the temperature is taken to run straight. The first one starts
    /// the history, whatever `seconds` says. Outside the drift's valid range it is held at the nearer end. NaN is a lost
    /// group: its time counts for the next.
    pub fn advance(&self, drift: &Drift, state: &mut HistoryState, temperature: f64, seconds: f64) {
        state.waited_s += if seconds > 0.0 { seconds } else { 0.0 };
        if temperature.is_nan() {
            return;
        }
        let now = temperature.clamp(drift.valid.min(), drift.valid.max());
        let seconds = core::mem::take(&mut state.waited_s);
        let Some(seen) = &mut state.seen else {
            state.seen = Some(Seen::first(now));
            return;
        };
        seen.least = seen.least.min(now);
        seen.most = seen.most.max(now);
        seen.since_start_s += seconds;
        for (term, ahead) in self.terms.iter().zip(&mut seen.ahead) {
            *ahead = match term.memory {
                Memory::Play { half_width } => seen_play(half_width, seen.last + *ahead, seen.least, seen.most, now),
                Memory::Lag { time_constant_s } => lag(seconds / time_constant_s, *ahead, now - seen.last),
            };
        }
        seen.last = now;
    }

    fn by_history(&self, seen: &Seen) -> f64 {
        let sum = |of: fn(&Term) -> f64| -> f64 {
            self.terms.iter().zip(&seen.ahead).map(|(term, ahead)| of(term) * ahead).sum()
        };
        let inside = (seen.last + sum(|term| term.behind)).clamp(seen.least, seen.most);
        self.curve.evaluate(inside) + sum(|term| term.weight)
    }

    /// The reading by what was taken in last, the curve and what is remembered. NaN and [`Knowledge::Uncertain`] before the
    /// first temperature.
    #[must_use]
    pub fn evaluate(&self, state: &HistoryState) -> (f64, Knowledge) {
        let Some(seen) = &state.seen else {
            return (f64::NAN, Knowledge::Uncertain);
        };
        let known = self.known_share(state) >= KNOWN_FROM;
        (self.by_history(seen), if known { Knowledge::Known } else { Knowledge::Uncertain })
    }

    /// How much of the history's weight rests on what was seen, 0 to 1: the belief in each term by its own known share,
    /// together by the terms' shares. A play's known share is the range of temperature seen over 2r, a lag's is
    /// `1 - exp(-t / tau)`.
    #[must_use]
    pub fn known_share(&self, state: &HistoryState) -> f64 {
        let Some(seen) = &state.seen else { return 0.0 };
        let of = |term: &Term| match term.memory {
            Memory::Play { half_width } => ((seen.most - seen.least) / (2.0 * half_width)).min(1.0),
            Memory::Lag { time_constant_s } => 1.0 - libm::exp(-seen.since_start_s / time_constant_s),
        };
        self.terms.iter().map(|term| term.share * belief(of(term))).sum::<f64>().min(1.0)
    }

    /// Each term's `m - T` by what was taken in last, in the temperature's unit; zero before the first temperature.
    #[must_use]
    pub fn ahead(&self, state: &HistoryState) -> [f64; MAX_HISTORY_TERMS] {
        state.seen.map_or([0.0; MAX_HISTORY_TERMS], |seen| seen.ahead)
    }
}

/// What a history has seen: fixed in size, a few numbers an axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HistoryState {
    seen: Option<Seen>,
    /// Seconds that no temperature was taken in for.
    waited_s: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Seen {
    last: f64,
    least: f64,
    most: f64,
    since_start_s: f64,
    /// m - T of each term.
    ahead: [f64; MAX_HISTORY_TERMS],
}

impl Seen {
    fn first(temperature: f64) -> Self {
        Self {
            last: temperature,
            least: temperature,
            most: temperature,
            since_start_s: 0.0,
            ahead: [0.0; MAX_HISTORY_TERMS],
        }
    }
}

/// A play's m - T after it was at `before`. Until a range of 2r was seen, m lies between `most - r` and `least + r`, and
/// their middle is taken.
fn seen_play(half_width: f64, before: f64, least: f64, most: f64, now: f64) -> f64 {
    if most - least < 2.0 * half_width {
        f64::midpoint(least, most) - now
    } else {
        before.clamp(now - half_width, now + half_width) - now
    }
}

/// A lag's m - T after a straight run of `rise` in `x` time constants: the exact solution, whatever the step.
fn lag(x: f64, ahead: f64, rise: f64) -> f64 {
    let kept = libm::exp(-x);
    // (1 - exp(-x)) / x, 1 at 0
    let follows = if x > 1e-9 { -libm::expm1(-x) / x } else { 1.0 };
    ahead * kept - rise * follows
}

/// The reading of a drift with or without a history, by what was taken in last, and how far to trust it.
///
/// `temperature` is the one last taken in; it gives the coverage.
#[must_use]
pub fn evaluate_dynamic(
    drift: &Drift,
    history: Option<&History>,
    state: &HistoryState,
    temperature: f64,
) -> (f64, Coverage, Knowledge) {
    let (fixed, coverage) = drift.evaluate(temperature);
    match history {
        Some(history) if coverage != Coverage::Invalid => {
            let (reading, knowledge) = history.evaluate(state);
            (reading, coverage, knowledge)
        }
        Some(_) => (fixed, coverage, Knowledge::Uncertain),
        None => (fixed, coverage, Knowledge::Known),
    }
}

#[cfg(test)]
mod tests;
