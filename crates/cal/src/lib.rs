#![doc = include_str!("../README.md")]

pub mod apply;
pub mod choose;
pub mod condition;
pub mod fit;
pub mod log_fit;
pub mod quality;
pub mod recording;
pub mod table;
