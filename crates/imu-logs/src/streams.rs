//! The sensors of a log as they are met.

use std::time::SystemTime;

use crate::buffer::RowBuffer;
use crate::{Ending, Remark, Sensor, Sink, wall_clock};

/// Sensors of a log, at most: more than an autopilot has, so that a damaged log does not fill the memory with them.
const MAX_SENSORS: usize = 32;

/// The sensors met so far.
#[derive(Debug, Default)]
pub(super) struct Streams {
    sensors: Vec<(Sensor, Option<RowBuffer>)>,
    passed_over: u64,
    first_us: Option<u64>,
    /// A time of the log, and UTC at it since 1970, both in microseconds.
    fix: Option<(u64, u64)>,
}

impl Streams {
    /// The number of a sensor, which is new if it was not met before; `None` where there are too many.
    pub(super) fn number(&mut self, sensor: Sensor, sink: &mut dyn Sink) -> Option<usize> {
        if let Some(number) = self.sensors.iter().position(|(known, _)| *known == sensor) {
            return Some(number);
        }
        let number = self.sensors.len();
        if number == MAX_SENSORS {
            self.passed_over += 1;
            return None;
        }
        let wanted = sink.sensor(&sensor);
        self.sensors.push((sensor, wanted.then(|| RowBuffer::new(number))));
        Some(number)
    }

    /// Whether no sensor was met.
    pub(super) fn is_empty(&self) -> bool {
        self.sensors.is_empty()
    }

    /// Seconds from the first row of any sensor.
    pub(super) fn seconds(&mut self, time_us: u64) -> f64 {
        let first = *self.first_us.get_or_insert(time_us);
        // Before the first, where several logs are in one file.
        if time_us >= first { (time_us - first) as f64 * 1e-6 } else { -((first - time_us) as f64 * 1e-6) }
    }

    /// Takes in UTC, in microseconds since 1970, at a time of the log; the first that a clock can say is kept.
    pub(super) fn set_clock(&mut self, time_us: u64, utc_us: u64) {
        if self.fix.is_none() && wall_clock(utc_us).is_some() {
            self.fix = Some((time_us, utc_us));
        }
    }

    /// When the first row was taken.
    fn started(&self) -> Option<SystemTime> {
        let (first_us, (time_us, utc_us)) = self.first_us.zip(self.fix)?;
        wall_clock(utc_us.checked_add(first_us)?.checked_sub(time_us)?)
    }

    /// Takes in a row of a sensor.
    pub(super) fn push(
        &mut self,
        number: usize,
        time_us: u64,
        temperature: f64,
        values: [f64; 3],
        sink: &mut dyn Sink,
    ) {
        let time_s = self.seconds(time_us);
        if let Some((_, Some(buffer))) = self.sensors.get_mut(number) {
            buffer.push(time_s, temperature, values, sink);
        }
    }

    /// Gives what is left, and says what was odd.
    pub(super) fn finish(mut self, sink: &mut dyn Sink) -> Ending {
        let mut remarks = Vec::new();
        let buffers = || self.sensors.iter().filter_map(|(sensor, buffer)| Some((sensor, buffer.as_ref()?)));
        let restarts = buffers().map(|(_, buffer)| buffer.parts()).max().unwrap_or(0);
        if restarts > 0 {
            remarks.push(Remark::SeveralLogs { restarts });
        }
        for (sensor, buffer) in buffers().filter(|(_, buffer)| buffer.disordered() > 0) {
            remarks.push(Remark::Disordered { sensor: *sensor, rows: buffer.disordered() });
        }
        if self.passed_over > 0 {
            remarks.push(Remark::TooManySensors { most: MAX_SENSORS, rows: self.passed_over });
        }
        self.sensors.iter_mut().filter_map(|(_, buffer)| buffer.as_mut()).for_each(|buffer| buffer.flush(sink));
        Ending { started: self.started().filter(|_| restarts == 0), remarks }
    }
}
