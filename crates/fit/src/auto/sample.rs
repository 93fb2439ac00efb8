//! The groups that a fit sees, and how far each is believed.

use super::features::Features;
use super::gram::{Gram, Penalised};
use crate::robust::{MAD_TO_SIGMA, median};
use crate::series::Series;

/// A residual of more than this many standard deviations counts less (Huber, 1964): 1.345 would lose 5 % on clean data; 2
/// loses 1 %, and conditioning has already taken out the outliers.
const HUBER: f64 = 2.0;

/// Rounds of reweighting; after the fourth nothing moves by a hundredth of its error.
const ROUNDS: usize = 5;

/// The used groups of a series, without one fold or with all, and their weights.
#[derive(Debug, Clone)]
pub(super) struct Sample<'a> {
    series: &'a Series<'a>,
    /// The groups with a rate, in order of time.
    pub used: Vec<usize>,
    weights: Vec<f64>,
    /// Subtracted from every rate.
    pub mean: f64,
    directions: &'a [Option<usize>],
}

impl<'a> Sample<'a> {
    /// The groups with a finite rate that `keep` keeps, each with its own weight.
    pub(super) fn new(series: &'a Series<'a>, directions: &'a [Option<usize>], keep: impl Fn(usize) -> bool) -> Self {
        let used: Vec<usize> = (0..series.rate.len()).filter(|&group| series.is_used(group) && keep(group)).collect();
        let mean = used.iter().map(|&group| series.rate[group]).sum::<f64>() / used.len().max(1) as f64;
        Self { series, used, weights: series.weight.to_vec(), mean, directions }
    }

    pub(super) fn temperature(&self, group: usize) -> f64 {
        self.series.temperature[group]
    }

    /// The times of all groups of the series.
    pub(super) fn times(&self) -> &[f64] {
        self.series.time_s
    }

    /// Less the mean.
    pub(super) fn rate(&self, group: usize) -> f64 {
        self.series.rate[group] - self.mean
    }

    pub(super) fn weight(&self, group: usize) -> f64 {
        self.weights[group]
    }

    /// 0 while heating, 1 while cooling.
    pub(super) fn direction(&self, group: usize) -> Option<usize> {
        self.directions[group]
    }

    /// The sums of some columns.
    pub(super) fn gram(&self, features: &Features, columns: &[usize]) -> Gram {
        self.sums(features, columns).among(columns, features.columns)
    }

    /// The sums of some columns, those side by side.
    fn sums(&self, features: &Features, columns: &[usize]) -> Gram {
        let mut sums = Gram::new(columns.len());
        let mut row = vec![0.0; columns.len()];
        for &group in &self.used {
            pick(features.row(group), columns, &mut row);
            sums.push(&row, self.rate(group), self.weights[group]);
        }
        sums
    }

    /// The residuals of a fit, a used group each.
    pub(super) fn residuals(&self, features: &Features, columns: &[usize], beta: &[f64]) -> Vec<f64> {
        let predicted = |row: &[f64]| columns.iter().zip(beta).map(|(&column, b)| row[column] * b).sum::<f64>();
        self.used.iter().map(|&group| self.rate(group) - predicted(features.row(group))).collect()
    }

    /// Fits robustly: groups far from the fit are given less weight, by the scatter of the others. `None` where the rows
    /// do not settle it.
    pub(super) fn fit_robustly(&mut self, features: &Features, fit: &Penalised<'_>) -> Option<Vec<f64>> {
        let mut sums = self.sums(features, fit.columns);
        let mut row = vec![0.0; fit.columns.len()];
        for _ in 0..ROUNDS {
            let beta = sums.among(fit.columns, features.columns).solve(fit)?;
            let residuals = self.residuals(features, fit.columns, &beta);
            let sigma = MAD_TO_SIGMA * median(&mut residuals.iter().map(|residual| residual.abs()).collect::<Vec<_>>());
            // Data that fit to rounding have no scatter to judge by.
            if sigma.is_nan() || sigma <= 0.0 {
                break;
            }
            for (&group, residual) in self.used.iter().zip(&residuals) {
                let believed = (HUBER * sigma / residual.abs()).min(1.0);
                let change = self.series.weight[group] * believed - self.weights[group];
                // Most are believed as before.
                if change != 0.0 {
                    pick(features.row(group), fit.columns, &mut row);
                    sums.push(&row, self.rate(group), change);
                    self.weights[group] += change;
                }
            }
        }
        // Summed anew: what an outlier has left in the last digits goes with it.
        self.gram(features, fit.columns).solve(fit)
    }
}

/// The wanted columns of a row.
fn pick(row: &[f64], columns: &[usize], wanted: &mut [f64]) {
    wanted.iter_mut().zip(columns).for_each(|(wanted, &column)| *wanted = row[column]);
}

/// Which way the temperature goes at each group: 0 heating, 1 cooling, by the change over a few groups on either side.
pub(super) fn directions(temperature: &[f64], span: f64) -> Vec<Option<usize>> {
    /// Groups to either side.
    const REACH: usize = 3;
    /// A change smaller than this share of the span over them is a soak.
    const STILL: f64 = 0.002;
    (0..temperature.len())
        .map(|group| {
            let before = temperature[group.saturating_sub(REACH)];
            let after = temperature[(group + REACH).min(temperature.len() - 1)];
            let change = after - before;
            (change.abs() > STILL * span).then(|| usize::from(change < 0.0))
        })
        .collect()
}
