//! What a curve leaves, in a few numbers.

use serde::{Deserialize, Serialize};

use crate::folds::Fold;

/// The size of a residual, in the rate's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ResidualStatistics {
    /// Root mean square about zero, unless it is said otherwise.
    pub rms: f64,
    /// Peak to peak.
    pub pp: f64,
    /// How well the rms is known, by how much the folds differ ([`Self::of_folds`]) and, where a zero was taken once, by its
    /// noise; `None` where it is not of folds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rms_standard_error: Option<f64>,
}

impl ResidualStatistics {
    /// Of nothing.
    pub const NONE: Self = Self { rms: f64::NAN, pp: f64::NAN, rms_standard_error: None };

    /// Of the finite values, about zero.
    #[must_use]
    pub fn of(residuals: impl IntoIterator<Item = f64>) -> Self {
        Residuals::of(residuals).statistics()
    }

    /// Of residuals in folds, about zero. Neighbours in a fold are alike and folds are not, so the standard error of the rms
    /// is by folds: of fold k, with n residuals of N and the sum of squares S, and of the mean square m of all K folds,
    /// `sqrt(K / (K - 1) sum (S - m n)^2) / N / (2 rms)`. `None` of fewer than two folds, and where nothing is left.
    #[must_use]
    pub fn of_folds(folds: &[Residuals]) -> Self {
        let all = folds.iter().fold(Residuals::default(), |all, fold| all.with(fold));
        let folds: Vec<&Residuals> = folds.iter().filter(|fold| fold.count > 0).collect();
        let (count, total) = (folds.len() as f64, all.count as f64);
        let (rms, mean_square) = (all.rms(), all.squares / total);
        let squares: f64 = folds.iter().map(|fold| (fold.squares - mean_square * fold.count as f64).powi(2)).sum();
        let error = (count / (count - 1.0) * squares).sqrt() / total / (2.0 * rms);
        Self { rms_standard_error: Some(error).filter(|error| error.is_finite()), ..all.statistics() }
    }

    /// The same of residuals in their order; those that are no numbers are left out.
    #[must_use]
    pub fn by_folds(residuals: &[f64], folds: &[Fold]) -> Self {
        let fold = |fold: &Fold| Residuals::of(fold.rows().map(|row| residuals[row]));
        Self::of_folds(&folds.iter().map(fold).collect::<Vec<_>>())
    }

    /// The same, where the sum of squares of its `count` residuals has a variance of its own beside the folds' differences.
    #[must_use]
    pub(crate) fn varied_by(self, variance: f64, count: usize) -> Self {
        let more = variance.sqrt() / count as f64 / (2.0 * self.rms);
        Self { rms_standard_error: self.rms_standard_error.map(|error| libm::hypot(error, more)), ..self }
    }

    /// The size of values about their mean, and the mean.
    #[must_use]
    pub fn about_mean(values: &[f64]) -> (Self, f64) {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let rms = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt();
        (Self { rms, ..Self::of(values.iter().copied()) }, mean)
    }
}

/// What residuals add up to, one after the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residuals {
    /// How many.
    pub count: u64,
    /// The sum of squares.
    pub squares: f64,
    /// The sum of fourth powers.
    pub fourths: f64,
    /// The least.
    pub min: f64,
    /// The greatest.
    pub max: f64,
}

impl Default for Residuals {
    fn default() -> Self {
        Self { count: 0, squares: 0.0, fourths: 0.0, min: f64::INFINITY, max: f64::NEG_INFINITY }
    }
}

impl Residuals {
    /// Of the finite values.
    #[must_use]
    pub fn of(residuals: impl IntoIterator<Item = f64>) -> Self {
        let mut all = Self::default();
        residuals.into_iter().filter(|residual| residual.is_finite()).for_each(|residual| all.push(residual));
        all
    }

    /// Takes in a residual.
    pub fn push(&mut self, residual: f64) {
        self.count += 1;
        self.squares += residual.powi(2);
        self.fourths += residual.powi(4);
        self.min = self.min.min(residual);
        self.max = self.max.max(residual);
    }

    /// These and others.
    #[must_use]
    pub fn with(self, others: &Self) -> Self {
        Self {
            count: self.count + others.count,
            squares: self.squares + others.squares,
            fourths: self.fourths + others.fourths,
            min: self.min.min(others.min),
            max: self.max.max(others.max),
        }
    }

    /// Root mean square; NaN of none.
    #[must_use]
    pub fn rms(&self) -> f64 {
        (self.squares / self.count as f64).sqrt()
    }

    /// The largest, without sign.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.max.max(-self.min)
    }

    /// The mean fourth power over the squared mean square: 3 for noise, n/m where m of n residuals dwarf the others,
    /// as what a poor curve leaves may do at an end.
    #[must_use]
    pub fn kurtosis(&self) -> f64 {
        self.fourths * self.count as f64 / self.squares.powi(2)
    }

    /// The two numbers that are printed.
    #[must_use]
    pub fn statistics(&self) -> ResidualStatistics {
        if self.count == 0 {
            return ResidualStatistics::NONE;
        }
        ResidualStatistics { rms: self.rms(), pp: self.max - self.min, rms_standard_error: None }
    }
}

#[cfg(test)]
mod tests {
    use std::slice::from_ref;

    use super::*;

    #[test]
    fn the_standard_error_of_an_rms_is_by_folds() {
        // Mean squares 1, 9, 1, 9, 1, 9, 1, 9 of two residuals each: 5 on average, and the variance of such a mean is
        // 8 x 16 / (8 x 7). The error of a root is that of the square over twice the root.
        let residuals: Vec<f64> = (0..16).map(|row| if row / 2 % 2 == 0 { 1.0 } else { -3.0 }).collect();
        let found = ResidualStatistics::by_folds(&residuals, &Fold::of_logs(from_ref(&(0..residuals.len()))));
        assert!((found.rms - 5.0_f64.sqrt()).abs() < 1e-12 && (found.pp - 4.0).abs() < 1e-12);
        let by_hand = (8.0 * 16.0 / (8.0 * 7.0_f64)).sqrt() / (2.0 * 5.0_f64.sqrt());
        assert!((found.rms_standard_error.unwrap() - by_hand).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn of_one_fold_nobody_knows_how_well_its_rms_is_known() {
        let one = ResidualStatistics::of_folds(&[Residuals::of([1.0, -2.0])]);
        assert_eq!((one.rms_standard_error, one.pp), (None, 3.0));
        assert_eq!(ResidualStatistics::of_folds(&[]).rms_standard_error, None);
        assert_eq!(
            ResidualStatistics::by_folds(&[0.0; 16], &Fold::of_logs(from_ref(&(0..16)))).rms_standard_error,
            None,
            "nothing is left"
        );
    }
}
