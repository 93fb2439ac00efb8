#![no_std]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![doc = include_str!("../README.md")]

#[cfg(test)]
extern crate std;

mod channel;
mod driver;
#[cfg(feature = "async")]
mod driver_async;
pub mod frame;
mod position;

pub use channel::{Channel, Channels};
pub use driver::{Max5494, NV_BUSY_MS};
#[cfg(feature = "async")]
#[cfg_attr(docsrs, doc(cfg(feature = "async")))]
pub use driver_async::Max5494Async;
pub use position::Position;
