#![doc = include_str!("../README.md")]

mod acquisition;

pub use acquisition::{GatewareAcquisition, scan_period_us};
