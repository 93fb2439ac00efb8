//! What a curve leaves, in a few numbers.

use serde::{Deserialize, Serialize};

/// The size of a residual, in the rate's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ResidualStatistics {
    /// Root mean square about zero, unless it is said otherwise.
    pub rms: f64,
    /// Peak to peak.
    pub pp: f64,
}

impl ResidualStatistics {
    /// Of nothing.
    pub const NONE: Self = Self { rms: f64::NAN, pp: f64::NAN };

    /// Of the finite values, about zero.
    #[must_use]
    pub fn of(residuals: impl IntoIterator<Item = f64>) -> Self {
        Residuals::of(residuals).statistics()
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
        ResidualStatistics { rms: self.rms(), pp: self.max - self.min }
    }
}
