//! How a temperature stands in a controller.

use serde::{Deserialize, Serialize};

/// How a temperature stands in registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// One register, signed, scaled.
    I16,
    /// Two registers, IEEE 754.
    F32,
}

/// Which register of two comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WordOrder {
    /// The one with sign and exponent.
    HighFirst,
    /// The other.
    LowFirst,
}

/// Degrees of a controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Degrees {
    /// Celsius.
    C,
    /// Fahrenheit.
    F,
}
