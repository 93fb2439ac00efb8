//! The cubic for autopilots: a mean of two, by what each leaves of data that were not fitted.
//!
//! One is the nearest to the curve of the model by evidence, every temperature alike; the other a plain fit of the rates. A mean
//! of two predictions is nearer than either where they err in different ways (Wolpert, *Stacked generalization*, 1992; Breiman,
//! *Stacked regressions*, 1996: shares that are not negative).

use zerorate_core::drift::{Drift, Shape};

use crate::folds::FOLDS;
use crate::model_fit::CUBIC;
use crate::nearest::nearest;

/// The mean of two cubics, `share` of it the first's, over what that is believed for.
pub(super) fn cubic(own: &Drift, plain: &Drift, share: f64) -> Option<Drift> {
    let mean =
        |temperature| share * own.shape.evaluate(temperature) + (1.0 - share) * plain.shape.evaluate(temperature);
    let shape = nearest(mean, own.valid, CUBIC).map(Shape::Polynomial)?;
    Some(Drift { shape, valid: own.valid })
}

/// The mean of what is left by two.
pub(super) fn left(own: &[f64], plain: &[f64], share: f64) -> Vec<f64> {
    own.iter().zip(plain).map(|(own, plain)| share * own + (1.0 - share) * plain).collect()
}

/// The first's share s, 0 to 1, in the mean that leaves least: the least of `sum (s a + (1 - s) b)^2` with a prior of s,
/// normal about a half with a deviation of 1, eight folds taken for so many observations. So where both leave the same, each has
/// half.
pub(super) fn share(own: &[f64], plain: &[f64]) -> f64 {
    let both = || own.iter().zip(plain).filter(|(own, plain)| own.is_finite() && plain.is_finite());
    let sum = |of: fn(f64, f64) -> f64| both().map(|(own, plain)| of(*own, *plain)).sum::<f64>();
    let prior = sum(|own, _| own * own).min(sum(|_, plain| plain * plain)) / FOLDS as f64;
    let apart = sum(|own, plain| (own - plain).powi(2));
    let share = (sum(|own, plain| (plain - own) * plain) + 0.5 * prior) / (apart + prior);
    if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 }
}

#[cfg(test)]
mod tests {
    use zerorate_core::drift::{Polynomial, Scale, ValidRange};

    use super::*;

    /// Two that leave (1, 0, ...) and (0, 2, ...) have squares of 1 and 4 and nothing in common: the least of
    /// `s^2 + 4 (1 - s)^2 + (s - 1/2)^2 / 8` is at 4.0625 / 5.125.
    #[test]
    fn the_share_is_the_one_that_leaves_least() {
        let found = share(&[1.0, 0.0, f64::NAN, 1.0], &[0.0, 2.0, 1.0, f64::NAN]);
        assert!((found - 4.0625 / 5.125).abs() < 1e-12, "{found}");
        assert!((share(&[1.0, -1.0], &[1.0, -1.0]) - 0.5).abs() < 1e-12, "what leaves the same has half");
        assert!((share(&[0.0, 0.0], &[1.0, 2.0]) - 1.0).abs() < 1e-12, "what leaves nothing has all");
        // 3 times the same error: s = (2 - 3 x 2 + 1 / 8) / (8 + 1 / 4) is below nothing.
        assert!(share(&[3.0, 3.0], &[1.0, 1.0]).abs() < 1e-12);
    }

    #[test]
    fn the_mean_of_two_cubics_is_their_mean_at_every_temperature() {
        let valid = ValidRange::new(-20.0, 60.0).expect("a range");
        let scale = Scale::spanning(-20.0, 60.0).expect("a span");
        let drift = |coefficients: &[f64]| {
            let shape = Polynomial::new(scale, coefficients).map(Shape::Polynomial).expect("a polynomial");
            Drift { shape, valid }
        };
        let (own, plain) = (drift(&[3.0, 0.0, -2.0, 8.0]), drift(&[1.0, 4.0]));
        let made = cubic(&own, &plain, 0.25).expect("a cubic");
        for temperature in [-20.0, 3.0, 31.0, 60.0] {
            let mean = 0.25 * own.evaluate(temperature).0 + 0.75 * plain.evaluate(temperature).0;
            assert!((made.evaluate(temperature).0 - mean).abs() < 1e-9, "at {temperature}");
        }
    }
}
