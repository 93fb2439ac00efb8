//! A fixed curve, alone or with a drift in time: robust least squares.

use nalgebra::{Cholesky, DMatrix, DVector};
use zerorate_core::drift::{Drift, MAX_ORDER, Polynomial, Scale, Shape, Table, ValidRange};

use super::levels::Levels;
use super::timeless;
use crate::model::Model;
use crate::model_fit::{CUBIC, ModelFit, rows};
use crate::predict::{DriftModel, TimeDrift};
use crate::robust::{HUBER, MAD_TO_SIGMA, median};
use crate::series::Series;

/// Rounds of reweighting; after the fourth nothing moves by a hundredth of its error.
const ROUNDS: usize = 5;

/// The penalty on the squared second differences of a table's knots, against the rows' own weight. A knot without data near
/// it lies on the line through its neighbours; one with data is moved by nothing.
const SMOOTH: f64 = 1e-9;

/// A pivot below this share of its diagonal is rounding, not data: 1e4 times the square root of f64's rounding, squared.
const LEAST_PIVOT: f64 = 1e-9;

/// A curve of a fixed kind.
#[derive(Debug, Clone, Copy)]
pub(super) struct Curve {
    pub model: Model,
    /// Whether a drift in time is fitted with it.
    pub in_time: bool,
}

/// What curves are fitted to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Groups<'a> {
    pub series: &'a Series<'a>,
    /// The least and greatest temperature that has a rate.
    pub measured: ValidRange,
    /// The temperatures over which a polynomial is believed; a table is held at the ends of what was measured.
    pub valid: ValidRange,
}

/// A curve fitted, and the coefficient of time from the first group, -1, to the last, 1.
struct Fitted {
    drift: Drift,
    covariance: Vec<Vec<f64>>,
    along: Option<f64>,
}

impl Curve {
    /// Fits the groups that `keep` keeps. `None` where they do not settle it.
    pub(super) fn fit(self, groups: Groups<'_>, keep: impl Fn(usize) -> bool) -> Option<ModelFit> {
        let Fitted { drift, covariance, along } = self.fitted(groups, &keep)?;
        let series = groups.series;
        let (first, last) = series.time_s.first().copied().zip(series.time_s.last().copied())?;
        let straight = |along: f64| TimeDrift::straight(2.0 * along / (last - first), f64::midpoint(first, last));
        let model = DriftModel { drift, history: None, time_drift: along.map(straight) };
        let cubic = if self.model == Model::Poly(CUBIC) {
            Some(model.drift.clone())
        } else {
            let timeless = timeless(&model, series);
            let timeless = Groups { series: &Series { rate: &timeless, ..*series }, ..groups };
            let alone = |order| Self { model: Model::Poly(order), in_time: false }.fitted(timeless, &keep);
            (1..=CUBIC).rev().find_map(alone).map(|fitted| fitted.drift)
        };
        Some(ModelFit { model, cubic, covariance })
    }

    fn fitted(self, groups: Groups<'_>, keep: impl Fn(usize) -> bool) -> Option<Fitted> {
        let Groups { series, measured, valid } = groups;
        let scale = Scale::spanning(measured.min(), measured.max())?;
        let used: Vec<usize> = (0..series.rate.len()).filter(|&group| series.is_used(group) && keep(group)).collect();
        let level = used.iter().map(|&group| series.rate[group]).sum::<f64>() / used.len().max(1) as f64;
        let (first, last) = (*series.time_s.first()?, *series.time_s.last()?);
        let levels = Levels::of(series, &used);
        let of_groups: Vec<Vec<f64>> = (used.iter())
            .map(|&group| {
                let mut row = self.columns(scale.x(series.temperature[group].clamp(valid.min(), valid.max())));
                row.extend(self.in_time.then(|| 2.0 * (series.time_s[group] - first) / (last - first) - 1.0));
                row.extend(levels.columns(series.log[group]));
                row
            })
            .collect();
        let width = of_groups.first()?.len();
        let columns = DMatrix::from_fn(width, of_groups.len(), |column, row| of_groups[row][column]);
        let rates = DVector::from_iterator(used.len(), used.iter().map(|&group| series.rate[group] - level));
        let weights: Vec<f64> = used.iter().map(|&group| series.weight[group]).collect();
        let (beta, covariance) = self.solve_robustly(&columns, &rates, &weights)?;

        let deployed = self.deployed();
        let curve = deployed.nrows();
        let mut coefficients = &deployed * beta.rows(0, curve);
        let covariance = &deployed * covariance.view((0, 0), (curve, curve)) * deployed.transpose();
        let (shape, valid) = if let Model::Table(_) = self.model {
            coefficients.add_scalar_mut(level);
            (Table::new(scale, coefficients.as_slice()).map(Shape::Table)?, measured)
        } else {
            coefficients[0] += level;
            (Polynomial::new(scale, coefficients.as_slice()).map(Shape::Polynomial)?, valid)
        };
        let drift = Drift { shape, valid };
        Some(Fitted { drift, covariance: rows(&covariance), along: self.in_time.then(|| beta[curve]) })
    }

    /// The columns of the curve, all of the order of one: Legendre polynomials, or hats about a table's knots.
    fn columns(self, x: f64) -> Vec<f64> {
        match self.model {
            Model::Table(intervals) => {
                // A table is held at its end knots.
                let place = 0.5 * (x.clamp(-1.0, 1.0) + 1.0) * intervals as f64;
                (0..=intervals).map(|node| (1.0 - (place - node as f64).abs()).max(0.0)).collect()
            }
            Model::Poly(order) => legendre(x)[..=order].to_vec(),
            Model::Auto => legendre(x).to_vec(),
        }
    }

    /// The deployed coefficients of each column: powers of the scaled temperature; a table's are its own.
    fn deployed(self) -> DMatrix<f64> {
        match self.model {
            Model::Table(intervals) => DMatrix::identity(intervals + 1, intervals + 1),
            Model::Poly(order) => powers_of_legendre().view((0, 0), (order + 1, order + 1)).into_owned(),
            Model::Auto => powers_of_legendre(),
        }
    }

    /// Least squares in which rows far from the fit are given less weight, by the scatter of the others: coefficients and
    /// their covariance. `None` where the rows do not settle them.
    fn solve_robustly(
        self,
        rows: &DMatrix<f64>,
        rates: &DVector<f64>,
        own: &[f64],
    ) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let mut weights = own.to_vec();
        for _ in 0..ROUNDS {
            let (beta, _) = self.solve(rows, rates, &weights)?;
            let residuals = rates - rows.tr_mul(&beta);
            let sigma = MAD_TO_SIGMA * median(&mut residuals.iter().map(|residual| residual.abs()).collect::<Vec<_>>());
            // Data that fit to rounding have no scatter to judge by.
            if sigma.is_nan() || sigma <= 0.0 {
                break;
            }
            let believed = residuals.iter().map(|residual| (HUBER * sigma / residual.abs()).min(1.0));
            weights = own.iter().zip(believed).map(|(own, believed)| own * believed).collect();
        }
        let (beta, inverse) = self.solve(rows, rates, &weights)?;
        let residuals = rates - rows.tr_mul(&beta);
        let squares: f64 = residuals.iter().zip(&weights).map(|(residual, weight)| weight * residual * residual).sum();
        let freedom = rates.len().saturating_sub(beta.len()).max(1) as f64;
        Some((beta, inverse * (squares / freedom)))
    }

    /// Minimises `|rate - A beta|^2` with weights: the coefficients, and the inverse of `A'WA`.
    fn solve(self, rows: &DMatrix<f64>, rates: &DVector<f64>, weights: &[f64]) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let mut weighed = rows.clone();
        weighed.column_iter_mut().zip(weights).for_each(|(mut row, weight)| row *= *weight);
        let mut gram = &weighed * rows.transpose();
        if let Model::Table(intervals) = self.model {
            let smooth = SMOOTH * weights.iter().sum::<f64>();
            for middle in 1..intervals {
                let differences = [(middle - 1, 1.0), (middle, -2.0), (middle + 1, 1.0)];
                for ((i, a), (j, b)) in differences.iter().flat_map(|a| differences.iter().map(move |b| (a, b))) {
                    gram[(*i, *j)] += smooth * a * b;
                }
            }
        }
        let diagonal = gram.diagonal();
        let factor = Cholesky::new(gram)?;
        let settled = |(own, whole): (f64, &f64)| own.powi(2) > LEAST_PIVOT * whole;
        let all_settled = factor.l_dirty().diagonal().iter().copied().zip(&diagonal).all(settled);
        all_settled.then(|| (factor.solve(&(&weighed * rates)), factor.inverse()))
    }
}

/// The Legendre polynomials P0 to P5 at x.
fn legendre(x: f64) -> [f64; MAX_ORDER + 1] {
    let mut p = [1.0; MAX_ORDER + 1];
    p[1] = x;
    for n in 1..MAX_ORDER {
        let k = n as f64;
        p[n + 1] = ((2.0 * k + 1.0) * x * p[n] - k * p[n - 1]) / (k + 1.0);
    }
    p
}

/// The coefficients of 1, x, x^2, ... of P0 to P5, a column each, by the recurrence of [`legendre`].
fn powers_of_legendre() -> DMatrix<f64> {
    let mut p = DMatrix::identity(MAX_ORDER + 1, MAX_ORDER + 1);
    for n in 1..MAX_ORDER {
        let k = n as f64;
        for power in 0..=MAX_ORDER {
            let raised = if power > 0 { p[(power - 1, n)] } else { 0.0 };
            p[(power, n + 1)] = ((2.0 * k + 1.0) * raised - k * p[(power, n - 1)]) / (k + 1.0);
        }
    }
    p
}
