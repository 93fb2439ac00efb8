//! What is deployed and what autopilots are given: means of two, by what each leaves of data that were not fitted.
//!
//! Deployed is a mean of the model by evidence and the plain cubic; exported one of the cubic nearest to that model's curve,
//! every temperature alike, and the same plain cubic. A mean of two predictions is nearer than either where they err in
//! different ways (Wolpert, *Stacked generalization*, 1992; Breiman, *Stacked regressions*, 1996: shares that are not negative).
//! Beyond the temperatures that were seen the model goes on along its slope; the plain cubic is held there, as it is without a
//! model.

use zerorate_core::drift::{Drift, History, Shape, Table, Term, ValidRange};

use crate::folds::{FOLDS, Fold, TELLING};
use crate::model_fit::{CUBIC, ModelFit};
use crate::nearest::nearest;
use crate::predict::{DriftModel, StartUp, TimeDrift};

/// How far a share is expected from a half, a standard deviation: beyond both ends.
const SPREAD: f64 = 0.6;

/// How much of a mean is the model's.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shares {
    pub model: f64,
    pub cubic: f64,
}

/// The mean of a model that is deployed as a table and of a plain curve that is held outside of what was `seen`, and of their
/// static cubics. `None` where it is no table.
pub(super) fn of_two(own: &ModelFit, plain: &ModelFit, shares: Shares, seen: ValidRange) -> Option<ModelFit> {
    let cubic = match (&own.cubic, &plain.cubic) {
        (Some(own), Some(plain)) => cubic(own, plain, shares.cubic),
        _ => own.cubic.clone(),
    };
    Some(ModelFit { model: model(&own.model, &plain.model.drift, shares.model, seen)?, cubic, ..own.clone() })
}

/// The mean of a model and a curve. What it remembers, and what dies away after switching on, the curve does not have: so
/// much less of it is left. The curve is held from the knots on that are the first outside of `seen`: so it is as it was inside.
fn model(own: &DriftModel, plain: &Drift, share: f64, seen: ValidRange) -> Option<DriftModel> {
    let Shape::Table(table) = &own.drift.shape else { return None };
    let at: Vec<f64> = (0..table.knots().len()).map(|place| table.knot_temperature(place)).collect();
    let coldest = at.iter().rev().find(|knot| **knot <= seen.min())?;
    let hottest = at.iter().find(|knot| **knot >= seen.max())?;
    let mean =
        |(at, knot): (&f64, &f64)| share * knot + (1.0 - share) * plain.shape.evaluate(at.clamp(*coldest, *hottest));
    let knots: Vec<f64> = at.iter().zip(table.knots()).map(mean).collect();
    let shape = Table::new(table.scale(), &knots).map(Shape::Table)?;
    let term = |term: &Term| Term { weight: share * term.weight, behind: share * term.behind, ..*term };
    // Of a history that is nothing nothing is named.
    let history = own.history.as_ref().filter(|_| share > 0.0).and_then(|history| {
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

/// The share of the cubic that is nearest to the model. A part of autopilots' parameters that rests on a single fold is none:
/// without the one that speaks most for the model the others must be predicted better by it as well, by more than a twentieth.
pub(super) fn share_of_cubic(own: &[f64], plain: &[f64], folds: &[Fold]) -> f64 {
    let sum = |fold: &Fold, of: &[f64]| {
        let both = fold.rows().filter(|&group| own[group].is_finite() && plain[group].is_finite());
        both.map(|group| of[group].powi(2)).sum::<f64>()
    };
    let mut squares: Vec<(f64, f64)> = folds.iter().map(|fold| (sum(fold, own), sum(fold, plain))).collect();
    squares.sort_by(|(own, plain), (other_own, other_plain)| (own - plain).total_cmp(&(other_own - other_plain)));
    let (own_of_others, plain_of_others) =
        squares.iter().skip(1).fold((0.0, 0.0), |(own, plain), fold| (own + fold.0, plain + fold.1));
    if TELLING.powi(2) * own_of_others < plain_of_others { share(own, plain) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use zerorate_core::drift::{Memory, Polynomial, Scale};

    use super::*;

    /// Two that leave (1, 0, ...) and (0, 2, ...) have squares of 1 and 4 and nothing in common: the least of
    /// `s^2 + 4 (1 - s)^2 + (s - 1/2)^2 k`, `k = 1 / 8 / 0.36`, is at `(4 + k / 2) / (5 + k)`.
    #[test]
    fn the_share_is_the_one_that_leaves_least() {
        let found = share(&[1.0, 0.0, f64::NAN, 1.0], &[0.0, 2.0, 1.0, f64::NAN]);
        assert!((found - 4.173611111111 / 5.347222222222).abs() < 1e-12, "{found}");
        assert!((share(&[1.0, -1.0], &[1.0, -1.0]) - 0.5).abs() < 1e-12, "what leaves the same has half");
        assert!((share(&[0.0, 0.0], &[1.0, 2.0]) - 1.0).abs() < 1e-12, "what leaves nothing has all");
        // 3 times the same error: s = (2 - 3 x 2 + k) / (8 + 2 k) is below nothing.
        assert!(share(&[3.0, 3.0], &[1.0, 1.0]).abs() < 1e-12);
    }

    /// Eight folds of a group each. At first one alone is better by the model; then another is as well.
    #[test]
    fn what_a_single_fold_says_gives_the_models_cubic_no_share() {
        let folds = Fold::of_logs(std::slice::from_ref(&(0..8)));
        let mut own = [1.0; 8];
        own[0] = 0.1;
        let plain = [1.02; 8];
        assert!(share(&own, &plain) > 0.5);
        assert!(share_of_cubic(&own, &plain, &folds).abs() < 1e-12);
        own[1] = 0.1;
        assert!((share_of_cubic(&own, &plain, &folds) - share(&own, &plain)).abs() < 1e-12);
    }

    /// Knots at -40, -30 ... 40, of which -25 to 25 were seen: the curve goes on to -30 and 30.
    #[test]
    fn a_curve_is_held_beyond_what_was_seen_and_is_itself_inside() {
        let range = |min, max| ValidRange::new(min, max).expect("a range");
        let scale = Scale::spanning(-40.0, 40.0).expect("a span");
        let table = Table::new(scale, &[0.0; 9]).map(Shape::Table).expect("a table");
        let own = DriftModel::of_curve(Drift { shape: table, valid: range(-40.0, 40.0) });
        let line = Polynomial::new(scale, &[0.0, 40.0]).map(Shape::Polynomial).expect("a line");
        let plain = Drift { shape: line, valid: range(-40.0, 40.0) };
        let made = model(&own, &plain, 0.25, range(-25.0, 25.0)).expect("a mean");
        let remembering = DriftModel {
            history: History::new(
                own.drift.shape.clone(),
                &[Term { memory: Memory::Lag { time_constant_s: 30.0 }, weight: 1.0, behind: 0.0, share: 1.0 }],
            ),
            ..own.clone()
        };
        let named = |share| model(&remembering, &plain, share, range(-25.0, 25.0)).expect("a mean").to_string();
        assert_eq!((named(0.25), named(0.0)), ("table:8 + lag".to_owned(), "table:8".to_owned()));
        for (at, wanted) in [(-40.0, -22.5), (-30.0, -22.5), (-25.0, -18.75), (10.0, 7.5), (35.0, 22.5)] {
            assert!((made.drift.evaluate(at).0 - wanted).abs() < 1e-9, "at {at}: {}", made.drift.evaluate(at).0);
        }
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
