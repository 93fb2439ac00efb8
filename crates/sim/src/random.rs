//! Random streams: one per source of randomness and axis, all from one seed.
//!
//! Each source draws from a stream of its own, so that a parameter that changes how often one source is drawn leaves
//! every other source's numbers as they were.

use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use zerorate_core::units::Axis;

/// What a stream is drawn for. The number is part of the seed: never reuse one.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Source {
    UnitCurve = 1,
    UnitGyro = 2,
    UnitThermal = 3,
    UnitCircuit = 4,
    UnitSensor = 5,
    UnitBoard = 6,
    WiperSteps = 7,
    ConverterCurve = 8,
    SupplyOffset = 9,
    GyroWhite = 10,
    Flicker = 11,
    RateWalk = 12,
    TurnOn = 13,
    CircuitNoise = 14,
    SensorNoise = 15,
    BetweenScans = 16,
}

/// One stream of random numbers.
#[derive(Debug, Clone)]
pub(crate) struct Stream(Xoshiro256PlusPlus);

impl Stream {
    /// The stream of a source that each axis has of its own.
    pub(crate) fn of_axis(seed: u64, source: Source, axis: Axis) -> Self {
        Self::numbered(seed, source as u64 * 4 + 1 + axis.index() as u64)
    }

    /// The stream of a source that the board has once.
    pub(crate) fn of_board(seed: u64, source: Source) -> Self {
        Self::numbered(seed, source as u64 * 4)
    }

    fn numbered(seed: u64, number: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(scramble(scramble(seed) ^ number)))
    }

    /// A draw from the standard normal distribution.
    #[inline]
    pub(crate) fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// A uniform draw between two bounds.
    pub(crate) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..high)
    }

    /// A uniform draw of one of `count` things.
    pub(crate) fn pick(&mut self, count: usize) -> usize {
        self.0.random_range(0..count)
    }
}

/// The output function of SplitMix64 (Steele, Lea and Flood, 2014): a bijection that spreads every bit of its input, so
/// that neighbouring seeds and neighbouring streams have nothing in common.
fn scramble(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_repeats_by_its_seed_and_differs_by_seed_source_and_axis() {
        let first = |mut stream: Stream| stream.normal().to_bits();
        let reference = first(Stream::of_axis(1, Source::Flicker, Axis::X));
        assert_eq!(reference, first(Stream::of_axis(1, Source::Flicker, Axis::X)));
        assert_ne!(reference, first(Stream::of_axis(2, Source::Flicker, Axis::X)));
        assert_ne!(reference, first(Stream::of_axis(1, Source::Flicker, Axis::Y)));
        assert_ne!(reference, first(Stream::of_axis(1, Source::TurnOn, Axis::X)));
        assert_ne!(reference, first(Stream::of_board(1, Source::Flicker)));
    }
}
