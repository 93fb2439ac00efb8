//! How a tap change reaches the reading: through the circuit's low-pass.
//!
//! A tap change is a step of some 31 counts in the loop's rate. The digital correction that hides it must not jump
//! when the wiper is written, but rise as the low-pass rises. For a first-order low-pass of time constant `tau` the
//! part of a step still missing falls by `exp(-period / tau)` from sample to sample, exactly.

use super::numbers::LowPassNumbers;
use super::q16::Q16;

/// The wiper's part of the reading, following the low-pass: integers alone.
///
/// After a write the part still missing is `(old - new) * missing_at_first` at the first sample and shrinks by
/// `missing_per_sample` with every further one. A second write while the first is settling adds to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Settling {
    missing_at_first: u32,
    missing_per_sample: u32,
    settled: i32,
    missing: i32,
}

impl Settling {
    /// At rest without an effect.
    pub(super) const NONE: Self = Self { missing_at_first: 0, missing_per_sample: 0, settled: 0, missing: 0 };

    /// At rest at an effect.
    pub(super) fn new(low_pass: LowPassNumbers, effect: Q16) -> Self {
        let LowPassNumbers { missing_at_first, missing_per_sample } = low_pass;
        Self { missing_at_first, missing_per_sample, settled: effect.0, missing: 0 }
    }

    /// The wiper was written, after the last sample and before the next: its effect is on its way to `effect`.
    pub(super) fn wiper_written(&mut self, effect: Q16) {
        let step = self.settled.saturating_sub(effect.0);
        self.missing = self.missing.saturating_add(scale(step, self.missing_at_first));
        self.settled = effect.0;
    }

    /// What is still missing of it at the next sample, in steps of [`Q16`].
    pub(super) const fn missing(&self) -> i32 {
        self.missing
    }

    /// The effect at the next sample.
    pub(super) fn next_sample(&mut self) -> Q16 {
        let now = Q16(self.settled.saturating_add(self.missing));
        self.missing = scale(self.missing, self.missing_per_sample);
        now
    }

    /// The sum of the effects at the next `n` samples, in steps of [`Q16`]; the same as calling
    /// [`next_sample`](Self::next_sample) `n` times.
    pub(super) fn next_samples(&mut self, n: u32) -> i64 {
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
    fn a_run_of_samples_sums_to_the_same_bits() {
        // 91 % still missing after each period.
        let low_pass = LowPassNumbers { missing_at_first: 3_934_000_000, missing_per_sample: 3_908_759_573 };
        let mut one_by_one = Settling::new(low_pass, Q16(1000));
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
