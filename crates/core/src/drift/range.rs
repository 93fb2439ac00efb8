//! Where a model was measured.

use serde::{Deserialize, Serialize};

/// The temperatures over which a model was measured. Outside it a model is held at its nearer end.
#[derive(Debug, Clone, Copy, PartialEq)]
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
