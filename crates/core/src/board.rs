//! What a board's numbers mean, as far as a device must know it to judge them: its converter and its temperature sensors.

use serde::{Deserialize, Serialize};

/// How near its amplifier comes to ground: AD8630's V_OL, 20 mV at most with 10 kOhm (Analog Devices, AD8628/AD8629/AD8630, 5 V
/// characteristics), which is the rail that the simulated board has.
const AMPLIFIER_LOW_MV: u32 = 20;
/// The converter's reference, ADR4540B.
const REFERENCE_MV: u32 = 4096;

/// A board's converter and temperature sensors. A record carries them; a board without a record has those that it was built
/// with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct BoardNumbers {
    /// The converter's highest reading, counts.
    pub full_scale: u16,
    /// Temperature codes to one count of the temperature reading.
    pub codes_per_count: u16,
    /// Counts of the temperature reading a kelvin, in steps of 1/256.
    pub counts_per_kelvin_q8: u32,
    /// Noise of one sample of it, counts rms, in steps of 1/256.
    pub temperature_noise_q8: u32,
}

impl BoardNumbers {
    /// The paper's: 14 bits, 34 counts a kelvin, 3 counts of noise (docs/paper.md). A code is a quarter count, so that the mean of
    /// a group keeps what averaging gave it.
    pub const PAPER: Self = Self {
        full_scale: (1 << 14) - 1,
        codes_per_count: 4,
        counts_per_kelvin_q8: 34 << 8,
        temperature_noise_q8: 3 << 8,
    };

    /// The most counts a kelvin and of noise that make sense: more than a converter's range.
    const MOST_Q8: u32 = 1 << 24;

    /// The numbers of a converter of so many bits, 1 to 16, with as fine a code as 16 bits hold; `None` where they make no
    /// sense.
    #[must_use]
    pub fn new(bits: u32, counts_per_kelvin: f64, temperature_noise_counts: f64) -> Option<Self> {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // held within bounds
        let q8 = |counts: f64| {
            let steps = libm::round(counts * 256.0);
            (1.0..=f64::from(Self::MOST_Q8)).contains(&steps).then_some(steps as u32)
        };
        let full_scale = u16::try_from(1_u32.checked_shl(bits)?.checked_sub(1)?).ok().filter(|&scale| scale > 0)?;
        Some(Self {
            full_scale,
            codes_per_count: 1 << (16 - bits),
            counts_per_kelvin_q8: q8(counts_per_kelvin)?,
            temperature_noise_q8: q8(temperature_noise_counts)?,
        })
    }

    /// The lowest and the highest reading that the circuit reaches, counts: what stands there, or beyond, is no measurement. At the
    /// top the converter ends before the amplifier. At the bottom the amplifier ends first, at 20 mV at most:
    /// 80 counts of 14 bits. (A typical one goes down to 27 to 37: hardware/README.md.)
    #[must_use]
    pub fn reach(&self) -> [u16; 2] {
        let readings = u32::from(self.full_scale) + 1;
        let lowest = (readings * AMPLIFIER_LOW_MV).div_ceil(REFERENCE_MV);
        [u16::try_from(lowest).unwrap_or(u16::MAX).min(self.full_scale), self.full_scale]
    }

    /// Whether they make sense: what a device asks of a record's.
    #[must_use]
    pub(crate) fn are_sound(&self) -> bool {
        let sensible = 1..=Self::MOST_Q8;
        self.full_scale > 0
            && self.codes_per_count > 0
            && u32::from(self.full_scale) * u32::from(self.codes_per_count) <= u32::from(u16::MAX)
            && sensible.contains(&self.counts_per_kelvin_q8)
            && sensible.contains(&self.temperature_noise_q8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_numbers_are_those_of_14_bits() {
        let of_14 = BoardNumbers::new(14, 34.0, 3.0).unwrap();
        assert_eq!(of_14, BoardNumbers::PAPER);
        assert!(of_14.are_sound());
    }

    #[test]
    fn the_circuit_reaches_from_its_amplifiers_rail_to_the_converters_end() {
        let reach = |bits| BoardNumbers::new(bits, 34.0, 3.0).unwrap().reach();
        assert_eq!((reach(14), reach(16)), ([80, 16_383], [320, 65_535]));
        assert!((1..=16).all(|bits| reach(bits)[0] <= reach(bits)[1]));
    }

    #[test]
    fn what_makes_no_sense_is_no_board() {
        for (bits, per_kelvin, noise) in
            [(0, 34.0, 3.0), (17, 34.0, 3.0), (40, 34.0, 3.0), (14, 0.0, 3.0), (14, f64::NAN, 3.0), (14, 34.0, -1.0)]
        {
            assert_eq!(BoardNumbers::new(bits, per_kelvin, noise), None, "{bits} {per_kelvin} {noise}");
        }
        let of_16 = BoardNumbers::new(16, 100.0, 4.0).unwrap();
        assert_eq!((of_16.full_scale, of_16.codes_per_count), (65_535, 1));
        assert!(of_16.are_sound() && !BoardNumbers { codes_per_count: 2, ..of_16 }.are_sound());
    }
}
