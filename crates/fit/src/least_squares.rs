//! Least squares by an orthogonal factor kept up to date: `push`, `merge`, `finish`.
//!
//! Only the triangular factor of `[basis | responses]` is kept, so a fit is as small after a hundred million rows as
//! after ten, partitions merge in any order to the same curve, and numbers stay sound when the offset of a rate is a
//! million times its noise.

mod basis;
mod factor;
mod solution;

use thiserror::Error;
use zerorate_core::drift::Scale;

pub use basis::Basis;
use factor::{BLOCK_ROWS, Factor};
pub use solution::{Solution, raw_coefficients};

/// Why a fit has no solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum FitError {
    /// Fewer rows than coefficients.
    #[error("{rows} rows cannot settle {coefficients} coefficients: record more, or choose a smaller model")]
    TooFewRows {
        /// Rows pushed.
        rows: u64,
        /// Coefficients wanted.
        coefficients: usize,
    },
    /// The temperatures take too few different values for the basis.
    #[error(
        "the temperatures do not settle {coefficients} coefficients: record a wider range, or choose a smaller model"
    )]
    Undetermined {
        /// Coefficients wanted.
        coefficients: usize,
    },
    /// A temperature or a rate was NaN or infinite.
    #[error("a row that is not finite was pushed: drop such rows before the fit")]
    NotFinite,
}

/// A least-squares fit of a rate to a basis of one temperature.
#[derive(Debug, Clone)]
pub struct Fit {
    scale: Scale,
    basis: Basis,
    rows: u64,
    factor: Factor,
    /// Rows not folded yet, column-major, [`BLOCK_ROWS`] numbers a column.
    block: Vec<f64>,
    /// Rows in `block`.
    filled: usize,
}

impl Fit {
    /// An empty fit over `scale`.
    #[must_use]
    pub fn new(scale: Scale, basis: Basis) -> Self {
        let columns = basis.size() + 1;
        Self { scale, basis, rows: 0, factor: Factor::new(columns), block: vec![0.0; columns * BLOCK_ROWS], filled: 0 }
    }

    /// The basis of the fit.
    #[must_use]
    pub fn basis(&self) -> Basis {
        self.basis
    }

    /// The rows pushed and merged.
    #[must_use]
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Takes in one row: a temperature in the scale's unit and a rate. Both must be finite: only the caller knows how to
    /// count the others.
    pub fn push(&mut self, temperature: f64, rate: f64) {
        self.push_rows(&[temperature], &[rate]);
    }

    /// Takes in rows column by column: faster than [`Fit::push`], with the same result.
    ///
    /// # Panics
    /// When there are not as many rates as temperatures.
    pub fn push_rows(&mut self, temperatures: &[f64], rates: &[f64]) {
        assert_eq!(temperatures.len(), rates.len(), "one rate a temperature");
        let mut x = [0.0; BLOCK_ROWS];
        let mut done = 0;
        while done < temperatures.len() {
            let row = self.filled;
            let rows = (BLOCK_ROWS - row).min(temperatures.len() - done);
            for (x, temperature) in x.iter_mut().zip(&temperatures[done..done + rows]) {
                *x = self.scale.x(*temperature);
            }
            self.basis.write(&x[..rows], &mut self.block[row..], BLOCK_ROWS);
            let start = self.basis.size() * BLOCK_ROWS + row;
            self.block[start..start + rows].copy_from_slice(&rates[done..done + rows]);
            self.advance(rows);
            done += rows;
        }
    }

    /// Counts rows written to the block, and folds it when it is full.
    fn advance(&mut self, rows: usize) {
        self.filled += rows;
        self.rows += rows as u64;
        if self.filled == BLOCK_ROWS {
            self.factor.fold(&mut self.block, BLOCK_ROWS, BLOCK_ROWS);
            self.filled = 0;
        }
    }

    /// Takes in all the rows of another fit.
    ///
    /// # Panics
    /// When the other fit has another scale or basis: their rows are not of one matrix.
    pub fn merge(&mut self, other: &Self) {
        assert!(
            self.scale == other.scale && self.basis == other.basis,
            "only fits of one scale and basis can be merged"
        );
        self.factor.merge(&other.settled());
        self.rows += other.rows;
    }

    /// The fit of the same rows by powers up to a lower order, or the same: a factor holds the factors of all its
    /// leading columns. `None` for tables, and for an order above this fit's.
    #[must_use]
    pub fn lowered(&self, order: usize) -> Option<Self> {
        match self.basis {
            Basis::Powers(own) if order <= own => {
                let mut lower = Self::new(self.scale, Basis::Powers(order));
                let columns: Vec<usize> = (0..=order).chain([own + 1]).collect();
                lower.factor = self.settled().select(&columns);
                lower.rows = self.rows;
                Some(lower)
            }
            _ => None,
        }
    }

    /// The residual sum of squares of this fit's rows under other coefficients than its own, rate units squared: the
    /// error on held-out rows without a second pass over them, as `|R [beta; -1]|^2`.
    ///
    /// # Panics
    /// When the coefficients are not one a function of the basis.
    #[must_use]
    pub fn sum_of_squares_of(&self, coefficients: &[f64]) -> f64 {
        assert_eq!(coefficients.len(), self.basis.size(), "one coefficient a function of the basis");
        let factor = self.settled();
        let target = self.basis.size();
        (0..=target)
            .map(|row| {
                let fitted: f64 = coefficients.iter().enumerate().map(|(k, c)| factor.entry(row, k) * c).sum();
                (factor.entry(row, target) - fitted).powi(2)
            })
            .sum()
    }

    /// The least-squares solution of everything pushed and merged so far; more can be pushed after it.
    ///
    /// # Errors
    /// When there are too few rows or too few different temperatures for the basis, or a row was not finite.
    pub fn finish(&self) -> Result<Solution, FitError> {
        solution::solve(self)
    }

    /// The factor with the block's rows folded in.
    fn settled(&self) -> Factor {
        let mut factor = self.factor.clone();
        if self.filled > 0 {
            factor.fold(&mut self.block.clone(), BLOCK_ROWS, self.filled);
        }
        factor
    }
}

#[cfg(test)]
mod tests;
