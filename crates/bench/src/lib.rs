#![doc = include_str!("../README.md")]
// Without boards, what only they ask of a device has no caller.
#![cfg_attr(not(feature = "boards"), allow(dead_code))]

#[cfg(feature = "boards")]
pub mod board;
pub mod calibrate;
pub mod calibrated;
pub mod checkpoint;
#[cfg(feature = "boards")]
pub mod choice;
pub mod client;
#[cfg(all(unix, feature = "boards"))]
pub mod emulated;
pub mod error;
pub mod evaluate;
mod following;
pub mod instruments;
pub mod link;
pub mod manual;
pub mod measure;
pub mod output;
pub mod plan;
pub mod plants;
pub mod procedure;
pub mod profile;
pub mod recorded;
pub mod remote;
pub mod results;
pub mod run;
#[cfg(feature = "boards")]
pub mod scan_line;
pub mod setup;
pub mod shared;
pub mod simulated;
pub mod soak_comparison;
mod soaking;
pub mod stepped;
pub mod steps;
pub mod study;
pub mod summary;
mod tick;
pub mod verify;
mod way_back;
