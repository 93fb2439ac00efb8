//! Compensation: temperature in; a wiper request and a digital correction out.
//!
//! The same law exists twice. [`StaticLaw`] is the f64 law, written as the paper writes it (eq. 6). The device runs
//! [`EdgeTable`] and [`FixedDrift`]: integers only, made from the f64 law by the host ([`LawNumbers::new`]), and compared
//! with it at all 65 536 temperature codes in the tests. Coefficients ([`AxisLaw`]) are kept apart from state
//! ([`AxisCompensation`]).
//!
//! A record carries the integers ([`LawNumbers`]), and a device does no floating point. The host, which has both forms,
//! holds each against the other before a record leaves it; the device, which has the integers alone, believes none of them
//! unchecked ([`AxisLaw::from_numbers`]).
//!
//! A drift with history ([`crate::drift::History`]) has no table of edges: the device evaluates it ([`FixedHistory`]) and
//! compares it with the middles between taps, in counts. Mode trim stays with the static table.
//!
//! Signs: a reading `R` at tap `N` is `V(T) + effect(N)`. The correction is what is subtracted from it,
//! `V(T) + effect(N) - V0`, so that the corrected reading is the centre `V0` at rest.

mod axis;
mod axis_law;
mod dynamic;
mod edges;
mod effects;
mod fixed;
mod law;
mod numbers;
mod rounding;
mod settling;

use serde::{Deserialize, Serialize};

pub use axis::{AxisCompensation, GroupOutcome};
pub use axis_law::{AxisLaw, LawRefused, Part};
pub use dynamic::{FixedHistory, FixedHistoryState};
pub use edges::{EdgeError, EdgeTable, Interval, MAX_INTERVALS};
pub use fixed::{FixedDrift, Q16};
pub use law::StaticLaw;
pub use numbers::{
    CurveNumbers, DriftNumbers, HistoryNumbers, LawNumbers, LowPassNumbers, MemoryNumbers, PolynomialNumbers,
    TableNumbers, TermNumbers, TrimNumbers,
};
pub use rounding::{ACCURACY_COUNTS, Unrepresentable};
pub use settling::{LowPass, Settling};

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

#[cfg(test)]
mod tests;
