//! The sensors of a log as they are met.

use std::time::SystemTime;

use crate::buffer::RowBuffer;
use crate::{Ending, Remark, Sensor, Sink, wall_clock};

/// Sensors of a log, at most: more than an autopilot has, so that a damaged log does not fill the memory with them.
const MAX_SENSORS: usize = 32;

/// Microseconds in a hundred years: no clock of a log, from power-on or from 1970, stands beyond.
const LATEST_US: u64 = 100 * 365 * 86_400 * 1_000_000;

/// Temperatures that matter can have, degrees C: from absolute zero to where no part is one any more.
const TEMPERATURES_C: std::ops::RangeInclusive<f64> = -273.15..=1000.0;

/// The sensors met so far.
#[derive(Debug, Default)]
pub(super) struct Streams {
    sensors: Vec<(Sensor, Option<RowBuffer>)>,
    passed_over: u64,
    impossible: u64,
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

    /// Takes in a row of a sensor, if its time and its temperature can be any: bits that turned over make others, and no
    /// checksum tells.
    pub(super) fn push(
        &mut self,
        number: usize,
        time_us: u64,
        temperature: f64,
        values: [f64; 3],
        sink: &mut dyn Sink,
    ) {
        if time_us > LATEST_US || !(temperature.is_nan() || TEMPERATURES_C.contains(&temperature)) {
            self.impossible += 1;
            return;
        }
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
        if self.impossible > 0 {
            remarks.push(Remark::Impossible { rows: self.impossible });
        }
        if self.passed_over > 0 {
            remarks.push(Remark::TooManySensors { most: MAX_SENSORS, rows: self.passed_over });
        }
        self.sensors.iter_mut().filter_map(|(_, buffer)| buffer.as_mut()).for_each(|buffer| buffer.flush(sink));
        Ending { started: self.started().filter(|_| restarts == 0), remarks }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Rows, SensorKind};

    #[derive(Default)]
    struct Times(Vec<f64>);

    impl Sink for Times {
        fn sensor(&mut self, _: &Sensor) -> bool {
            true
        }

        fn rows(&mut self, rows: &Rows<'_>) {
            self.0.extend(rows.time_s);
        }
    }

    #[test]
    fn a_row_of_a_time_or_a_temperature_that_none_can_be_is_left_out_and_told() {
        let (mut streams, mut times) = (Streams::default(), Times::default());
        let sensor = Sensor { kind: SensorKind::Gyro, instance: 0, device_id: None };
        let number = streams.number(sensor, &mut times).unwrap();
        // By hand: the third row's time and the fourth's temperature have a bit turned over.
        for (time_us, temperature) in [
            (1_000_000, 20.0),
            (1_500_000, f64::NAN),
            (9_151_314_445_494_000_000, 20.0),
            (2_500_000, 3.9e9),
            (3_000_000, 21.0),
        ] {
            streams.push(number, time_us, temperature, [0.0; 3], &mut times);
        }
        let ending = streams.finish(&mut times);
        assert_eq!(times.0, [0.0, 0.5, 2.0]);
        assert_eq!(ending.remarks, [Remark::Impossible { rows: 2 }]);
        assert!(ending.remarks[0].is_damage());
    }
}
