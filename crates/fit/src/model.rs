//! Which model: a polynomial, a piecewise-linear table, or what held-out data choose.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;
use zerorate_core::compensate::CurveNumbers;
use zerorate_core::drift::{MAX_KNOTS, MAX_ORDER, Shape};

use crate::least_squares::Basis;

/// A model asked for: `poly:K`, `table:K` or `auto`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Model {
    /// A polynomial of this order, 1 to 5.
    Poly(usize),
    /// A piecewise-linear table of this many equal intervals, 1 to 32.
    Table(usize),
    /// What held-out error chooses: of groups, curve and history ([`crate::auto`]); of plain rows, the order alone.
    #[default]
    Auto,
}

/// A model that was asked for and is none.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{0}' is no model: give poly:1 to poly:{MAX_ORDER}, table:1 to table:{most}, or auto", most = MAX_KNOTS - 1)]
pub struct ModelError(String);

impl FromStr for Model {
    type Err = ModelError;
    fn from_str(text: &str) -> Result<Self, ModelError> {
        let unknown = || ModelError(text.to_owned());
        if text == "auto" {
            return Ok(Self::Auto);
        }
        let (kind, size) = text.split_once(':').ok_or_else(unknown)?;
        let size: usize = size.parse().map_err(|_| unknown())?;
        match kind {
            "poly" if (1..=MAX_ORDER).contains(&size) => Ok(Self::Poly(size)),
            "table" if (1..MAX_KNOTS).contains(&size) => Ok(Self::Table(size)),
            _ => Err(unknown()),
        }
    }
}

impl fmt::Display for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Poly(order) => write!(f, "poly:{order}"),
            Self::Table(intervals) => write!(f, "table:{intervals}"),
            Self::Auto => f.write_str("auto"),
        }
    }
}

impl Model {
    /// The basis whose fit serves every candidate of the model: for `auto`, powers up to the highest order.
    #[must_use]
    pub fn basis(self) -> Basis {
        match self {
            Self::Poly(order) => Basis::Powers(order),
            Self::Table(intervals) => Basis::PiecewiseLinear(intervals),
            Self::Auto => Basis::Powers(MAX_ORDER),
        }
    }

    /// The coefficients of the simplest candidate.
    #[must_use]
    pub fn least_coefficients(self) -> usize {
        match self {
            Self::Poly(size) | Self::Table(size) => size + 1,
            Self::Auto => 2,
        }
    }

    /// The model that a curve is of.
    #[must_use]
    pub fn of_shape(shape: &Shape) -> Self {
        match shape {
            Shape::Polynomial(polynomial) => Self::Poly(polynomial.order()),
            Shape::Table(table) => Self::Table(table.knots().len() - 1),
        }
    }

    /// The model that a device's curve was rounded from.
    #[must_use]
    pub fn of_numbers(curve: &CurveNumbers) -> Self {
        match curve {
            CurveNumbers::Polynomial(polynomial) => Self::Poly(polynomial.coefficients.len().saturating_sub(1)),
            CurveNumbers::Table(table) => Self::Table(table.knots.len().saturating_sub(1)),
        }
    }

    /// The model of a basis.
    #[must_use]
    pub fn of(basis: Basis) -> Self {
        match basis {
            Basis::Powers(order) => Self::Poly(order),
            Basis::PiecewiseLinear(intervals) => Self::Table(intervals),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn model_names_are_read_and_written() {
        for name in ["poly:1", "poly:5", "table:32", "auto"] {
            assert_eq!(name.parse::<Model>().unwrap().to_string(), name);
        }
        for name in ["poly:0", "poly:6", "table:33", "poly", "poly:x", "spline:3", ""] {
            let error = name.parse::<Model>().unwrap_err().to_string();
            assert!(error.contains("poly:1 to poly:5, table:1 to table:32"), "{error}");
        }
    }
}
