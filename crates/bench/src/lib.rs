#![doc = include_str!("../README.md")]

pub mod client;
pub mod error;
pub mod evaluate;
pub mod instruments;
pub mod link;
pub mod procedure;
pub mod run;
pub mod setup;
pub mod simulated;
pub mod steps;
