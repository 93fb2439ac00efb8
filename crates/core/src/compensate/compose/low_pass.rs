//! The circuit's low-pass, as the host knows it.

use serde::{Deserialize, Serialize};

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
        Self::first_order_of_means(cutoff_hz, period_s, write_delay_s, 1)
    }

    /// The same where a sample is the mean of so many conversions, evenly spread over the period that ends with the last
    /// of them: of the first such sample the step is missing by more.
    #[must_use]
    pub fn first_order_of_means(cutoff_hz: f64, period_s: f64, write_delay_s: f64, conversions: u8) -> Self {
        let rate = 2.0 * core::f64::consts::PI * cutoff_hz;
        let missing = |seconds: f64| libm::exp(-rate * if seconds > 0.0 { seconds } else { 0.0 });
        let count = f64::from(conversions.max(1));
        let after_s = |conversion: u8| period_s * f64::from(conversion) / count - write_delay_s;
        let sum: f64 = (1..=conversions.max(1)).map(|conversion| missing(after_s(conversion))).sum();
        Self { missing_at_first: sum / count, missing_per_sample: missing(period_s) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensate::Q16;
    use crate::compensate::settling::Settling;

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

    /// Against the mean of an exponential step over the period, which many conversions come to: (e^-a)(e^b - 1) / b.
    #[test]
    fn of_a_mean_the_step_is_missing_as_on_average_over_the_period() {
        let (cutoff, period) = (40.0, 0.003);
        let turned = 2.0 * core::f64::consts::PI * cutoff * period;
        let mean = (1.0 - libm::exp(-turned)) / turned;
        let one = LowPass::first_order(cutoff, period, 0.0);
        let of = |conversions| LowPass::first_order_of_means(cutoff, period, 0.0, conversions);
        assert!((of(1).missing_at_first - one.missing_at_first).abs() < 1e-15);
        // The conversions stand at the ends of their parts of the period: half a part later than its middle.
        let late = libm::exp(-turned / 32.0);
        assert!((of(16).missing_at_first - mean * late).abs() < 1e-3, "{}", of(16).missing_at_first);
        assert!((of(16).missing_per_sample - one.missing_per_sample).abs() < 1e-15);
    }
}
