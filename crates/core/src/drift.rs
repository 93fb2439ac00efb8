//! Drift: the zero-rate output as a function of temperature, with the range over which it was measured.
//!
//! A model works in the gyro's own temperature unit `T` (counts on the analogue board, degrees C on a digital IMU) and
//! gives the reading in the unit it was fitted in (counts, or a rate). Polynomials are kept in the centred, scaled
//! variable `x = (T - centre) / half_span`, in which order 5 is still well conditioned; [`Polynomial::raw_coefficients`]
//! gives the form that papers print.

mod history;
mod polynomial;
mod table;

use heapless::Vec;
use serde::{Deserialize, Serialize};

pub use history::{
    History, HistoryState, KNOWN_FROM, Knowledge, MAX_HISTORY_TERMS, Memory, Term, belief, evaluate_dynamic, lean,
};
pub(crate) use polynomial::substitute;
pub use polynomial::{MAX_ORDER, Polynomial};
pub use table::{MAX_KNOTS, Table};

/// The most temperatures at which a drift model can turn round: one for each inner knot of the longest table.
pub const MAX_TURNING_POINTS: usize = MAX_KNOTS - 2;

/// A span of temperature and the centred variable on it: `x = (T - centre) / half_span`, -1 to 1 from end to end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "(f64, f64)", into = "(f64, f64)")]
pub struct Scale {
    centre: f64,
    half_span: f64,
}

impl Scale {
    /// The scale that maps `min..max` to -1..1; `None` unless both are finite and `min < max`.
    #[must_use]
    pub fn spanning(min: f64, max: f64) -> Option<Self> {
        Self::new(f64::midpoint(min, max), 0.5 * (max - min))
    }

    /// A scale by its centre and half span, in the temperature's unit; `None` unless finite and `half_span > 0`.
    #[must_use]
    pub fn new(centre: f64, half_span: f64) -> Option<Self> {
        (centre.is_finite() && half_span.is_finite() && half_span > 0.0).then_some(Self { centre, half_span })
    }

    /// The temperature at `x = 0`.
    #[must_use]
    pub const fn centre(&self) -> f64 {
        self.centre
    }

    /// The temperature from `x = 0` to `x = 1`.
    #[must_use]
    pub const fn half_span(&self) -> f64 {
        self.half_span
    }

    /// The centred variable at a temperature.
    #[must_use]
    pub fn x(&self, temperature: f64) -> f64 {
        (temperature - self.centre) / self.half_span
    }

    /// The temperature at a value of the centred variable.
    #[must_use]
    pub fn temperature(&self, x: f64) -> f64 {
        self.centre + self.half_span * x
    }
}

impl TryFrom<(f64, f64)> for Scale {
    type Error = &'static str;
    fn try_from((centre, half_span): (f64, f64)) -> Result<Self, Self::Error> {
        Self::new(centre, half_span).ok_or("a scale needs a finite centre and a half span above zero")
    }
}

impl From<Scale> for (f64, f64) {
    fn from(scale: Scale) -> Self {
        (scale.centre, scale.half_span)
    }
}

/// The temperatures over which a model was measured. Outside it a model is held at its nearer end.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "(f64, f64)", into = "(f64, f64)")]
pub struct ValidRange {
    min: f64,
    max: f64,
}

impl ValidRange {
    /// A range in the gyro's own temperature unit; `None` unless both ends are finite and `min < max`.
    #[must_use]
    pub fn new(min: f64, max: f64) -> Option<Self> {
        (min.is_finite() && max.is_finite() && min < max).then_some(Self { min, max })
    }

    /// The coldest temperature measured.
    #[must_use]
    pub const fn min(&self) -> f64 {
        self.min
    }

    /// The hottest temperature measured.
    #[must_use]
    pub const fn max(&self) -> f64 {
        self.max
    }

    /// Where a temperature lies against the range.
    #[must_use]
    pub fn coverage(&self, temperature: f64) -> Coverage {
        if temperature.is_nan() {
            Coverage::Invalid
        } else if temperature < self.min {
            Coverage::Below
        } else if temperature > self.max {
            Coverage::Above
        } else {
            Coverage::Inside
        }
    }
}

impl TryFrom<(f64, f64)> for ValidRange {
    type Error = &'static str;
    fn try_from((min, max): (f64, f64)) -> Result<Self, Self::Error> {
        Self::new(min, max).ok_or("a valid range needs finite ends in ascending order")
    }
}

impl From<ValidRange> for (f64, f64) {
    fn from(range: ValidRange) -> Self {
        (range.min, range.max)
    }
}

/// Where a temperature lies against a model's valid range. A degraded answer is data, not an error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Coverage {
    /// Within the range.
    Inside,
    /// Colder than the range; the model was held at its cold end.
    Below,
    /// Hotter than the range; the model was held at its hot end.
    Above,
    /// Not a number; there is no answer.
    Invalid,
}

/// The shape of a drift curve.
#[allow(clippy::large_enum_variant)] // no heap here to box the table in, and a device holds two of these
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
}

/// Zero-rate output over temperature: a shape and the range over which it holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
        let held = temperature.clamp(self.valid.min, self.valid.max);
        (self.shape.evaluate(held), self.valid.coverage(temperature))
    }

    /// The temperatures inside the valid range at which the curve turns round, coldest first. Between two of them
    /// (and the ends) it is monotone.
    #[must_use]
    pub fn turning_points(&self) -> Vec<f64, MAX_TURNING_POINTS> {
        let (min, max) = (self.valid.min, self.valid.max);
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
        let ends = [self.valid.min, self.valid.max];
        for temperature in ends.into_iter().chain(self.turning_points()) {
            let (zro, _) = self.evaluate(temperature);
            least = least.min(zro);
            most = most.max(zro);
        }
        most - least
    }
}

#[cfg(test)]
mod tests;
