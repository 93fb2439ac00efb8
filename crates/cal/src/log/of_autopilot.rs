//! An autopilot's log: its units are those of its format by definition.

use std::io;

use super::{Ending, Sink, Stream};
use crate::quality::{Reason, ReasonKind};
use crate::source::Source;
use crate::units::{RateUnit, TemperatureUnit};
use imu_logs::{Format, Rows, Sensor, SensorKind};

/// Reads the log once.
pub(super) fn read(source: &Source, format: Format, sink: &mut dyn Sink) -> io::Result<Ending> {
    let read = imu_logs::read(source.open()?, format, &mut WithUnits(sink))?;
    let mut ending = Ending { started: read.started, ..Ending::default() };
    for remark in read.remarks {
        if remark.is_damage() {
            ending.reasons.push(Reason::new(ReasonKind::Truncated, remark.to_string()));
        } else {
            ending.notes.push(remark.to_string());
        }
    }
    Ok(ending)
}

/// Passes sensors on as streams.
struct WithUnits<'a>(&'a mut dyn Sink);

impl imu_logs::Sink for WithUnits<'_> {
    fn sensor(&mut self, sensor: &Sensor) -> bool {
        let unit = match sensor.kind {
            SensorKind::Gyro => RateUnit::RadPerS,
            SensorKind::Accelerometer => RateUnit::MetresPerS2,
        };
        let (names, temperature_unit) = (sensor.axis_names().to_vec(), TemperatureUnit::C);
        self.0.stream(&Stream { sensor: Some(*sensor), names, unit, temperature_unit })
    }

    fn rows(&mut self, rows: &Rows<'_>) {
        self.0.rows(rows);
    }
}
