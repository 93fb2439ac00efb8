#![doc = include_str!("../README.md")]

mod dataset;
pub mod engine;
pub mod export;
mod fit;
pub mod models;
pub mod out;
pub mod raw;
pub mod report;
pub mod run;
pub mod simulate;
mod table;
