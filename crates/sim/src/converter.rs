//! The A/D converter's analogue side: volts in, counts out. The part is the AD7949 (Analog Devices, Rev. E: 14 bits,
//! eight channels, 250 kSPS); its serial side is in `ad7949.rs`.

use crate::gyro::ROOM_C;
use crate::random::{Source, Stream};

/// The converter's constants.
#[derive(Debug, Clone, PartialEq)]
pub struct ConverterParameters {
    /// Its bits. Default 14; 16 stands for another part, which is driven alike.
    pub bits: u32,
    /// The external reference in volts at 25 C. Default 4.096: exactly 250 uV a count.
    pub reference_v: f64,
    /// The reference's relative change per kelvin. Default 2e-6 (ADR4540B: 2 ppm/C at most).
    pub reference_tempco_per_k: f64,
    /// The largest integral error in counts. Default 1 (data sheet: +-0.5 LSB typical, +-1 LSB at most); the shape, a
    /// cubic that is zero at both ends, is drawn.
    pub inl_lsb: f64,
    /// Input noise in counts rms. Default 0.15 (from the sheet's 85.5 dB, quantisation taken out).
    pub noise_lsb: f64,
}

impl ConverterParameters {
    /// Its counts: readings are below.
    pub(crate) fn counts(&self) -> f64 {
        f64::from(1_u32 << self.bits.min(16))
    }
}

impl Default for ConverterParameters {
    fn default() -> Self {
        Self { bits: 14, reference_v: 4.096, reference_tempco_per_k: 2e-6, inl_lsb: 1.0, noise_lsb: 0.15 }
    }
}

/// One converter.
#[derive(Debug, Clone)]
pub(crate) struct Converter {
    parameters: ConverterParameters,
    /// The integral error's shape in counts: `(1 - x^2) (even + odd x)`, x from -1 to 1 over the range.
    even: f64,
    odd: f64,
    counts: f64,
    counts_per_volt: f64,
}

impl Converter {
    pub(crate) fn new(parameters: ConverterParameters, seed: u64) -> Self {
        let mut stream = Stream::of_board(seed, Source::ConverterCurve);
        // (1 - x^2) is at most 1 and (1 - x^2) x at most 0.385, so these two together stay within the limit.
        let even = parameters.inl_lsb * stream.uniform(-0.6, 0.6);
        let odd = parameters.inl_lsb * stream.uniform(-1.0, 1.0);
        let counts = parameters.counts();
        let counts_per_volt = counts / parameters.reference_v;
        Self { parameters, even, odd, counts, counts_per_volt }
    }

    /// Takes the reference to the board's temperature.
    pub(crate) fn warm(&mut self, board_c: f64) {
        let reference_v =
            self.parameters.reference_v * (1.0 + self.parameters.reference_tempco_per_k * (board_c - ROOM_C));
        self.counts_per_volt = self.counts / reference_v;
    }

    /// The converter's own noise in volts rms.
    pub(crate) fn noise_v(&self) -> f64 {
        self.parameters.noise_lsb * self.parameters.reference_v / self.counts
    }

    /// What a converter without steps would read: the integral error and the range's ends are in it. In counts.
    #[inline]
    pub(crate) fn stepless(&self, volts: f64) -> f64 {
        let counts = (volts * self.counts_per_volt).clamp(0.0, self.counts - 1.0);
        let x = counts * (2.0 / self.counts) - 1.0;
        (counts + (1.0 - x * x) * (self.even + self.odd * x)).clamp(0.0, self.counts - 1.0)
    }

    /// A conversion: straight binary, 0 to all ones.
    #[inline]
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // The clamp of `stepless` makes the cast exact.
    pub(crate) fn convert(&self, volts: f64) -> u16 {
        (self.stepless(volts) + 0.5) as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_count_is_250_microvolts_and_the_ends_clip() {
        let exact = ConverterParameters { inl_lsb: 0.0, ..ConverterParameters::default() };
        let converter = Converter::new(exact, 1);
        assert_eq!(converter.convert(2.05), 8200);
        assert_eq!(converter.convert(2.05 + 250e-6), 8201);
        assert_eq!((converter.convert(-1.0), converter.convert(5.0)), (0, 16_383));
        for seed in 0..20 {
            let converter = Converter::new(ConverterParameters::default(), seed);
            assert_eq!((converter.convert(f64::MIN), converter.convert(f64::MAX)), (0, 16_383), "seed {seed}");
        }
    }

    #[test]
    fn the_integral_error_stays_within_one_count_and_is_smooth() {
        for seed in 0..50 {
            let converter = Converter::new(ConverterParameters::default(), seed);
            let error = |counts: u32| {
                let counts = f64::from(counts);
                converter.stepless(counts * 250e-6) - counts
            };
            for counts in 1..16_000 {
                assert!(error(counts).abs() <= 1.0);
                assert!((error(counts + 1) - error(counts)).abs() < 0.001);
            }
        }
    }

    #[test]
    fn a_warm_reference_reads_less() {
        let mut converter = Converter::new(ConverterParameters { inl_lsb: 0.0, ..ConverterParameters::default() }, 1);
        converter.warm(125.0);
        assert!((converter.stepless(2.05) - 8200.0 / 1.0002).abs() < 1e-6);
    }
}
