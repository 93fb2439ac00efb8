//! What an axis does with its calibration.

use serde::{Deserialize, Serialize};

/// What an axis does with its calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum Mode {
    /// Nothing: the control of the compensation test.
    #[default]
    Off,
    /// The paper: the tap from the temperature, nothing else.
    Trim,
    /// The wiper stays; the drift is subtracted in numbers.
    Digital,
    /// The tap from the temperature, and what is left below a tap subtracted in numbers.
    Hybrid,
}

impl Mode {
    /// Whether the wiper follows the temperature.
    #[must_use]
    pub const fn moves_wiper(self) -> bool {
        matches!(self, Self::Trim | Self::Hybrid)
    }

    /// Whether the reading is corrected in numbers.
    #[must_use]
    pub const fn corrects(self) -> bool {
        matches!(self, Self::Digital | Self::Hybrid)
    }

    /// `"off"`, `"trim"`, `"digital"` or `"hybrid"`, as in recordings and summaries.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Trim => "trim",
            Self::Digital => "digital",
            Self::Hybrid => "hybrid",
        }
    }
}
