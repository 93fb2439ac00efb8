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
//! A drift with history ([`crate::drift::History`]) has no table of edges: the device evaluates it, in integers again, and
//! compares it with the middles between taps, in counts. Mode trim stays with the static table.
//!
//! Signs: a reading `R` at tap `N` is `V(T) + effect(N)`. The correction is what is subtracted from it,
//! `V(T) + effect(N) - V0`, so that the corrected reading is the centre `V0` at rest.

mod axis;
mod axis_law;
mod codes;
mod compose;
mod dynamic;
mod edges;
mod effects;
mod fixed;
mod interval;
mod mode;
mod numbers;
mod q16;
mod refused;
mod sample;
mod settling;

pub use axis::{AxisCompensation, GroupOutcome};
pub use axis_law::AxisLaw;
pub use compose::{LowPass, StaticLaw};
pub use edges::EdgeTable;
pub use fixed::FixedDrift;
pub use interval::{Interval, MAX_INTERVALS};
pub use mode::Mode;
pub use numbers::{
    CurveNumbers, DriftNumbers, HistoryNumbers, LawNumbers, LowPassNumbers, MemoryNumbers, PolynomialNumbers,
    TableNumbers, TermNumbers, TrimNumbers,
};
pub use q16::Q16;
pub use refused::{EdgeError, LawRefused, Part, Unrepresentable};
pub use sample::SampleCorrection;

#[cfg(test)]
mod tests;
