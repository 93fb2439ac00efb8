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
        let rate = 2.0 * core::f64::consts::PI * cutoff_hz;
        let missing = |seconds: f64| libm::exp(-rate * if seconds > 0.0 { seconds } else { 0.0 });
        Self { missing_at_first: missing(period_s - write_delay_s), missing_per_sample: missing(period_s) }
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
}
