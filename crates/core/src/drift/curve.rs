//! A curve and the range over which it holds.

use heapless::Vec;

use super::polynomial::Polynomial;
use super::range::{Coverage, ValidRange};
use super::table::{MAX_TURNING_POINTS, Table};

/// The shape of a drift curve.
#[allow(clippy::large_enum_variant)] // no heap here to box the table in
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A polynomial of order 1 to 5 (the paper's is of order 2, eq. 1).
    Polynomial(Polynomial),
    /// Straight pieces between evenly spaced temperatures.
    Table(Table),
}

impl Shape {
    /// The reading at a temperature, held nowhere. NaN gives NaN.
    #[must_use]
    pub fn evaluate(&self, temperature: f64) -> f64 {
        match self {
            Self::Polynomial(polynomial) => polynomial.evaluate(temperature),
            Self::Table(table) => table.evaluate(temperature),
        }
    }

    /// The same shape with every reading less by so much.
    pub(crate) fn lowered(&self, by: f64) -> Self {
        match self {
            Self::Polynomial(polynomial) => Self::Polynomial(polynomial.lowered(by)),
            Self::Table(table) => Self::Table(table.lowered(by)),
        }
    }
}

/// Zero-rate output over temperature: a shape and the range over which it holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Drift {
    /// The curve.
    pub shape: Shape,
    /// The temperatures over which the curve was measured.
    pub valid: ValidRange,
}

impl Drift {
    /// The zero-rate output at a temperature, held at the nearer end outside the valid range, and the coverage.
    /// NaN gives NaN and [`Coverage::Invalid`].
    #[must_use]
    pub fn evaluate(&self, temperature: f64) -> (f64, Coverage) {
        let held = temperature.clamp(self.valid.min(), self.valid.max());
        (self.shape.evaluate(held), self.valid.coverage(temperature))
    }

    /// The temperatures inside the valid range at which the curve turns round, coldest first. Between two of them
    /// (and the ends) it is monotone.
    #[must_use]
    pub fn turning_points(&self) -> Vec<f64, MAX_TURNING_POINTS> {
        let (min, max) = (self.valid.min(), self.valid.max());
        match &self.shape {
            Shape::Polynomial(polynomial) => polynomial.turning_points(min, max).iter().copied().collect(),
            Shape::Table(table) => table.turning_points(min, max),
        }
    }

    /// Largest minus smallest zero-rate output over the valid range.
    #[must_use]
    pub fn peak_to_peak(&self) -> f64 {
        let mut least = f64::INFINITY;
        let mut most = f64::NEG_INFINITY;
        let ends = [self.valid.min(), self.valid.max()];
        for temperature in ends.into_iter().chain(self.turning_points()) {
            let (zro, _) = self.evaluate(temperature);
            least = least.min(zro);
            most = most.max(zro);
        }
        most - least
    }
}
