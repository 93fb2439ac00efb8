//! How a tap change reaches the reading: through the circuit's low-pass.
//!
//! A tap change is a step of some 31 counts in the loop's rate. The digital correction that hides it must not jump
//! when the wiper is written, but rise as the low-pass rises. For a first-order low-pass of time constant `tau` the
//! part of a step still missing falls by `exp(-period / tau)` from sample to sample, exactly.

use serde::{Deserialize, Serialize};

use super::fixed::Q16;
use super::numbers::LowPassNumbers;

/// The low-pass at the board's sampling: how far its output has come when samples are taken.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LowPass {
    /// The part of a step still missing at the first sample after the wiper was written, 0 to 1.
    pub missing_at_first: f64,
    /// The part of it still missing one sample later, 0 to 1: `exp(-period / tau)`.
    pub missing_per_sample: f64,
}

impl LowPass {
    /// No low-pass: a step is there at once.
    pub const NONE: Self = Self { missing_at_first: 0.0, missing_per_sample: 0.0 };

    /// A first-order low-pass of cut-off `cutoff_hz`, sampled every `period_s`, when the wiper is written
    /// `write_delay_s` after the last sample.
    #[must_use]
    pub fn first_order(cutoff_hz: f64, period_s: f64, write_delay_s: f64) -> Self {
        let rate = 2.0 * core::f64::consts::PI * cutoff_hz;
        let missing = |seconds: f64| libm::exp(-rate * if seconds > 0.0 { seconds } else { 0.0 });
        Self { missing_at_first: missing(period_s - write_delay_s), missing_per_sample: missing(period_s) }
    }
}

/// The wiper's part of the reading, following the low-pass: integers alone.
///
/// After a write the part still missing is `(old - new) * missing_at_first` at the first sample and shrinks by
/// `missing_per_sample` with every further one. A second write while the first is settling adds to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settling {
    missing_at_first: u32,
    missing_per_sample: u32,
    settled: i32,
    missing: i32,
}

impl Settling {
    /// At rest at an effect.
    #[must_use]
    pub fn new(low_pass: LowPassNumbers, effect: Q16) -> Self {
        let LowPassNumbers { missing_at_first, missing_per_sample } = low_pass;
        Self { missing_at_first, missing_per_sample, settled: effect.0, missing: 0 }
    }

    /// The wiper was written, after the last sample and before the next: its effect is on its way to `effect`.
    pub fn wiper_written(&mut self, effect: Q16) {
        let step = self.settled.saturating_sub(effect.0);
        self.missing = self.missing.saturating_add(scale(step, self.missing_at_first));
        self.settled = effect.0;
    }

    /// The wiper's effect was moved or is known anew, and is there at once: nothing is left to settle.
    pub fn rest_at(&mut self, effect: Q16) {
        self.settled = effect.0;
        self.missing = 0;
    }

    /// The effect at the next sample.
    pub fn next_sample(&mut self) -> Q16 {
        let now = Q16(self.settled.saturating_add(self.missing));
        self.missing = scale(self.missing, self.missing_per_sample);
        now
    }

    /// The sum of the effects at the next `n` samples, in steps of [`Q16`]; the same as calling
    /// [`next_sample`](Self::next_sample) `n` times.
    pub fn next_samples(&mut self, n: u32) -> i64 {
        let mut sum = i64::from(self.settled) * i64::from(n);
        let mut left = n;
        while left > 0 && self.missing != 0 {
            sum += i64::from(self.missing);
            self.missing = scale(self.missing, self.missing_per_sample);
            left -= 1;
        }
        sum
    }
}

/// `value * part`, towards zero, so that what is missing dies out.
#[allow(clippy::cast_possible_truncation)] // the part is below 1
fn scale(value: i32, part: u32) -> i32 {
    ((i64::from(value) * i64::from(part)) / 4_294_967_296) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_effect_follows_an_exponential_step() {
        let (cutoff, period, delay) = (40.0, 0.003, 0.0001);
        let low_pass = LowPass::first_order(cutoff, period, delay);
        let mut settling = Settling::new(low_pass.numbers(), Q16(0));
        settling.wiper_written(Q16::from_counts(31.26).unwrap());
        for k in 0..20 {
            let seconds = period * f64::from(k + 1) - delay;
            let expected = 31.26 * (1.0 - libm::exp(-2.0 * core::f64::consts::PI * cutoff * seconds));
            assert!((settling.next_sample().to_counts() - expected).abs() < 1e-3, "sample {k}");
        }
    }

    #[test]
    fn a_run_of_samples_sums_to_the_same_bits() {
        let low_pass = LowPass::first_order(5.0, 0.003, 0.0001);
        let mut one_by_one = Settling::new(low_pass.numbers(), Q16(1000));
        one_by_one.wiper_written(Q16(-2_000_000));
        let mut at_once = one_by_one;
        let sum: i64 = (0..500).map(|_| i64::from(one_by_one.next_sample().0)).sum();
        assert_eq!(at_once.next_samples(500), sum);
        assert_eq!(at_once, one_by_one);
    }

    #[test]
    fn without_a_low_pass_a_step_is_there_at_once() {
        let mut settling = Settling::new(LowPassNumbers::NONE, Q16(0));
        settling.wiper_written(Q16(77));
        assert_eq!(settling.next_sample(), Q16(77));
    }
}
