//! Sums of products of columns, and ridge regression on some of them.
//!
//! Candidates are many and share their columns, so the products are summed once a fold; a candidate is a choice of
//! rows and columns of the sums, and a fit without a fold is a subtraction. The columns are of the order of one and the
//! rates are taken from their mean, so that squaring the condition number costs nothing that the shrinkage has not settled.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// `A'WA` of columns `A` with the rate as the last one; of the symmetric matrix the lower half is kept.
#[derive(Debug, Clone)]
pub(super) struct Gram {
    products: DMatrix<f64>,
    /// Sum of the weights.
    pub weight: f64,
}

impl Gram {
    pub(super) fn new(columns: usize) -> Self {
        Self { products: DMatrix::zeros(columns + 1, columns + 1), weight: 0.0 }
    }

    /// The place of the rate.
    fn rate(&self) -> usize {
        self.products.nrows() - 1
    }

    /// Takes in a row of columns and its rate.
    pub(super) fn push(&mut self, row: &[f64], rate: f64, weight: f64) {
        self.weight += weight;
        let last = self.rate();
        for (i, mut products) in self.products.column_iter_mut().take(last).enumerate() {
            let scaled = weight * row[i];
            if scaled != 0.0 {
                let below = row[i..].iter().chain([&rate]);
                products.iter_mut().skip(i).zip(below).for_each(|(product, value)| *product += scaled * value);
            }
        }
        self.products[(last, last)] += weight * rate * rate;
    }

    /// The same sums as those of `columns` among more of them; the others' are nothing.
    pub(super) fn among(&self, columns: &[usize], of: usize) -> Self {
        let mut whole = Self { weight: self.weight, ..Self::new(of) };
        let places: Vec<usize> = columns.iter().copied().chain([of]).collect();
        for (i, &column) in places.iter().enumerate() {
            for (j, &row) in places.iter().enumerate().skip(i) {
                whole.products[(row.max(column), row.min(column))] = self.products[(j, i)];
            }
        }
        whole
    }

    pub(super) fn add(&mut self, other: &Self, sign: f64) {
        self.weight += sign * other.weight;
        self.products.zip_apply(&other.products, |own, other| *own += sign * other);
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        self.products[(i.max(j), i.min(j))]
    }

    /// The mean square of `rate - sum of beta column` over the rows taken in.
    pub(super) fn mean_square(&self, columns: &[usize], beta: &[f64]) -> f64 {
        let rate = self.rate();
        let mut sum = self.at(rate, rate);
        for (&i, b) in columns.iter().zip(beta) {
            sum -= 2.0 * b * self.at(i, rate);
            for (&j, c) in columns.iter().zip(beta) {
                sum += b * c * self.at(i, j);
            }
        }
        sum.max(0.0) / self.weight
    }

    /// Minimises `|rate - A beta|^2 + weight * sum of penalty`. `None` where the rows do not settle it.
    pub(super) fn solve(&self, fit: &Penalised<'_>) -> Option<Vec<f64>> {
        let target = DVector::from_iterator(fit.columns.len(), fit.columns.iter().map(|&c| self.at(c, self.rate())));
        Some(self.factorise(fit)?.0.solve(&target).as_slice().to_vec())
    }

    /// The Cholesky factor of `A'WA + penalty`.
    pub(super) fn factorise(&self, fit: &Penalised<'_>) -> Option<Factor> {
        let n = fit.columns.len();
        let mut matrix = DMatrix::from_fn(n, n, |i, j| self.at(fit.columns[i], fit.columns[j]));
        for (i, shrinkage) in fit.shrinkage.iter().enumerate() {
            matrix[(i, i)] += self.weight * shrinkage;
        }
        for middle in 1..fit.knots.saturating_sub(1) {
            let differences = [(middle - 1, 1.0), (middle, -2.0), (middle + 1, 1.0)];
            for (i, a) in differences {
                for (j, b) in differences {
                    matrix[(i, j)] += self.weight * fit.smooth * a * b;
                }
            }
        }
        let diagonal = matrix.diagonal();
        let factor = Cholesky::new(matrix)?;
        let settled = |(own, whole): (f64, &f64)| own.powi(2) > LEAST_PIVOT * whole;
        factor.l_dirty().diagonal().iter().copied().zip(&diagonal).all(settled).then_some(Factor(factor))
    }
}

/// A pivot below this share of its diagonal is rounding, not data: 1e4 times the square root of f64's rounding, squared.
const LEAST_PIVOT: f64 = 1e-9;

/// The factor of a matrix that the rows settle.
pub(super) struct Factor(Cholesky<f64, Dyn>);

impl Factor {
    /// The matrix's inverse, a row a coefficient.
    pub(super) fn inverse(&self) -> Vec<Vec<f64>> {
        self.0.inverse().row_iter().map(|row| row.iter().copied().collect()).collect()
    }
}

/// What is to be minimised: which columns, and how strongly their coefficients are drawn to zero.
#[derive(Debug, Clone, Copy)]
pub(super) struct Penalised<'a> {
    pub columns: &'a [usize],
    /// The penalty is `shrinkage[k] beta_k^2` a column.
    pub shrinkage: &'a [f64],
    /// The first so many columns are the knots of a table; 0 for a polynomial.
    pub knots: usize,
    /// And so much times the squared second differences of the knots.
    pub smooth: f64,
}
