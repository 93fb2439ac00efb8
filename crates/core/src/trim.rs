//! The trim part's model: how far a tap moves the reading, and which tap brings a reading to the centre.
//!
//! The paper's black-box experiment (S8, eq. 2 to 5) gives a straight line, `dN = a dV + b`; sweeping every tap of the
//! working range once gives, beside it, what each tap adds to the line: the part's own unevenness.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::units::{Counts, Taps};

/// The most taps whose own offsets a model holds.
pub const MAX_TAP_OFFSETS: usize = 96;

/// The straight line of eq. (2): `N - N0 = a (V - V0) + b`.
///
/// Sign convention: `a` is negative, since a higher tap raises the reading; one tap is `-1/a` counts (+31.26 on the
/// paper's X axis).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawTrimLine")]
pub struct TrimLine {
    slope_taps_per_count: f64,
    intercept_taps: f64,
    centre: Counts,
    middle: Taps,
}

/// A trim line as stored, before it is checked.
#[derive(Deserialize)]
struct RawTrimLine {
    slope_taps_per_count: f64,
    intercept_taps: f64,
    centre: Counts,
    middle: Taps,
}

impl TryFrom<RawTrimLine> for TrimLine {
    type Error = &'static str;
    fn try_from(raw: RawTrimLine) -> Result<Self, Self::Error> {
        Self::new(raw.slope_taps_per_count, raw.intercept_taps, raw.centre, raw.middle)
            .ok_or("a trim line needs finite numbers and a slope below zero")
    }
}

impl TrimLine {
    /// A trim line: slope `a` in taps per count (below zero), intercept `b` in taps, centre `V0`, middle tap `N0`.
    /// `None` unless all are finite and the slope is below zero.
    #[must_use]
    pub fn new(slope_taps_per_count: f64, intercept_taps: f64, centre: Counts, middle: Taps) -> Option<Self> {
        let finite = slope_taps_per_count.is_finite() && intercept_taps.is_finite() && centre.0.is_finite();
        (finite && slope_taps_per_count < 0.0).then_some(Self { slope_taps_per_count, intercept_taps, centre, middle })
    }

    /// `a`, taps per count.
    #[must_use]
    pub const fn slope_taps_per_count(&self) -> f64 {
        self.slope_taps_per_count
    }

    /// `b`, taps.
    #[must_use]
    pub const fn intercept_taps(&self) -> f64 {
        self.intercept_taps
    }

    /// `V0`, the reading aimed at.
    #[must_use]
    pub const fn centre(&self) -> Counts {
        self.centre
    }

    /// `N0`, the tap at which the drift was measured.
    #[must_use]
    pub const fn middle(&self) -> Taps {
        self.middle
    }

    /// How far one tap moves the reading: `-1/a`.
    #[must_use]
    pub fn counts_per_tap(&self) -> Counts {
        Counts(-1.0 / self.slope_taps_per_count)
    }

    /// The wiper position, a real number of taps, that brings a reading of `zro` at the middle tap to the centre:
    /// `N = N0 + a (V - V0) + b` (eq. 6).
    #[must_use]
    pub fn position(&self, zro: Counts) -> f64 {
        f64::from(self.middle.get()) + self.slope_taps_per_count * (zro.0 - self.centre.0) + self.intercept_taps
    }

    /// What the line says a tap adds to the reading at the middle tap: the inverse of eq. (2), so that
    /// `V + effect(N) = V0` where `position(V) = N`.
    #[must_use]
    pub fn effect(&self, tap: Taps) -> Counts {
        let shift = f64::from(tap.get()) - f64::from(self.middle.get());
        Counts((self.intercept_taps - shift) / self.slope_taps_per_count)
    }
}

/// What each tap of the working range really adds to the reading at the middle tap, as measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TapEffects {
    /// The first tap measured.
    pub first: Taps,
    /// The reading at each tap from `first` on, less the reading at the middle tap.
    pub effects: Vec<Counts, MAX_TAP_OFFSETS>,
}

impl TapEffects {
    /// The measured effect of a tap; `None` outside the range that was swept.
    #[must_use]
    pub fn get(&self, tap: Taps) -> Option<Counts> {
        let index = tap.get().checked_sub(self.first.get())?;
        self.effects.get(usize::from(index)).copied()
    }
}

/// The trim model: the line, and the measured effects where there are any.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trim {
    /// Eq. (2): chooses the tap.
    pub line: TrimLine,
    /// What each tap does, for the digital remainder; without them the line answers.
    pub measured: Option<TapEffects>,
}

impl Trim {
    /// What a tap adds to the reading at the middle tap: as measured where the tap was swept, else by the line's
    /// slope (without its intercept: the middle tap adds nothing to itself).
    #[must_use]
    pub fn effect(&self, tap: Taps) -> Counts {
        let measured = self.measured.as_ref().and_then(|effects| effects.get(tap));
        measured.unwrap_or_else(|| self.line.effect(tap) - self.line.effect(self.line.middle))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paper_x() -> TrimLine {
        TrimLine::new(-0.031_990_6, -0.274_587, Counts(8203.3), Taps::MIDDLE).unwrap()
    }

    #[test]
    fn one_tap_of_the_paper_is_31_26_counts() {
        assert!((paper_x().counts_per_tap().0 - 31.26).abs() < 0.005);
    }

    #[test]
    fn the_effect_of_a_tap_undoes_the_position_for_a_reading() {
        let line = paper_x();
        let zro = Counts(8541.0);
        let position = line.position(zro);
        let below = Taps::new(500).unwrap();
        // 8541 is 337.7 above the centre: 10.8 taps down, and 0.27 more by the intercept.
        assert!((position - (511.0 - 337.7 * 0.031_990_6 - 0.274_587)).abs() < 1e-9);
        let left = zro + line.effect(below) - line.centre();
        assert!((left.0 - (500.0 - position) * line.counts_per_tap().0).abs() < 1e-9);
    }

    #[test]
    fn a_measured_tap_is_believed_before_the_line() {
        let first = Taps::new(510).unwrap();
        let effects = Vec::from_slice(&[Counts(-33.0), Counts(0.0)]).unwrap();
        let trim = Trim { line: paper_x(), measured: Some(TapEffects { first, effects }) };
        assert_eq!(trim.effect(first), Counts(-33.0));
        assert_eq!(trim.effect(Taps::MIDDLE), Counts(0.0));
        let outside = trim.effect(Taps::new(509).unwrap());
        assert!((outside.0 + 2.0 * trim.line.counts_per_tap().0).abs() < 1e-9);
    }

    #[test]
    fn a_slope_of_the_wrong_sign_is_refused() {
        assert!(TrimLine::new(0.03, 0.0, Counts(8200.0), Taps::MIDDLE).is_none());
        assert!(TrimLine::new(-0.03, f64::NAN, Counts(8200.0), Taps::MIDDLE).is_none());
    }
}
