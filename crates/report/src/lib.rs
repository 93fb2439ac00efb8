#![doc = include_str!("../README.md")]

mod advice;
mod alike;
mod board_page;
mod by_log;
mod candidates;
mod certificate;
mod figure;
mod live_page;
mod log_page;
mod lot;
mod lot_page;
pub mod number;
mod page;
mod panels;
mod paper;
mod ranges;
mod trend;
mod units_page;

pub use advice::advice;
pub use alike::{alike, few};
pub use board_page::board_page;
pub use by_log::by_log_sentence;
pub use certificate::certificate;
pub use live_page::{LiveBoard, LiveBoards, LiveRun, RunGroup, RunGroups, RunStep, StepState};
pub use log_page::LogPage;
pub use lot::{LotAxis, LotBeside, LotLimit, LotReport, LotUnit, Quantity, WorstUnit};
pub use ranges::{believed_temperatures, measured_temperatures};
pub use trend::trend_sentences;
pub use units_page::{UnitAxis, UnitCalibration, UnitCalibrations, UnitsReport};
