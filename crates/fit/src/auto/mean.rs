//! What is deployed and what autopilots are given: means of two, by what each leaves of data that were not fitted.
//!
//! Deployed is a mean of the model by evidence and the plain cubic; exported one of the cubic nearest to that model's curve,
//! every temperature alike, and the same plain cubic. A mean of two predictions is nearer than either where they err in
//! different ways (Wolpert, *Stacked generalization*, 1992; Breiman, *Stacked regressions*, 1996: shares that are not negative).

use zerorate_core::drift::{Drift, History, Shape, Table, Term};

use crate::folds::FOLDS;
use crate::model_fit::{CUBIC, ModelFit};
use crate::nearest::nearest;
use crate::predict::{DriftModel, StartUp, TimeDrift};

/// How far a share is expected from a half, a standard deviation: both ends are one away.
const SPREAD: f64 = 0.5;

/// The mean of a model that is deployed as a table and of a plain curve, `share` of it the model's, and of their static cubics,
/// `of_cubic` the model's. `None` where it is no table.
pub(super) fn of_two(own: &ModelFit, plain: &ModelFit, share: f64, of_cubic: f64) -> Option<ModelFit> {
    let cubic = match (&own.cubic, &plain.cubic) {
        (Some(own), Some(plain)) => cubic(own, plain, of_cubic),
        _ => own.cubic.clone(),
    };
    Some(ModelFit { model: model(&own.model, &plain.model.drift, share)?, cubic, ..own.clone() })
}

/// The mean of a model and a curve. What it remembers, and what dies away after switching on, the curve does not have: so
/// much less of it is left.
fn model(own: &DriftModel, plain: &Drift, share: f64) -> Option<DriftModel> {
    let Shape::Table(table) = &own.drift.shape else { return None };
    let mean =
        |(place, knot): (usize, &f64)| share * knot + (1.0 - share) * plain.evaluate(table.knot_temperature(place)).0;
    let knots: Vec<f64> = table.knots().iter().enumerate().map(mean).collect();
    let shape = Table::new(table.scale(), &knots).map(Shape::Table)?;
    let term = |term: &Term| Term { weight: share * term.weight, behind: share * term.behind, ..*term };
    let history = own.history.as_ref().and_then(|history| {
        let terms: Vec<Term> = history.terms().iter().map(term).collect();
        History::new(shape.clone(), &terms)
    });
    let part = |part: &StartUp| StartUp { rate: share * part.rate, ..*part };
    let time_drift = own.time_drift.as_ref().map(|drift| TimeDrift {
        per_second: share * drift.per_second,
        start_up: drift.start_up.iter().map(part).collect(),
        ..*drift
    });
    Some(DriftModel { drift: Drift { shape, valid: own.drift.valid }, history, time_drift })
}

/// The mean of two cubics, `share` of it the first's, over what that is believed for.
fn cubic(own: &Drift, plain: &Drift, share: f64) -> Option<Drift> {
    let mean =
        |temperature| share * own.shape.evaluate(temperature) + (1.0 - share) * plain.shape.evaluate(temperature);
    let shape = nearest(mean, own.valid, CUBIC).map(Shape::Polynomial)?;
    Some(Drift { shape, valid: own.valid })
}

/// The first's share s, 0 to 1, in the mean that leaves least: the least of `sum (s a + (1 - s) b)^2` with a prior of s,
/// normal about a half, eight folds taken for so many observations. So where both leave the same, each has half.
pub(super) fn share(own: &[f64], plain: &[f64]) -> f64 {
    let both = || own.iter().zip(plain).filter(|(own, plain)| own.is_finite() && plain.is_finite());
    let sum = |of: fn(f64, f64) -> f64| both().map(|(own, plain)| of(*own, *plain)).sum::<f64>();
    let least = sum(|own, _| own * own).min(sum(|_, plain| plain * plain));
    let prior = least / FOLDS as f64 / SPREAD.powi(2);
    let apart = sum(|own, plain| (own - plain).powi(2));
    let share = (sum(|own, plain| (plain - own) * plain) + 0.5 * prior) / (apart + prior);
    if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 }
}

#[cfg(test)]
mod tests {
    use zerorate_core::drift::{Polynomial, Scale, ValidRange};

    use super::*;

    /// Two that leave (1, 0, ...) and (0, 2, ...) have squares of 1 and 4 and nothing in common: the least of
    /// `s^2 + 4 (1 - s)^2 + (s - 1/2)^2 / 2` is at 8.5 / 11.
    #[test]
    fn the_share_is_the_one_that_leaves_least() {
        let found = share(&[1.0, 0.0, f64::NAN, 1.0], &[0.0, 2.0, 1.0, f64::NAN]);
        assert!((found - 8.5 / 11.0).abs() < 1e-12, "{found}");
        assert!((share(&[1.0, -1.0], &[1.0, -1.0]) - 0.5).abs() < 1e-12, "what leaves the same has half");
        assert!((share(&[0.0, 0.0], &[1.0, 2.0]) - 1.0).abs() < 1e-12, "what leaves nothing has all");
        // 3 times the same error: s = (2 - 3 x 2 + 1 / 2) / (8 + 1) is below nothing.
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
