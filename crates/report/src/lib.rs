#![doc = include_str!("../README.md")]

mod calibration;
mod calibration_page;
mod candidates;
mod figure;
mod log_page;
mod lot;
mod lot_page;
pub mod number;
mod page;
mod paper;

pub use calibration::{
    AxisSoaks, CalibratedAxis, CalibrationReport, Check, CompensationTest, Curve, Direction, DriftFacts, Mode,
    RampPoint, SoakComparison, SoakPoint, TapDeviation, TestPoint, TrimFacts, TrimLine, TrimPoint, UnitFacts,
};
pub use log_page::LogPage;
pub use lot::{LotAxis, LotLimit, LotReport, LotUnit, Quantity, WorstUnit};
