//! The sensors of a log as they are met, and what went wrong on the way.

use crate::log::SensorKind;
use crate::log::{Ending, RowBuffer, Sensor, Sink, Stream};
use crate::quality::{Reason, ReasonKind, TemperatureUnit};
use crate::table::RateUnit;

/// Sensors of a log, at most: more than an autopilot has, so that a damaged log does not fill the memory with them.
const MAX_SENSORS: usize = 32;

/// The sensors met so far.
#[derive(Debug, Default)]
pub(super) struct Streams {
    sensors: Vec<(Sensor, Option<RowBuffer>)>,
    passed_over: u64,
    first_us: Option<u64>,
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
        let unit = match sensor.kind {
            SensorKind::Gyro => RateUnit::RadPerS,
            SensorKind::Accelerometer => RateUnit::MetresPerS2,
        };
        let stream =
            Stream { sensor: Some(sensor), names: sensor.axis_names(), unit, temperature_unit: TemperatureUnit::C };
        let wanted = sink.stream(&stream);
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
        let mut ending = Ending::default();
        let buffers = || self.sensors.iter().filter_map(|(sensor, buffer)| Some((sensor, buffer.as_ref()?)));
        let parts = buffers().map(|(_, buffer)| buffer.parts()).max().unwrap_or(0);
        if parts > 0 {
            ending.notes.push(format!(
                "time begins anew {parts} times in the file: it holds {} logs, which were taken one after the other",
                parts + 1
            ));
        }
        for (sensor, buffer) in buffers().filter(|(_, buffer)| buffer.disordered() > 0) {
            ending.notes.push(format!(
                "{sensor}: {} rows whose time is before that of the row above were left out",
                buffer.disordered()
            ));
        }
        if self.passed_over > 0 {
            ending.notes.push(format!(
                "the log names more than {MAX_SENSORS} sensors: {} rows of the others were passed over",
                self.passed_over
            ));
        }
        for (_, buffer) in &mut self.sensors {
            if let Some(buffer) = buffer {
                buffer.flush(sink);
            }
        }
        ending
    }
}

/// What a damaged or cut file lost.
#[derive(Debug, Default)]
pub(super) struct Damage {
    /// Bytes passed over because they are no message.
    pub(super) skipped: u64,
    /// Where the file ends in the middle of a message.
    pub(super) cut_at: Option<u64>,
}

impl Damage {
    /// Tells of it.
    pub(super) fn tell(&self, ending: &mut Ending) {
        if let Some(bytes) = self.cut_at {
            let text =
                format!("the file is cut off in the middle of a message, at byte {bytes}: what is before it was read");
            ending.reasons.push(Reason::new(ReasonKind::Truncated, text));
        }
        if self.skipped > 0 {
            let text =
                format!("{} bytes of the file are damaged and were passed over: the rest was read", self.skipped);
            ending.reasons.push(Reason::new(ReasonKind::Truncated, text));
        }
    }
}
