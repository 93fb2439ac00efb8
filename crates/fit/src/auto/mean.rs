//! The mean of the model by evidence and the plain cubic, by what each leaves of data that were not fitted.
//!
//! A mean of two predictions is nearer than either where they err in different ways (Wolpert, *Stacked generalization*, 1992;
//! Breiman, *Stacked regressions*, 1996: shares that are not negative).

use nalgebra::DMatrix;
use zerorate_core::drift::{Drift, History, Polynomial, Shape, Table, Term};

use super::nested::Outer;
use crate::folds::FOLDS;
use crate::model_fit::{CUBIC, ModelFit, rows};
use crate::nearest::nearest;
use crate::predict::{DriftModel, StartUp, TimeDrift};

/// How much of the mean is the model by evidence, 0 to 1; the rest is the plain cubic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shares {
    /// Of the model.
    pub model: f64,
    /// Of the static cubic beside it, which autopilots have.
    pub cubic: f64,
}

impl Shares {
    /// The ones by which least is left, as deployed. `None` where either could not predict every fold, or the model is worth
    /// nothing beside the cubic.
    pub(super) fn of(own: &Outer, plain: &Outer) -> Option<Self> {
        let known = own.complete() && plain.complete();
        let shares =
            Self { model: share(own.warm(), plain.warm()), cubic: share(own.cubic_deployed(), plain.cubic_deployed()) };
        (known && shares.model > 0.0).then_some(shares)
    }

    /// The mean of two fits. `None` where the plain one is no polynomial, or the other no table.
    pub(super) fn fit(self, own: &ModelFit, plain: &ModelFit) -> Option<ModelFit> {
        let (Shape::Table(table), Shape::Polynomial(curve)) = (&own.model.drift.shape, &plain.model.drift.shape) else {
            return None;
        };
        let DriftModel { history, time_drift, .. } = &own.model;
        let plain_knots: Vec<f64> =
            (0..table.knots().len()).map(|knot| curve.evaluate(table.knot_temperature(knot))).collect();
        let knots = mixed(table.knots(), &plain_knots, self.model);
        let shape = Shape::Table(Table::new(table.scale(), &knots)?);
        let terms = |history: &History| -> Vec<Term> {
            history.terms().iter().map(|term| Term { weight: self.model * term.weight, ..*term }).collect()
        };
        let history = history.as_ref().and_then(|history| History::new(shape.clone(), &terms(history)));
        let time_drift = time_drift.as_ref().map(|drift| self.time_drift(drift));
        let cubic = own.cubic.as_ref().zip(plain.cubic.as_ref()).and_then(|(own, plain)| self.cubic(own, plain));
        let model = DriftModel { drift: Drift { shape, valid: own.model.drift.valid }, history, time_drift };
        Some(ModelFit { model, cubic, covariance: self.covariance(own, plain, table, curve) })
    }

    /// The mean of two static cubics, over what the first is believed for.
    pub(super) fn cubic(self, own: &Drift, plain: &Drift) -> Option<Drift> {
        let at = |drift: &Drift, temperature: f64| drift.shape.evaluate(temperature);
        let mean = |temperature| self.cubic * at(own, temperature) + (1.0 - self.cubic) * at(plain, temperature);
        let shape = nearest(mean, own.valid, CUBIC).map(Shape::Polynomial)?;
        Some(Drift { shape, valid: own.valid })
    }

    fn time_drift(self, drift: &TimeDrift) -> TimeDrift {
        let part = |part: &StartUp| StartUp { rate: self.model * part.rate, ..*part };
        TimeDrift {
            per_second: self.model * drift.per_second,
            start_up: drift.start_up.iter().map(part).collect(),
            ..*drift
        }
    }

    /// Of the knots, at most: the variance of a mean is no more than the mean of the variances, whatever the two have in
    /// common.
    fn covariance(self, own: &ModelFit, plain: &ModelFit, table: &Table, curve: &Polynomial) -> Vec<Vec<f64>> {
        let matrix = |rows: &[Vec<f64>]| DMatrix::from_fn(rows.len(), rows.len(), |row, column| rows[row][column]);
        let x = |knot: usize| curve.scale().x(table.knot_temperature(knot));
        // A cubic's error is that of its coefficients, each times its power.
        #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)]
        let powers = DMatrix::from_fn(table.knots().len(), plain.covariance.len(), |knot, k| x(knot).powi(k as i32));
        let plain = &powers * matrix(&plain.covariance) * powers.transpose();
        rows(&(matrix(&own.covariance) * self.model + plain * (1.0 - self.model)))
    }
}

/// The mean of what is left by two models, the first's share given.
pub(super) fn mixed(own: &[f64], plain: &[f64], share: f64) -> Vec<f64> {
    own.iter().zip(plain).map(|(own, plain)| share * own + (1.0 - share) * plain).collect()
}

/// The first's share s, 0 to 1, in the mean that leaves least: the least of `sum (s a + (1 - s) b)^2` with a prior of s,
/// normal about a half with a deviation of 1, eight folds taken for so many observations. So where both leave the same, each has
/// half.
fn share(own: &[f64], plain: &[f64]) -> f64 {
    let both = || own.iter().zip(plain).filter(|(own, plain)| own.is_finite() && plain.is_finite());
    let sum = |of: fn(f64, f64) -> f64| both().map(|(own, plain)| of(*own, *plain)).sum::<f64>();
    let prior = sum(|own, _| own * own).min(sum(|_, plain| plain * plain)) / FOLDS as f64;
    let apart = sum(|own, plain| (own - plain).powi(2));
    let share = (sum(|own, plain| (plain - own) * plain) + 0.5 * prior) / (apart + prior);
    if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 }
}

#[cfg(test)]
mod tests {
    use zerorate_core::drift::{Memory, Scale, ValidRange};

    use super::*;

    /// Two that leave (1, 0, ...) and (0, 2, ...) have squares of 1 and 4 and nothing in common: the least of
    /// `s^2 + 4 (1 - s)^2 + (s - 1/2)^2 / 8` is at 4.0625 / 5.125.
    #[test]
    fn the_share_is_the_one_that_leaves_least() {
        let found = share(&[1.0, 0.0, f64::NAN, 1.0], &[0.0, 2.0, 1.0, f64::NAN]);
        assert!((found - 4.0625 / 5.125).abs() < 1e-12, "{found}");
        assert!((share(&[1.0, -1.0], &[1.0, -1.0]) - 0.5).abs() < 1e-12, "what leaves the same has half");
        assert!((share(&[0.0, 0.0], &[1.0, 2.0]) - 1.0).abs() < 1e-12, "what leaves nothing has all");
        // 3 times the same error: s = (1 - 3 x 1 + 1 / 16) / (4 + 1 / 8) is below nothing.
        assert!(share(&[3.0, 3.0], &[1.0, 1.0]).abs() < 1e-12);
    }

    #[test]
    fn a_mean_predicts_the_mean_of_what_both_predict() {
        let valid = ValidRange::new(-20.0, 60.0).unwrap();
        let scale = Scale::spanning(-20.0, 60.0).unwrap();
        let knots: Vec<f64> = (0..=32).map(|knot| f64::from(knot * knot % 7)).collect();
        let table = Shape::Table(Table::new(scale, &knots).unwrap());
        let play = Term { memory: Memory::Play { half_width: 5.0 }, weight: 0.3, share: 1.0 };
        let line = Drift { shape: Shape::Polynomial(Polynomial::new(scale, &[1.0, 4.0]).unwrap()), valid };
        let cubic = Drift { shape: Shape::Polynomial(Polynomial::new(scale, &[3.0, 0.0, -2.0, 8.0]).unwrap()), valid };
        let identity = |size: usize, variance: f64| rows(&(DMatrix::identity(size, size) * variance));
        let own = ModelFit {
            model: DriftModel {
                drift: Drift { shape: table.clone(), valid },
                history: History::new(table, &[play]),
                time_drift: Some(TimeDrift::straight(0.5, 100.0)),
            },
            cubic: Some(cubic.clone()),
            covariance: identity(33, 4.0),
        };
        let plain = ModelFit {
            model: DriftModel::of_curve(line.clone()),
            cubic: Some(line.clone()),
            covariance: identity(2, 8.0),
        };
        let made = Shares { model: 0.75, cubic: 0.25 }.fit(&own, &plain).unwrap();
        let run: Vec<(f64, f64)> =
            (0..200).map(|row| (10.0 * f64::from(row), 20.0 + 39.0 * (0.1 * f64::from(row)).sin())).collect();
        let [mean, own_biases, plain_biases] = [&made, &own, &plain].map(|fit| fit.model.biases(run.iter().copied()));
        for ((mean, own), plain) in mean.iter().zip(&own_biases).zip(&plain_biases) {
            assert!((mean - 0.75 * own - 0.25 * plain).abs() < 1e-9, "{mean} of {own} and {plain}");
        }
        let drifted = made.model.time_drift.unwrap().at(300.0, 300.0);
        assert!((drifted - 0.75 * 0.5 * 200.0).abs() < 1e-9, "{drifted}");
        let static_cubic = made.cubic.unwrap();
        for temperature in [-20.0, 3.0, 31.0, 60.0] {
            let mean = 0.25 * cubic.evaluate(temperature).0 + 0.75 * line.evaluate(temperature).0;
            assert!((static_cubic.evaluate(temperature).0 - mean).abs() < 1e-9, "at {temperature}");
        }
        // At the coldest knot the line's variance is that of its level and of its slope.
        assert!((made.covariance[0][0] - (0.75 * 4.0 + 0.25 * (8.0 + 8.0))).abs() < 1e-9);
    }
}
