#![doc = include_str!("../README.md")]

pub mod board_run;
pub mod calibration;
pub mod compose;
pub mod condition;
pub mod device_record;
pub mod fit;
pub mod in_chamber;
pub mod log;
pub mod log_fit;
pub mod matching;
mod named;
mod parquet_source;
pub mod quality;
pub mod ramp_fit;
pub mod recording;
pub mod summary;
pub mod table;
pub mod uncertainty;
pub mod units;
mod utc;

pub use zerorate_source as source;
