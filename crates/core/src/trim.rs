//! The trim part's model: how far a tap moves the reading, and which tap brings a reading to the centre.
//!
//! The paper's black-box experiment (S8, eq. 2 to 5) gives a straight line, `dN = a dV + b`; sweeping every tap of the
//! working range once gives, beside it, what each tap adds to the line: the part's own unevenness.

use heapless::Vec;

use crate::units::{Counts, Taps};

/// The most taps whose own offsets a model holds.
pub const MAX_TAP_OFFSETS: usize = 96;

/// The straight line of eq. (2): `N - N0 = a (V - V0) + b`.
///
/// Sign convention: `a` is negative, since a higher tap raises the reading; one tap is `-1/a` counts (+31.26 on the
/// paper's X axis).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrimLine {
    slope_taps_per_count: f64,
    intercept_taps: f64,
    centre: Counts,
    middle: Taps,
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

/// What each tap of the working range really adds to the reading at the middle tap, as measured: rising from tap to
/// tap, so that a reading has one nearest tap.
#[derive(Debug, Clone, PartialEq)]
pub struct TapEffects {
    first: Taps,
    effects: Vec<Counts, MAX_TAP_OFFSETS>,
}

impl TapEffects {
    /// The effects of the taps from `first` on: each tap's reading less the middle tap's, at one input. `None` unless
    /// there are 1 to 96, they are finite and rise from tap to tap, and the last is a tap of the part.
    #[must_use]
    pub fn new(first: Taps, effects: &[Counts]) -> Option<Self> {
        let last = u16::try_from(effects.len().checked_sub(1)?).ok()?;
        Taps::new(first.get().checked_add(last)?)?;
        let sound = effects.iter().all(|e| e.0.is_finite()) && effects.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let effects = Vec::from_slice(effects).ok().filter(|_| sound)?;
        Some(Self { first, effects })
    }

    /// The first tap measured.
    #[must_use]
    pub const fn first(&self) -> Taps {
        self.first
    }

    /// The reading at each tap from the first on, less the reading at the middle tap.
    #[must_use]
    pub fn effects(&self) -> &[Counts] {
        &self.effects
    }

    /// The measured effect of a tap; `None` for a tap that was not swept.
    #[must_use]
    pub fn get(&self, tap: Taps) -> Option<Counts> {
        let index = tap.get().checked_sub(self.first.get())?;
        self.effects.get(usize::from(index)).copied()
    }

    /// The effect of a tap; beyond the taps measured it goes on from the nearer end by `per_tap` counts a tap.
    #[must_use]
    pub fn effect(&self, tap: Taps, per_tap: Counts) -> Counts {
        let offset = usize::from(tap.get().saturating_sub(self.first.get()));
        let nearest = offset.min(self.effects.len() - 1);
        let measured = f64::from(self.first.get()) + as_f64(nearest);
        self.effects[nearest] + per_tap * (f64::from(tap.get()) - measured)
    }

    /// The wiper position, a real number of taps, that has an effect: straight lines between the taps measured, and on
    /// from the nearer end by `per_tap` counts a tap.
    #[must_use]
    pub fn position(&self, effect: Counts, per_tap: Counts) -> f64 {
        let first = f64::from(self.first.get());
        let above = self.effects.partition_point(|measured| measured.0 <= effect.0);
        if above == 0 {
            return first + (effect - self.effects[0]).0 / per_tap.0;
        }
        let below = self.effects[above - 1];
        let step = self.effects.get(above).map_or(per_tap, |&next| next - below);
        first + as_f64(above - 1) + (effect - below).0 / step.0
    }
}

#[allow(clippy::cast_precision_loss)] // taps are few
fn as_f64(index: usize) -> f64 {
    index as f64
}

/// The trim model: the line, and the measured effects where there are any.
#[derive(Debug, Clone, PartialEq)]
pub struct Trim {
    /// Eq. (2).
    pub line: TrimLine,
    /// What each tap does, where every tap of the working range was measured. A part's taps are uneven: a line through
    /// them is off by several counts here and there, and so would be a tap chosen by it.
    pub measured: Option<TapEffects>,
}

impl Trim {
    /// The wiper position, a real number of taps, that brings a reading of `zro` at the middle tap to the centre: where
    /// the measured effect is `V0 - V`, or by eq. (6) without measured effects.
    #[must_use]
    pub fn position(&self, zro: Counts) -> f64 {
        match &self.measured {
            Some(measured) => measured.position(self.line.centre - zro, self.line.counts_per_tap()),
            None => self.line.position(zro),
        }
    }

    /// What a tap adds to the reading at the middle tap: as measured, or by the line's slope (without its intercept: the
    /// middle tap adds nothing to itself).
    #[must_use]
    pub fn effect(&self, tap: Taps) -> Counts {
        match &self.measured {
            Some(measured) => measured.effect(tap, self.line.counts_per_tap()),
            None => self.line.effect(tap) - self.line.effect(self.line.middle),
        }
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

    fn uneven() -> Trim {
        let first = Taps::new(510).unwrap();
        let measured = TapEffects::new(first, &[Counts(-33.0), Counts(0.0), Counts(30.0)]);
        Trim { line: paper_x(), measured }
    }

    #[test]
    fn a_measured_tap_is_believed_before_the_line() {
        let trim = uneven();
        let effect = |tap| trim.effect(Taps::new(tap).unwrap()).0;
        let per_tap = trim.line.counts_per_tap().0;
        assert!((effect(510) + 33.0).abs() < 1e-9 && effect(511).abs() < 1e-9);
        assert!((effect(508) - (-33.0 - 2.0 * per_tap)).abs() < 1e-9, "on from the end");
        assert!((effect(514) - (30.0 + 2.0 * per_tap)).abs() < 1e-9, "on from the end");
    }

    #[test]
    fn the_position_is_where_the_effect_brings_the_reading_to_the_centre() {
        let trim = uneven();
        let position = |from_centre: f64| trim.position(trim.line.centre() + Counts(from_centre));
        assert!((position(33.0) - 510.0).abs() < 1e-9);
        assert!((position(16.5) - 510.5).abs() < 1e-9, "half way between two taps' effects");
        assert!((position(-15.0) - 511.5).abs() < 1e-9);
        for tap in (500..=520).filter_map(Taps::new) {
            assert!((position(-trim.effect(tap).0) - f64::from(tap.get())).abs() < 1e-9);
        }
    }

    #[test]
    fn effects_that_do_not_rise_cannot_be_built() {
        let first = Taps::new(1022).unwrap();
        let build =
            |effects: &[f64]| TapEffects::new(first, &effects.iter().map(|&e| Counts(e)).collect::<std::vec::Vec<_>>());
        assert!(build(&[0.0, 31.0]).is_some());
        assert!(build(&[]).is_none() && build(&[0.0, 0.0]).is_none() && build(&[0.0, f64::NAN]).is_none());
        assert!(build(&[0.0, 31.0, 62.0]).is_none(), "there is no tap 1024");
    }

    #[test]
    fn a_slope_of_the_wrong_sign_is_refused() {
        assert!(TrimLine::new(0.03, 0.0, Counts(8200.0), Taps::MIDDLE).is_none());
        assert!(TrimLine::new(-0.03, f64::NAN, Counts(8200.0), Taps::MIDDLE).is_none());
    }
}
