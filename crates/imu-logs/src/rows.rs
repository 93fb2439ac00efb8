//! What a log gives, and who takes it.

use std::time::SystemTime;

use crate::{Remark, Sensor};

/// Some successive rows of one sensor.
#[derive(Debug, Clone, Copy)]
pub struct Rows<'a> {
    /// The sensor, by its place among those met in the log, from 0.
    pub sensor: usize,
    /// How often time had started anew before these rows: several logs in one file.
    pub part: u32,
    /// The first row's number among the sensor's, from 0.
    pub first_row: u64,
    /// Seconds from the log's first row, one a row; NaN where not known.
    pub time_s: &'a [f64],
    /// Temperatures, one a row; NaN where there is none. Degrees Celsius in the logs of this crate.
    pub temperature: &'a [f64],
    /// Values, a vector an axis, one a row; NaN where there is none. In the logs of this crate three axes, in rad/s or
    /// m/s^2.
    pub values: &'a [Vec<f64>],
}

/// Who takes a log's rows as they go by.
pub trait Sink {
    /// A sensor was met, numbered from 0 in the order met. Its rows follow if this returns `true`.
    fn sensor(&mut self, sensor: &Sensor) -> bool;
    /// Some rows of a sensor that is wanted.
    fn rows(&mut self, rows: &Rows<'_>);
}

/// What is known of a log once it was read.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Ending {
    /// When its first row was taken, by the first time that a satellite receiver knew. `None` without one, or without a
    /// fix, and of several logs in one file, of which nobody knows whose receiver it was.
    pub started: Option<SystemTime>,
    /// What was lost, and what was undone.
    pub remarks: Vec<Remark>,
}
