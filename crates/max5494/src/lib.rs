#![no_std]
#![doc = include_str!("../README.md")]

mod channel;
mod driver;
pub mod frame;
mod position;

pub use channel::{Channel, Channels};
pub use driver::{Max5494, NV_BUSY_MS};
pub use position::Position;
