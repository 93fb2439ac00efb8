#![doc = include_str!("../README.md")]

mod calibration;
mod calibration_page;
mod candidates;
mod figure;
mod log;
mod log_page;
mod lot;
mod lot_page;
pub mod number;
mod page;
mod paper;

pub use calibration::{
    AxisSoaks, CalibratedAxis, CalibrationReport, CandidateRow, Check, CompensationTest, Curve, Direction, DriftFacts,
    Mode, RampPoint, SoakComparison, SoakPoint, TapDeviation, TestPoint, TrimFacts, TrimLine, TrimPoint, UnitFacts,
};
pub use log::{LeftOut, LogAxis, LogPoint, LogReport, Parameters, RejectedSamples};
pub use lot::{LotAxis, LotLimit, LotReport, LotUnit, Quantity, WorstUnit};
