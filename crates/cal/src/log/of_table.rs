//! A table as a log: one sensor, whose axes are the rate columns.

use super::survey::{Survey, times, wanted};
use super::{Ending, LogError, LogFault, Rows, Sink, Stream};
use crate::source::Source;
use crate::table::{Columns, Resolved, Table};

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
        let ending = Ending { notes: [&self.columns.notes[..], &self.survey.notes[..]].concat(), ..Ending::default() };
        let stream = Stream {
            sensor: None,
            names: self.columns.rate_names.clone(),
            unit: self.columns.rate_unit,
            temperature_unit: self.columns.temperature_unit,
        };
        if !sink.stream(&stream) {
            return Ok(ending);
        }
        let rates = self.columns.rates.len();
        let mut time_s = Vec::new();
        for batch in self.table.batches(&wanted(&self.columns)).map_err(LogFault::named)? {
            let batch = batch.map_err(LogFault::named)?;
            time_s.clear();
            time_s.extend(times(&batch, &self.columns).iter().map(|time| self.survey.seconds(*time)));
            time_s.resize(batch.rows(), f64::NAN);
            sink.rows(&Rows {
                sensor: 0,
                part: 0,
                first_row: batch.first_row,
                time_s: &time_s,
                temperature: &batch.columns[0],
                values: &batch.columns[1..=rates],
            });
        }
        Ok(ending)
    }
}
