//! Samples that are means of several conversions: their rounding, and noise between the scans.
//!
//! A scan's last pass is where its only one would be, and so is all that is drawn for it: a unit has the same noise at its
//! scans whatever the ratio. What noise does in the passes before is drawn from a stream of its own, between the scan before and
//! this one. Noise behind a low-pass that is known at both ends is a bridge: normal, with a mean between the ends.

/// The greatest ratio (docs/acquisition-port.md).
pub(crate) const MOST_PASSES: u32 = 16;

/// A sum of so many conversions as a sample: the nearest count, from a half the even one.
#[allow(clippy::cast_possible_truncation)] // A mean of 16 bits has 16 bits.
pub(crate) fn mean(sum: u32, passes: u32) -> u16 {
    let (whole, rest) = (sum / passes, sum % passes);
    let goes_up = 2 * rest > passes || (2 * rest == passes && whole % 2 == 1);
    (whole + u32::from(goes_up)) as u16
}

/// A pass of a scan, numbered from 1, of so many that are evenly spread over a period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Pass {
    pub(crate) number: u32,
    pub(crate) of: u32,
    /// When the scan's last pass is, and from scan to scan.
    pub(crate) scan_ns: u64,
    pub(crate) period_ns: u64,
}

impl Pass {
    /// When it is.
    pub(crate) fn at_ns(self) -> u64 {
        self.scan_ns - self.period_ns * u64::from(self.of - self.number) / u64::from(self.of)
    }

    pub(crate) fn is_first(self) -> bool {
        self.number == 1
    }

    pub(crate) fn is_last(self) -> bool {
        self.number == self.of
    }
}

/// Noise on its way from one scan to the next.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Underway {
    pub(crate) now: f64,
    pub(crate) end: f64,
}

/// How noise of deviation 1 behind a low-pass comes from where it is to a pass, its end being known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bridge {
    keeps: f64,
    nears: f64,
    drawn: f64,
}

impl Bridge {
    /// By what the low-pass leaves of a difference up to the pass, and from there to the end.
    ///
    /// Of three normal values with the correlations `a`, `b` and `a b` the middle one, given the outer two.
    pub(crate) fn between(a: f64, b: f64) -> Self {
        let outer = 1.0 - a * a * b * b;
        Self {
            keeps: a * (1.0 - b * b) / outer,
            nears: b * (1.0 - a * a) / outer,
            drawn: ((1.0 - a * a) * (1.0 - b * b) / outer).sqrt(),
        }
    }
}

impl Underway {
    /// Goes on to a pass; `drawn` is what is drawn for it, at the noise's deviation.
    pub(crate) fn cross(&mut self, bridge: Bridge, drawn: f64) -> f64 {
        self.now = bridge.keeps * self.now + bridge.nears * self.end + bridge.drawn * drawn;
        self.now
    }

    /// Goes on to the scan's last pass.
    pub(crate) fn arrive(&mut self) -> f64 {
        self.now = self.end;
        self.now
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Source, Stream};
    use zerorate_core::units::Axis;

    #[test]
    fn a_mean_is_rounded_to_the_nearest_count_and_from_a_half_to_the_even_one() {
        for passes in [1, 2, 4, 8, 16] {
            for sum in 0..10_000 {
                let expected = (f64::from(sum) / f64::from(passes)).round_ties_even();
                assert!((f64::from(mean(sum, passes)) - expected).abs() < 1e-9, "{sum} of {passes}");
            }
            assert_eq!(mean(65_535 * passes, passes), 65_535);
        }
    }

    #[test]
    fn passes_end_where_the_scan_is() {
        let at = |number| Pass { number, of: 16, scan_ns: 9_000_000, period_ns: 3_000_000 }.at_ns();
        assert_eq!([at(1), at(8), at(16)], [6_187_500, 7_500_000, 9_000_000]);
    }

    /// Against the definition: noise behind a low-pass is correlated by what the low-pass leaves of a difference.
    #[test]
    fn noise_between_two_scans_is_as_noise_behind_a_low_pass_is() {
        let mut stream = Stream::of_axis(4, Source::BetweenScans, Axis::X);
        let left = |ms: f64| (-ms * 0.25).exp();
        let (mut variance, mut products) = ([0.0; 3], [0.0; 3]);
        let count = 200_000;
        for _ in 0..count {
            let mut noise = Underway { now: stream.normal(), end: 0.0 };
            let from = noise.now;
            noise.end = from * left(3.0) + (1.0 - left(6.0)).sqrt() * stream.normal();
            let one = noise.cross(Bridge::between(left(1.0), left(2.0)), stream.normal());
            let two = noise.cross(Bridge::between(left(1.0), left(1.0)), stream.normal());
            let end = noise.arrive();
            for (sum, value) in variance.iter_mut().zip([one, two, end]) {
                *sum += value * value / f64::from(count);
            }
            for (sum, product) in products.iter_mut().zip([from * one, one * two, one * end]) {
                *sum += product / f64::from(count);
            }
        }
        assert!(variance.iter().all(|variance| (variance - 1.0).abs() < 0.01), "{variance:?}");
        let expected = [left(1.0), left(1.0), left(2.0)];
        assert!(products.iter().zip(expected).all(|(product, e)| (product - e).abs() < 0.01), "{products:?}");
    }
}
