//! Exact sums of a group of samples.

use serde::{Deserialize, Serialize};

use crate::units::{Counts, TemperatureCode};

/// Temperature codes to one count of a 14-bit board: a code is a quarter count there.
pub const CODES_PER_COUNT: u16 = 4;

/// The sums of one axis's samples in a group: exact integers, so that groups add up in any order to the same bits.
///
/// Any length up to `u32::MAX` samples of 16 bits fits: the squares' sum stays below 2^64.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct GroupSums {
    /// Number of samples.
    pub n: u32,
    /// Sum of the temperature samples, counts.
    pub temperature: u64,
    /// Sum of their squares, counts squared.
    pub temperature_sq: u64,
    /// Sum of the zero-rate samples, counts.
    pub zro: u64,
    /// Sum of their squares, counts squared.
    pub zro_sq: u64,
}

impl GroupSums {
    /// Those of no samples.
    pub const NONE: Self = Self { n: 0, temperature: 0, temperature_sq: 0, zro: 0, zro_sq: 0 };

    /// Takes in one sample of temperature and zero-rate output, counts.
    pub fn push(&mut self, temperature: u16, zro: u16) {
        let (temperature, zro) = (u64::from(temperature), u64::from(zro));
        self.n += 1;
        self.temperature += temperature;
        self.temperature_sq += temperature * temperature;
        self.zro += zro;
        self.zro_sq += zro * zro;
    }

    /// Mean temperature, counts; NaN for an empty group.
    #[must_use]
    pub fn mean_temperature(&self) -> Counts {
        mean(self.temperature, self.n)
    }

    /// Mean zero-rate output, counts; NaN for an empty group.
    #[must_use]
    pub fn mean_zro(&self) -> Counts {
        mean(self.zro, self.n)
    }

    /// Variance of the temperature samples about their mean, counts squared; NaN for an empty group.
    /// `(n S2 - S1^2) / n^2`, the difference taken in integers: nothing cancels.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn variance_of_temperature(&self) -> f64 {
        spread(self.n, self.temperature, self.temperature_sq) as f64 / (f64::from(self.n) * f64::from(self.n))
    }

    /// Whether the zero-rate output lies within four standard deviations of an end of what the circuit reaches, or beyond it, so
    /// that samples may have been cut off there. `reach` are the lowest and the highest reading, counts.
    #[must_use]
    pub fn is_saturated(&self, reach: [u16; 2]) -> bool {
        is_at_end(self.n, self.zro, self.zro_sq, reach)
    }

    /// Whether the temperature does, by the same rule: then it is no temperature.
    #[must_use]
    pub fn is_temperature_saturated(&self, reach: [u16; 2]) -> bool {
        is_at_end(self.n, self.temperature, self.temperature_sq, reach)
    }

    /// Whether the temperature samples scatter about their mean by more than so much, in steps of 1/256 count rms.
    #[must_use]
    pub fn temperature_scatters(&self, rms_q8: u32) -> bool {
        let n = u128::from(self.n);
        let spread = spread(self.n, self.temperature, self.temperature_sq);
        spread << 16 > n * n * u128::from(rms_q8) * u128::from(rms_q8)
    }

    /// The mean temperature as the law takes it, in so many codes to a count, rounded to the nearest in integers alone; `None`
    /// for an empty group.
    #[must_use]
    pub fn temperature_code(&self, codes_per_count: u16) -> Option<TemperatureCode> {
        let n = u64::from(self.n);
        let code = (2 * u64::from(codes_per_count) * self.temperature + n).checked_div(2 * n)?;
        Some(TemperatureCode(u16::try_from(code).unwrap_or(u16::MAX)))
    }
}

/// `n S2 - S1^2`: the variance times n squared, exactly.
fn spread(n: u32, sum: u64, squares: u64) -> u128 {
    (u128::from(n) * u128::from(squares)).saturating_sub(u128::from(sum) * u128::from(sum))
}

fn is_at_end(n: u32, sum: u64, squares: u64, [lowest, highest]: [u16; 2]) -> bool {
    let of_group = |reading: u16| u128::from(n) * u128::from(reading);
    let to_bottom = u128::from(sum).saturating_sub(of_group(lowest));
    let to_top = of_group(highest).saturating_sub(u128::from(sum));
    // All times n: the nearer end's distance against four sigma, both squared.
    let nearer = to_bottom.min(to_top);
    nearer * nearer <= 16 * spread(n, sum, squares) || nearer == 0
}

#[allow(clippy::cast_precision_loss)] // sums of a group are far below 2^53
fn mean(sum: u64, n: u32) -> Counts {
    Counts(sum as f64 / f64::from(n))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn an_empty_group_has_no_temperature() {
        let empty = GroupSums::default();
        assert!(empty.mean_temperature().0.is_nan() && empty.variance_of_temperature().is_nan());
        assert_eq!(empty.temperature_code(CODES_PER_COUNT), None);
    }

    #[test]
    fn a_group_of_full_scale_samples_is_exact_at_any_length() {
        let one = GroupSums {
            n: u32::MAX,
            temperature: u64::from(u32::MAX) * 65_535,
            temperature_sq: u64::from(u32::MAX) * 65_535 * 65_535,
            ..GroupSums::default()
        };
        assert!((one.mean_temperature().0 - 65_535.0).abs() < 1e-9);
        assert!(one.variance_of_temperature().abs() < 1e-9);
    }

    #[test]
    fn a_reading_near_an_end_of_the_converter_is_saturated() {
        let around = |centre: u16| {
            let mut sums = GroupSums::default();
            (0..500).for_each(|k: u16| sums.push(9000, (centre + k % 5).clamp(2, 16_385) - 2));
            sums
        };
        let saturated = |centre| around(centre).is_saturated([0, 16_383]);
        assert!(!saturated(8200) && !saturated(100) && !saturated(16_000));
        assert!(saturated(0) && saturated(4) && saturated(16_381) && saturated(16_500));
        // An amplifier that ends before the converter does: at its rail, near it, and beyond.
        let at_rail = |centre| around(centre).is_saturated([80, 16_383]);
        assert!(at_rail(27) && at_rail(73) && at_rail(80) && at_rail(84) && at_rail(16_381));
        assert!(!at_rail(100) && !at_rail(8200));
    }

    proptest! {
        #[test]
        fn samples_add_up_in_any_order_and_their_code_is_the_nearest(
            samples in prop::collection::vec((0..=16_383_u16, 0..=16_383_u16), 1..200),
        ) {
            let (mut forth, mut back) = (GroupSums::default(), GroupSums::default());
            samples.iter().for_each(|&(t, z)| forth.push(t, z));
            samples.iter().rev().for_each(|&(t, z)| back.push(t, z));
            prop_assert_eq!(forth, back);
            // The integer rounding against floating point.
            let mean = forth.mean_temperature().0 * 4.0;
            let code = f64::from(forth.temperature_code(CODES_PER_COUNT).unwrap().0);
            prop_assert!((code - mean).abs() <= 0.5 + 1e-9);
        }
    }
}
