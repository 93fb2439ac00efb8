#![doc = include_str!("../README.md")]

mod buffer;
mod clock;
mod dataflash;
mod format;
mod remark;
mod rows;
mod sensor;
mod streams;
mod ulog;
mod window;

pub use clock::wall_clock;
pub use dataflash::temperature_parameters;
pub use format::{Format, START_BYTES, read, recognise};
pub use remark::Remark;
pub use rows::{Ending, Rows, Sink};
pub use sensor::{Sensor, SensorKind};
