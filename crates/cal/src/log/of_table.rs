//! A table as a log: its gyros, whose axes are the rate columns.

use super::survey::{Survey, places, times, wanted};
use super::{Ending, LogError, LogFault, Rows, Sink, Stream};
use crate::source::Source;
use crate::table::{Columns, Resolved, ResolvedSensor, Table};

/// A table that was opened and surveyed.
#[derive(Debug)]
pub(crate) struct TableLog {
    table: Table,
    columns: Resolved,
    pub(super) survey: Survey,
}

impl TableLog {
    /// Opens a table, finds its columns, and reads it once.
    pub(crate) fn open(source: &Source, columns: &Columns) -> Result<Self, LogError> {
        let table = Table::open(source).map_err(LogFault::named)?;
        let columns = columns.resolve(&table).map_err(LogFault::named)?;
        let survey = Survey::of(&table, &columns)?;
        Ok(Self { table, columns, survey })
    }

    pub(super) fn read(&self, sink: &mut dyn Sink) -> Result<Ending, LogError> {
        let ending = Ending {
            started: self.survey.started(),
            notes: [&self.columns.notes[..], &self.survey.notes[..]].concat(),
            reasons: self.survey.reasons.clone(),
        };
        let wants: Vec<bool> = self.columns.sensors.iter().map(|sensor| sink.stream(&stream(sensor))).collect();
        if !wants.contains(&true) {
            return Ok(ending);
        }
        let (mut time_s, mut ticks) = (Vec::new(), self.survey.clock.again());
        for batch in self.table.batches(&wanted(&self.columns)).map_err(LogFault::named)? {
            let mut batch = batch.map_err(LogFault::named)?;
            // A line that was cut may be alone in its batch.
            if batch.rows() == 0 {
                continue;
            }
            time_s.clear();
            let times = times(&batch, &self.columns).iter();
            time_s.extend(times.map(|time| ticks.seconds(*time)));
            time_s.resize(batch.rows(), f64::NAN);
            for ((number, sensor), place) in self.columns.sensors.iter().enumerate().zip(places(&self.columns)) {
                if wants[number] {
                    let columns = &mut batch.columns[place..=place + sensor.rates.len()];
                    convert(sensor, columns);
                    sink.rows(&Rows {
                        sensor: number,
                        part: 0,
                        first_row: batch.first_row,
                        time_s: &time_s,
                        temperature: &columns[0],
                        values: &columns[1..],
                    });
                }
            }
        }
        Ok(ending)
    }
}

fn stream(sensor: &ResolvedSensor) -> Stream {
    Stream {
        sensor: sensor.sensor,
        names: sensor.rates.iter().map(|rate| rate.name.clone()).collect(),
        unit: sensor.rate_unit,
        temperature_unit: sensor.written_temperature.unit(),
    }
}

/// The edge: from here on temperatures and rates are in the units of the stream.
fn convert(sensor: &ResolvedSensor, columns: &mut [Vec<f64>]) {
    columns[0].iter_mut().for_each(|temperature| *temperature = sensor.written_temperature.read(*temperature));
    for (rate, column) in sensor.rates.iter().zip(&mut columns[1..]) {
        column.iter_mut().for_each(|value| *value *= rate.factor);
    }
}
