//! Noise that is white plus a part that wanders, and rows from which both are taken by their own law.

use nalgebra::DMatrix;

use super::averages::Averages;

/// A rate's noise is white, and besides wanders: an Ornstein-Uhlenbeck process, whose covariance falls off as
/// `exp(-t / tau)`. So what wanders is not mistaken for drift.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wander {
    /// Natural logarithm of its standard deviation over that of the white part.
    pub log_ratio: f64,
    /// Natural logarithm of tau, seconds.
    pub log_seconds: f64,
}

/// Rows, the rate the last of their columns, once each was divided by its noise and freed of what the rows before it tell of
/// that: the innovations of a Kalman filter (Harvey, *Forecasting, structural time series models and the Kalman filter*,
/// 1989, 3.4).
pub(super) struct Whitened {
    /// A row of the recording a column.
    pub rows: DMatrix<f64>,
    /// Each column times each, of several logs the mean of their sums: what no column holds comes again in every run that goes the
    /// same way, and would be taken, run after run, for more evidence of columns that look like it. So logs weigh against the priors
    /// as one of them does (a power of the likelihood: Grünwald, *The safe Bayesian*, 2012).
    pub products: DMatrix<f64>,
    /// Of the noise's covariance, the white part's variance being 1; of several logs their mean.
    pub log_determinant: f64,
    /// How many rows a log has, on average.
    pub count: f64,
}

impl Whitened {
    pub(super) fn new(averages: &Averages, wander: Wander) -> Self {
        let (power, tau) = (libm::exp(2.0 * wander.log_ratio), libm::exp(wander.log_seconds));
        let mut rows = averages.rows.clone();
        let mut told = vec![0.0; rows.nrows()];
        let (mut variance, mut log_determinant, mut before) = (power, 0.0, f64::NAN);
        for (place, mut row) in rows.column_iter_mut().enumerate() {
            let now = averages.time_s[place];
            if averages.begins[place] {
                told.fill(0.0);
                variance = power;
            } else {
                let kept = libm::exp(-(now - before).max(0.0) / tau);
                told.iter_mut().for_each(|told| *told *= kept);
                variance = variance * kept * kept + power * (1.0 - kept * kept);
            }
            before = now;
            let whole = variance + averages.variance[place];
            let gain = variance / whole;
            let scale = 1.0 / whole.sqrt();
            for (value, told) in row.iter_mut().zip(&mut told) {
                let new = *value - *told;
                *told += gain * new;
                *value = new * scale;
            }
            variance *= 1.0 - gain;
            log_determinant += libm::log(whole);
        }
        let share = 1.0 / averages.begins.iter().filter(|begins| **begins).count() as f64;
        let (products, count) = (products_of(&rows) * share, rows.ncols() as f64 * share);
        Self { rows, products, log_determinant: log_determinant * share, count }
    }
}

/// The sum of each column's product with itself: half of it is the other half.
fn products_of(rows: &DMatrix<f64>) -> DMatrix<f64> {
    let width = rows.nrows();
    let mut products = DMatrix::zeros(width, width);
    for row in rows.column_iter() {
        let row = row.as_slice();
        for (own, column) in products.as_mut_slice().chunks_exact_mut(width).enumerate() {
            let value = row[own];
            column[own..].iter_mut().zip(&row[own..]).for_each(|(sum, other)| *sum += value * other);
        }
    }
    products.fill_upper_triangle_with_lower_triangle();
    products
}
