//! One axis at work: the state that its law moves.

use super::axis_law::AxisLaw;
use super::codes::Codes;
use super::dynamic::FixedHistoryState;
use super::interval::Interval;
use super::mode::Mode;
use super::numbers::LowPassNumbers;
use super::q16::Q16;
use super::sample::{SampleCorrection, corrected};
use super::settling::Settling;
use crate::drift::{Coverage, Knowledge};
use crate::group::{CODES_PER_COUNT, GroupSums};
use crate::units::{Taps, TemperatureCode};

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

/// How the wiper stands to the table of edges, whose intervals go by their index.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stand {
    /// The tap of this interval is wanted, and was not written yet.
    Wanted(usize),
    /// The wiper is at the tap of this interval.
    At(usize),
    /// The table was not asked since the mode was set.
    Unasked,
    /// There is none to ask, or the mode leaves the wiper where it is.
    Free,
}

/// The state of one axis: mode, interval of the table, the last commanded tap, and the correction in force.
#[derive(Debug, Clone)]
pub struct AxisCompensation {
    /// The codes at which the wiper is where the law wants it, by `stand`: all that an update looks at until an edge is
    /// crossed.
    quiet: Codes,
    stand: Stand,
    mode: Mode,
    tap: Taps,
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
        let low_pass = law.map_or(LowPassNumbers::NONE, |law| law.low_pass);
        let effect = law.map_or(Q16::default(), |law| law.effects.get(tap));
        Self {
            quiet: Codes::NONE,
            stand: Stand::Unasked,
            mode: Mode::Off,
            tap,
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
        (self.stand, self.quiet) = (Stand::Unasked, Codes::NONE);
    }

    /// The wiper was written. Its effect reaches the samples through the low-pass.
    pub fn wiper_written(&mut self, law: Option<&AxisLaw>, tap: Taps) {
        self.tap = tap;
        let Some(law) = law else { return };
        self.settling.wiper_written(law.effects.get(tap));
        if let Stand::Wanted(index) | Stand::At(index) = self.stand
            && let Some(interval) = law.edges.as_ref().and_then(|edges| edges.intervals().get(index))
        {
            let _ = self.follow(index, interval);
        }
    }

    /// One sample of the group that is being filled, corrected by what is known when it is taken: the temperature of
    /// the last closed group, and the wiper as far as it has settled. The plain sample in the modes that do not
    /// correct, and before the first group has closed.
    ///
    /// Of a converter of 16 bits a reading takes the sign's bit too: what is given is so many counts less 65 536 then
    /// ([`Q16::near`]).
    pub fn sample(&mut self, zro: u16) -> Q16 {
        let effect = self.settling.next_sample();
        self.effect_sum += i64::from(effect.0);
        corrected(zro, self.drift_in_force(), effect)
    }

    /// What corrects the samples from here on one by one, beside the group that they add up to: the same bits as
    /// [`sample`](Self::sample).
    #[must_use]
    pub fn sample_correction(&self) -> SampleCorrection {
        SampleCorrection::new(self.settling, self.drift_in_force())
    }

    /// Whether a temperature has been taken in, so that the law is in force.
    #[must_use]
    pub const fn has_begun(&self) -> bool {
        self.drift_from_centre.is_some()
    }

    /// What is subtracted but for the wiper's part; none in the modes that do not correct, and before the first group.
    fn drift_in_force(&self) -> Option<i32> {
        self.drift_from_centre.filter(|_| self.mode.corrects())
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
        self.history.lose(groups);
    }

    /// Closes a group of a 14-bit board: the correction for its mean, and the tap for its temperature.
    pub fn close_group(&mut self, law: Option<&AxisLaw>, sums: &GroupSums) -> GroupOutcome {
        self.close_group_at(law, sums, sums.temperature_code(CODES_PER_COUNT))
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
                (drift.0, knowledge)
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
        if self.quiet.place(code).is_some() {
            return None;
        }
        // What is asked for is read here: a call that is not the last thing keeps the frame out of the way above.
        self.cross(law, code).map(|interval| interval.tap)
    }

    /// An edge was crossed, most often to a neighbour; or it is not known yet where the edges are.
    #[inline(never)]
    fn cross<'l>(&mut self, law: &'l AxisLaw, code: TemperatureCode) -> Option<&'l Interval> {
        // Only an interval that holds says on which side the code has left it. The wiper was at its tap, and a neighbour's
        // is another.
        if let Stand::At(index) = self.stand
            && let Some(edges) = &law.edges
            && let Some((index, interval)) = edges.neighbour(index, code)
        {
            (self.stand, self.quiet) = (Stand::Wanted(index), Codes::NONE);
            return Some(interval);
        }
        self.search(law, code)
    }

    /// The interval is looked up.
    #[inline(never)]
    fn search<'l>(&mut self, law: &'l AxisLaw, code: TemperatureCode) -> Option<&'l Interval> {
        let Some(edges) = law.edges.as_ref().filter(|_| self.mode.moves_wiper()) else {
            (self.stand, self.quiet) = (Stand::Free, Codes::ALL);
            return None;
        };
        let index = match self.stand {
            Stand::Wanted(index) | Stand::At(index) => edges.next(index, code),
            Stand::Unasked | Stand::Free => edges.find(code),
        };
        let interval = edges.intervals().get(index)?;
        self.follow(index, interval).then_some(interval)
    }

    /// The temperature is in an interval; whether its tap is asked for, for the wiper is not there.
    fn follow(&mut self, index: usize, interval: &Interval) -> bool {
        let is_there = interval.tap == self.tap;
        (self.stand, self.quiet) = if is_there {
            (Stand::At(index), Codes::between(interval.hold_down_to, interval.hold_up_to))
        } else {
            (Stand::Wanted(index), Codes::NONE)
        };
        !is_there
    }
}

/// `(sum of zro - correction) / n` to the nearest Q16 step, modulo 65 536 counts; 0 for an empty group.
fn mean_q16(sums: &GroupSums, correction_sum: i64) -> Q16 {
    if sums.n == 0 {
        return Q16::default();
    }
    let n = i64::from(sums.n);
    // A sum of 16-bit samples shifted by 16 stays below 2^63 for up to 2^31 samples.
    let sum = (i64::try_from(sums.zro).unwrap_or(i64::MAX >> 16) << 16) - correction_sum;
    let mean = (2 * sum + n).div_euclid(2 * n);
    #[allow(clippy::cast_possible_truncation)] // its lower half is what is given
    Q16(mean as i32)
}
