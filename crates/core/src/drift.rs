//! Drift: the zero-rate output as a function of temperature, with the range over which it was measured.
//!
//! A model works in the gyro's own temperature unit `T` (counts on the analogue board, degrees C on a digital IMU) and
//! gives the reading in the unit it was fitted in (counts, or a rate). Polynomials are kept in the centred, scaled
//! variable `x = (T - centre) / half_span`, in which order 5 is still well conditioned; [`Polynomial::raw_coefficients`]
//! gives the form that papers print.

mod curve;
mod history;
mod polynomial;
mod range;
mod scale;
mod table;

pub use curve::{Drift, Shape};
pub(crate) use history::KNOWN_FROM;
pub use history::{History, HistoryState, Knowledge, MAX_HISTORY_TERMS, Memory, Term, evaluate_dynamic};
pub(crate) use polynomial::substitute;
pub use polynomial::{MAX_ORDER, Polynomial};
pub use range::{Coverage, ValidRange};
pub use scale::Scale;
pub use table::{MAX_KNOTS, MAX_TURNING_POINTS, Table};

#[cfg(test)]
mod tests;
