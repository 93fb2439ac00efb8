#![doc = include_str!("../README.md")]

mod ad7949;
mod bench;
mod burst;
mod master;
mod model;
mod random;
mod shared;

pub use ad7949::{Ad7949, Frame, Limits};
pub use bench::{Bench, Disturbance, Scan};
pub use burst::{Head, checked, head, scans, written};
pub use master::{ConverterDelay, ConverterSpi, Port, Timing};
pub use model::{Inputs, Model, Outputs, Scale};
pub use random::Random;
pub use shared::SharedPort;

/// Simulated time, picoseconds.
pub type Ps = u64;
