//! A recording of the bench as a log: its groups are rows, its two axes are those of one sensor.

use std::time::SystemTime;

use zerorate_core::compensate::Mode;
use zerorate_core::units::Axis;

use super::{Ending, Rows, Sink, Stream};
use crate::quality::{Reason, ReasonKind};
use crate::recording::{GroupRow, Recording};
use crate::units::{RateUnit, TemperatureUnit};

/// Gives the groups as rows. A group in which an axis was compensated has no drift to fit: its rate is left empty.
pub(super) fn read(recording: &Recording, sink: &mut dyn Sink) -> Ending {
    let mut ending = Ending { started: recording.info.started.map(SystemTime::from), ..Ending::default() };
    let stream = Stream {
        sensor: None,
        names: Axis::BOTH.map(|axis| axis.name().to_owned()).to_vec(),
        unit: RateUnit::Counts,
        temperature_unit: TemperatureUnit::Counts,
    };
    if recording.cut {
        let text = format!("the recording was cut off: its {} whole groups were read", recording.groups());
        ending.reasons.push(Reason::new(ReasonKind::Truncated, text));
    }
    if !sink.stream(&stream) {
        return ending;
    }
    let groups: Vec<&[GroupRow]> = recording.rows.chunk_by(|a, b| a.group == b.group).collect();
    let taps = |axis: Axis| recording.rows.iter().find(|row| row.axis == axis).map(|row| row.tap);
    let first = Axis::BOTH.map(taps);
    let mut compensated = 0;
    let mut values = vec![Vec::new(), Vec::new()];
    let mut temperature = Vec::new();
    let mut time_s = Vec::new();
    for group in groups {
        time_s.push(group[0].t_s);
        temperature.push(group[0].sums.mean_temperature().0);
        for ((column, axis), tap) in values.iter_mut().zip(Axis::BOTH).zip(first) {
            let row = group.iter().find(|row| row.axis == axis);
            let still = row.filter(|row| row.mode == Mode::Off && Some(row.tap) == tap);
            compensated += u32::from(row.is_some() && still.is_none());
            column.push(still.map_or(f64::NAN, |row| row.sums.mean_zro().0));
        }
    }
    if compensated > 0 {
        ending.notes.push(format!(
            "{compensated} readings were left out: the axis was compensated or its tap moved, and only the reading at one tap shows the drift"
        ));
    }
    sink.rows(&Rows { sensor: 0, part: 0, first_row: 0, time_s: &time_s, temperature: &temperature, values: &values });
    ending
}
