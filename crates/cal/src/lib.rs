#![doc = include_str!("../README.md")]

pub mod calibration;
pub mod compose;
pub mod condition;
pub mod device_record;
pub mod fit;
pub mod in_chamber;
pub mod log;
pub mod log_fit;
pub mod matching;
pub mod quality;
pub mod ramp_fit;
pub mod table;
pub mod units;

pub use zerorate_recording as recording;
pub use zerorate_source as source;
