//! One axis at work: the law's coefficients as the device runs them, and the state that they move.

use heapless::Vec;

use super::Mode;
use super::dynamic::{FixedHistory, FixedHistoryState};
use super::edges::{EdgeError, EdgeTable, Interval};
use super::fixed::{FixedDrift, Q16, Unrepresentable};
use super::law::StaticLaw;
use super::settling::{LowPass, Settling};
use crate::drift::{Coverage, History, Knowledge};
use crate::group::GroupSums;
use crate::trim::{MAX_TAP_OFFSETS, Trim};
use crate::units::{Taps, TemperatureCode};

/// An axis's law in the form that the device runs: integers and a table. It does not change while it is in use.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisLaw {
    drift: FixedDrift,
    edges: Option<EdgeTable>,
    effects: FixedEffects,
    centre: Q16,
    low_pass: LowPass,
    /// What makes the law dynamic; `None` where the drift is a function of temperature alone.
    history: Option<FixedHistory>,
}

/// Why a law cannot be run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LawRefused {
    /// Its numbers do not fit the fixed-point form.
    Unrepresentable(Unrepresentable),
    /// Its table of edges is not to be believed.
    Edges(EdgeError),
}

impl core::fmt::Display for LawRefused {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Unrepresentable(reason) => reason.fmt(f),
            Self::Edges(reason) => reason.fmt(f),
        }
    }
}

impl core::error::Error for LawRefused {}

impl AxisLaw {
    /// The device's form of a law. `edges` is the table that travelled with it, `None` where the law has none and
    /// the wiper is to stay (mode digital); it is checked against the law before it is believed.
    ///
    /// # Errors
    /// [`LawRefused`], when the numbers do not fit or the table is wrong.
    pub fn new(law: &StaticLaw, edges: Option<&EdgeTable>, low_pass: LowPass) -> Result<Self, LawRefused> {
        let drift = FixedDrift::new(&law.drift, law.temperature_scale).map_err(LawRefused::Unrepresentable)?;
        if let Some(edges) = edges {
            edges.check(law).map_err(LawRefused::Edges)?;
        }
        let too_large = LawRefused::Unrepresentable(Unrepresentable::TooLarge);
        Ok(Self {
            drift,
            edges: edges.cloned(),
            effects: FixedEffects::new(&law.trim).ok_or(too_large)?,
            centre: Q16::from_counts(law.trim.line.centre().0).ok_or(too_large)?,
            low_pass,
            history: None,
        })
    }

    /// The same law with a history ([`crate::drift::History`]), which modes digital and hybrid follow; mode trim stays
    /// with the static drift. `group_period_s` is the time from group to group, seconds.
    ///
    /// # Errors
    /// [`LawRefused::Unrepresentable`], when the history's numbers do not fit.
    pub fn with_history(mut self, history: &History, law: &StaticLaw, group_period_s: f64) -> Result<Self, LawRefused> {
        let fixed = FixedHistory::new(history, &law.drift, law.temperature_scale, group_period_s, law.dead_band);
        self.history = Some(fixed.map_err(LawRefused::Unrepresentable)?);
        Ok(self)
    }

    /// Whether the drift has a history.
    #[must_use]
    pub const fn is_dynamic(&self) -> bool {
        self.history.is_some()
    }

    /// Whether the law can move the wiper.
    #[must_use]
    pub const fn moves_wiper(&self) -> bool {
        self.edges.is_some()
    }

    /// What is to be subtracted from a settled reading: `V(T) + effect(N) - V0`, in integers.
    #[must_use]
    #[inline]
    pub fn correction(&self, code: TemperatureCode, tap: Taps) -> Q16 {
        // What is there most often needs no call, and so no stack.
        match (self.drift.polynomial(code), self.effects.measured(tap)) {
            (Some(drift), Some(effect)) => Q16(drift.0.wrapping_sub(self.centre.0).wrapping_add(effect)),
            _ => self.correction_of_the_rest(code, tap),
        }
    }

    /// The correction by a drift table, or for a tap that was not measured.
    #[inline(never)]
    fn correction_of_the_rest(&self, code: TemperatureCode, tap: Taps) -> Q16 {
        let drift = self.drift.evaluate_here(code).0.wrapping_sub(self.centre.0);
        Q16(drift.wrapping_add(self.effects.get(tap).0))
    }

    #[inline]
    fn drift_from_centre(&self, code: TemperatureCode) -> i32 {
        self.drift.evaluate(code).0.wrapping_sub(self.centre.0)
    }

    fn coverage(&self, code: TemperatureCode) -> Coverage {
        let (first, last) = self.drift.range();
        if code < first {
            Coverage::Below
        } else if code > last {
            Coverage::Above
        } else {
            Coverage::Inside
        }
    }
}

/// What each tap adds to the reading, in Q16: as measured, and on from the nearer end of what was measured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct FixedEffects {
    first: Taps,
    /// Without a measurement the middle tap alone, which adds nothing to itself.
    measured: Vec<i32, MAX_TAP_OFFSETS>,
    per_tap: i32,
}

impl FixedEffects {
    /// `None` when an effect does not fit: some tap would move the reading by more than 32 767 counts.
    pub(super) fn new(trim: &Trim) -> Option<Self> {
        for end in [Taps::FIRST, Taps::LAST] {
            Q16::from_counts(trim.effect(end).0)?;
        }
        let (first, measured) = match &trim.measured {
            None => (trim.line.middle(), core::iter::once(0).collect()),
            Some(swept) => {
                let fixed = swept.effects().iter().map(|effect| Q16::from_counts(effect.0).map(|q| q.0));
                (swept.first(), fixed.collect::<Option<_>>()?)
            }
        };
        let per_tap = Q16::from_counts(trim.line.counts_per_tap().0)?.0;
        Some(Self { first, measured, per_tap })
    }

    #[inline]
    pub(super) fn get(&self, tap: Taps) -> Q16 {
        self.measured(tap).map_or_else(|| self.beyond(tap), Q16)
    }

    #[inline]
    fn measured(&self, tap: Taps) -> Option<i32> {
        self.measured.get(tap.after(self.first)).copied()
    }

    /// The effect of a tap that was not measured.
    #[cold]
    #[inline(never)]
    fn beyond(&self, tap: Taps) -> Q16 {
        let offset = i32::from(tap.get()) - i32::from(self.first.get());
        #[allow(clippy::cast_possible_wrap, clippy::cast_possible_truncation)] // at most 96
        let last = self.measured.len() as i32 - 1;
        let nearest = offset.min(last).max(0);
        #[allow(clippy::cast_sign_loss)] // 0 and above
        let measured = self.measured.get(nearest as usize).copied().unwrap_or(0);
        // Both ends of the part fit (see `new`) and so does all between them: what wraps on the way comes back.
        Q16(measured.wrapping_add((offset - nearest).wrapping_mul(self.per_tap)))
    }
}

/// What closing a group came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GroupOutcome {
    /// The group's mean zero-rate output with the correction of its own temperature taken off; the plain mean in the
    /// modes that do not correct.
    pub corrected: Q16,
    /// Where the temperature lies against the calibrated range; `Invalid` for an empty group.
    pub coverage: Coverage,
    /// Whether the history that the correction rests on was seen; `Known` for a static law.
    pub knowledge: Knowledge,
    /// The tap that the law asks for, when it is not the one last commanded.
    pub move_to: Option<Taps>,
}

/// No interval of any table.
const NO_INTERVAL: usize = usize::MAX;

/// A run of temperature codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Hold {
    from: u32,
    codes: u32,
}

impl Hold {
    /// No code: the law is asked.
    const NONE: Self = Self { from: 0, codes: 0 };
    /// Every code: the wiper is not moved.
    const ALL: Self = Self { from: 0, codes: 1 << 16 };

    /// As far as a dead band holds an interval.
    fn of(interval: &Interval) -> Self {
        let from = u32::from(interval.hold_down_to);
        Self { from, codes: (u32::from(interval.hold_up_to) + 1).wrapping_sub(from) }
    }

    /// Whether a code lies in it: below its beginning the difference wraps to more than any run.
    #[inline]
    fn has(self, code: TemperatureCode) -> bool {
        u32::from(code.0).wrapping_sub(self.from) < self.codes
    }
}

/// The state of one axis: mode, interval of the table, the last commanded tap, and the correction in force.
#[derive(Debug, Clone)]
pub struct AxisCompensation {
    /// The codes at which the wiper is where the law wants it: all that an update looks at until an edge is crossed.
    hold: Hold,
    mode: Mode,
    tap: Taps,
    /// The interval of the table, [`NO_INTERVAL`] before one is known.
    interval: usize,
    /// `V(T) - V0` of the last closed group, Q16; `None` until there was one.
    drift_from_centre: Option<i32>,
    settling: Settling,
    /// The wiper's effect over the samples of the group that is being filled, Q16.
    effect_sum: i64,
    history: FixedHistoryState,
}

impl AxisCompensation {
    /// An axis at start-up: mode off, the wiper settled at a tap.
    #[must_use]
    pub fn new(law: Option<&AxisLaw>, tap: Taps) -> Self {
        let low_pass = law.map_or(LowPass::NONE, |law| law.low_pass);
        let effect = law.map_or(Q16::default(), |law| law.effects.get(tap));
        Self {
            hold: Hold::NONE,
            mode: Mode::Off,
            tap,
            interval: NO_INTERVAL,
            drift_from_centre: None,
            settling: Settling::new(low_pass, effect),
            effect_sum: 0,
            history: FixedHistoryState::default(),
        }
    }

    /// The mode.
    #[must_use]
    pub const fn mode(&self) -> Mode {
        self.mode
    }

    /// The last commanded tap: the potentiometer cannot be read back.
    #[must_use]
    pub const fn tap(&self) -> Taps {
        self.tap
    }

    /// Changes the mode; the wiper stays until the next group.
    pub fn set_mode(&mut self, mode: Mode) {
        self.mode = mode;
        self.interval = NO_INTERVAL;
        self.hold = Hold::NONE;
    }

    /// The wiper was written. Its effect reaches the samples through the low-pass.
    pub fn wiper_written(&mut self, law: Option<&AxisLaw>, tap: Taps) {
        self.tap = tap;
        self.hold = Hold::NONE;
        if let Some(law) = law {
            self.settling.wiper_written(law.effects.get(tap));
            self.hold_present_interval(law);
        }
    }

    /// One sample of the group that is being filled, corrected by what is known when it is taken: the temperature of
    /// the last closed group, and the wiper as far as it has settled. The plain sample in the modes that do not
    /// correct, and before the first group has closed.
    pub fn sample(&mut self, zro: u16) -> Q16 {
        let effect = self.settling.next_sample().0;
        self.effect_sum += i64::from(effect);
        let reading = i32::from(zro) << 16;
        match self.drift_from_centre {
            Some(drift) if self.mode.corrects() => Q16(reading - drift - effect),
            _ => Q16(reading),
        }
    }

    /// Passes over samples of the group that is being filled whose readings are not looked at one by one.
    pub fn skip_samples(&mut self, n: u32) {
        self.effect_sum += self.settling.next_samples(n);
    }

    /// Passes over samples that were lost before the group that is being filled: the wiper settles meanwhile.
    pub fn skip_lost(&mut self, n: u32) {
        let _ = self.settling.next_samples(n);
    }

    /// Groups were lost before the one that is being filled: the history goes on without their temperatures.
    pub fn lose_groups(&mut self, groups: u32) {
        FixedHistory::lose(&mut self.history, groups);
    }

    /// Closes a group: the correction for its mean, and the tap for its temperature.
    pub fn close_group(&mut self, law: Option<&AxisLaw>, sums: &GroupSums) -> GroupOutcome {
        self.close_group_at(law, sums, sums.temperature_code())
    }

    /// Closes a group whose temperature is known better than by its own sums: the last one that was believed. `None`
    /// where none is known.
    pub fn close_group_at(
        &mut self,
        law: Option<&AxisLaw>,
        sums: &GroupSums,
        code: Option<TemperatureCode>,
    ) -> GroupOutcome {
        let effect_sum = core::mem::take(&mut self.effect_sum);
        let (Some(law), Some(code)) = (law, code) else {
            // A group without a temperature has taken its time all the same.
            self.lose_groups(1);
            let (coverage, knowledge) = (Coverage::Invalid, Knowledge::Known);
            return GroupOutcome { corrected: mean_q16(sums, 0), coverage, knowledge, move_to: None };
        };
        let (drift, knowledge) = match &law.history {
            None => (law.drift_from_centre(code), Knowledge::Known),
            Some(history) => {
                history.advance(&mut self.history, code);
                let (drift, knowledge) = history.drift(&self.history, law.drift.evaluate(code));
                (drift.0.saturating_sub(law.centre.0), knowledge)
            }
        };
        self.drift_from_centre = Some(drift);
        let correction = i64::from(drift) * i64::from(sums.n) + effect_sum;
        let corrected = mean_q16(sums, if self.mode.corrects() { correction } else { 0 });
        let move_to = match &law.history {
            Some(history) if self.mode == Mode::Hybrid && law.moves_wiper() => {
                Some(history.tap(&law.effects, self.tap, drift)).filter(|&tap| tap != self.tap)
            }
            _ => self.update(law, code),
        };
        GroupOutcome { corrected, coverage: law.coverage(code), knowledge, move_to }
    }

    /// The tap that the law asks for at a temperature code, when it is not the one last commanded. Once it has been
    /// written, [`wiper_written`](Self::wiper_written) is to be called; until then the law goes on asking.
    ///
    /// One compare, until an edge is crossed.
    #[inline]
    #[must_use]
    pub fn update(&mut self, law: &AxisLaw, code: TemperatureCode) -> Option<Taps> {
        if self.hold.has(code) {
            return None;
        }
        self.cross(law, code)
    }

    /// An edge was crossed, most often to a neighbour; or it is not known yet where the edges are.
    #[inline(never)]
    fn cross(&mut self, law: &AxisLaw, code: TemperatureCode) -> Option<Taps> {
        match &law.edges {
            // Only an interval that holds says on which side the code has left it. The wiper was at its tap, and a
            // neighbour's is another.
            Some(edges) if self.hold.codes != 0 => match edges.neighbour(self.interval, code) {
                Some((index, interval)) => {
                    self.interval = index;
                    self.hold = Hold::NONE;
                    Some(interval.tap)
                }
                None => self.search(law, code),
            },
            _ => self.search(law, code),
        }
    }

    /// The interval is looked up.
    #[inline(never)]
    fn search(&mut self, law: &AxisLaw, code: TemperatureCode) -> Option<Taps> {
        let Some(edges) = law.edges.as_ref().filter(|_| self.mode.moves_wiper()) else {
            self.hold = Hold::ALL;
            return None;
        };
        let index = edges.next(self.interval, code);
        let interval = edges.intervals().get(index)?;
        self.interval = index;
        if interval.tap == self.tap {
            self.hold = Hold::of(interval);
            return None;
        }
        self.hold = Hold::NONE;
        Some(interval.tap)
    }

    /// The wiper is where the present interval wants it: so it stays as far as the dead band holds it.
    fn hold_present_interval(&mut self, law: &AxisLaw) {
        let edges = law.edges.as_ref().filter(|_| self.mode.moves_wiper());
        let interval = edges.and_then(|edges| edges.intervals().get(self.interval));
        if let Some(interval) = interval.filter(|interval| interval.tap == self.tap) {
            self.hold = Hold::of(interval);
        }
    }
}

/// `(sum of zro - correction) / n` to the nearest Q16 step; 0 for an empty group.
fn mean_q16(sums: &GroupSums, correction_sum: i64) -> Q16 {
    if sums.n == 0 {
        return Q16::default();
    }
    let n = i64::from(sums.n);
    // A sum of 16-bit samples shifted by 16 stays below 2^63 for up to 2^31 samples.
    let sum = (i64::try_from(sums.zro).unwrap_or(i64::MAX >> 16) << 16) - correction_sum;
    Q16(i32::try_from((2 * sum + n).div_euclid(2 * n)).unwrap_or(i32::MAX))
}
