//! From the triangular factor to coefficients, covariance and residual.

use zerorate_core::drift::{Polynomial, Scale, Shape, Table};

use super::factor::Factor;
use super::{Basis, Fit, FitError};

/// How strongly a table's second differences are drawn to zero against its data, so that a node without data near it
/// lies on the straight line through its neighbours. It moves a node with data by less than 1e-12 of the range.
const STRAIGHTNESS: f64 = 1e-7;

/// The least-squares solution.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// The scaled variable that the coefficients belong to.
    pub scale: Scale,
    /// The functions that the coefficients belong to.
    pub basis: Basis,
    /// One coefficient a function of the basis, all in the rate's unit.
    pub coefficients: Vec<f64>,
    /// Covariance of the coefficients, rate units squared, a row a coefficient: the residual variance (rows less
    /// coefficients in the denominator) times the inverse of A'A. It takes the residuals for independent, which thermal
    /// hysteresis is not.
    pub covariance: Vec<Vec<f64>>,
    /// Root mean square of the in-sample residual over all rows, rate units.
    pub rms: f64,
    /// Rows fitted.
    pub rows: u64,
}

impl Solution {
    /// The curve for the law: core's polynomial or table; `None` for an order or a number of intervals above core's.
    #[must_use]
    pub fn shape(&self) -> Option<Shape> {
        match self.basis {
            Basis::Powers(_) => Polynomial::new(self.scale, &self.coefficients).map(Shape::Polynomial),
            Basis::PiecewiseLinear(_) => Table::new(self.scale, &self.coefficients).map(Shape::Table),
        }
    }

    /// The coefficients as papers print them ([`raw_coefficients`]).
    #[must_use]
    pub fn raw_coefficients(&self) -> Vec<f64> {
        self.shape().as_ref().map(raw_coefficients).unwrap_or_default()
    }
}

/// Of a polynomial, the coefficients of 1, T, T^2, ... as papers print them; of a table the values at its knots, coldest
/// first.
#[must_use]
pub fn raw_coefficients(shape: &Shape) -> Vec<f64> {
    match shape {
        Shape::Polynomial(polynomial) => polynomial.raw_coefficients().to_vec(),
        Shape::Table(table) => table.knots().to_vec(),
    }
}

/// Solves for the coefficients.
pub(super) fn solve(fit: &Fit) -> Result<Solution, FitError> {
    let coefficients = fit.basis.size();
    if fit.rows < coefficients as u64 {
        return Err(FitError::TooFewRows { rows: fit.rows, coefficients });
    }
    let mut factor = fit.settled();
    if let Basis::PiecewiseLinear(_) = fit.basis {
        straighten(&mut factor, coefficients);
    }
    let finite = (0..factor.columns()).all(|column| (0..=column).all(|row| factor.entry(row, column).is_finite()));
    if !finite {
        return Err(FitError::NotFinite);
    }
    let inverse = inverse(&factor, coefficients).ok_or(FitError::Undetermined { coefficients })?;
    let target: Vec<f64> = (0..coefficients).map(|row| factor.entry(row, coefficients)).collect();
    let beta = factor.solve(&target).ok_or(FitError::Undetermined { coefficients })?;
    let squares = fit.sum_of_squares_of(&beta);
    let freedom = fit.rows.saturating_sub(coefficients as u64).max(1);
    Ok(Solution {
        scale: fit.scale,
        basis: fit.basis,
        covariance: covariance(&inverse, squares / freedom as f64),
        coefficients: beta,
        rms: (squares / fit.rows as f64).sqrt(),
        rows: fit.rows,
    })
}

/// Adds a faint row for each second difference of the node values.
fn straighten(factor: &mut Factor, nodes: usize) {
    let mass = (0..nodes).map(|node| factor.entry(node, node).powi(2)).sum::<f64>().sqrt();
    for middle in 1..nodes - 1 {
        let mut row = vec![0.0; factor.columns()];
        row[middle - 1] = STRAIGHTNESS * mass;
        row[middle] = -2.0 * STRAIGHTNESS * mass;
        row[middle + 1] = STRAIGHTNESS * mass;
        factor.fold(&mut row, 1, 1);
    }
}

/// The inverse of R's leading part, a column a vector.
fn inverse(factor: &Factor, n: usize) -> Option<Vec<Vec<f64>>> {
    (0..n)
        .map(|column| {
            let unit: Vec<f64> = (0..n).map(|row| f64::from(u8::from(row == column))).collect();
            factor.solve(&unit)
        })
        .collect()
}

/// `variance * inverse(R) * inverse(R)'`.
fn covariance(inverse: &[Vec<f64>], variance: f64) -> Vec<Vec<f64>> {
    let n = inverse.len();
    (0..n)
        .map(|i| (0..n).map(|j| variance * inverse.iter().map(|column| column[i] * column[j]).sum::<f64>()).collect())
        .collect()
}
