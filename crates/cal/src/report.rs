//! Reports: a calibration or a log as one HTML file that is whole by itself.
//!
//! The figures are SVG drawn by plotters, coloured by the page's style sheet so that they follow light, dark and print.
//! Nothing is loaded from anywhere, and equal contents make equal bytes.
//!
//! ```text
//! CalibrationReport (filled by the bench)  -> calibration_page  ─┐
//! LogReport         (filled from a LogFit) -> log_page          ─┴-> figure, page -> HTML
//! ```

mod calibration;
mod calibration_page;
mod candidates;
mod figure;
mod log;
mod log_page;
mod lot;
mod lot_page;
mod number;
mod page;
mod paper;

pub use calibration::{
    AxisSoaks, CalibratedAxis, CalibrationReport, CandidateRow, Check, CompensationTest, Curve, Direction, DriftFacts,
    Mode, RampPoint, SoakComparison, SoakPoint, TapDeviation, TestPoint, TrimFacts, TrimLine, TrimPoint, UnitFacts,
};
pub use log::{LeftOut, LogAxis, LogPoint, LogReport, Parameters, RejectedSamples};
pub use lot::{LotAxis, LotLimit, LotReport, LotUnit, Quantity, WorstUnit};
