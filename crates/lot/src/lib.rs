#![doc = include_str!("../README.md")]

pub mod auto;
pub mod dataset;
pub mod engine;
pub mod export;
pub mod fitted;
pub mod models;
pub mod out;
pub mod poly;
pub mod raw;
pub mod report;
pub mod run;
pub mod simulate;
pub mod solve;
pub mod table;
