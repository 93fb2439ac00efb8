#![doc = include_str!("../README.md")]

pub mod apply;
pub mod calibration;
pub mod choose;
pub mod compose;
pub mod condition;
pub mod device_record;
pub mod drift_fit;
pub mod fit;
pub mod log_fit;
pub mod quality;
pub mod recording;
pub mod report;
pub mod table;
pub mod trim_fit;
pub mod whole_file;
