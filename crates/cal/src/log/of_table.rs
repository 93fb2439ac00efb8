//! A table as a log: one sensor, whose axes are the rate columns.

use std::path::Path;

use super::survey::{Survey, times, wanted};
use super::{Ending, LogError, Rows, Sink, Stream};
use crate::table::{Columns, Resolved, TableFile};

/// A table that was opened and surveyed.
#[derive(Debug)]
pub(crate) struct TableLog {
    table: TableFile,
    columns: Resolved,
    pub(super) survey: Survey,
}

impl TableLog {
    /// Opens a table, finds its columns, and reads it once.
    pub(crate) fn open(path: &Path, columns: &Columns) -> Result<Self, LogError> {
        let table = TableFile::open(path)?;
        let columns = columns.resolve(&table)?;
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
        for batch in self.table.batches(&wanted(&self.columns))? {
            let batch = batch?;
            time_s.clear();
            time_s.extend(times(&batch, &self.columns).iter().map(|time| self.survey.seconds(*time)));
            time_s.resize(batch.rows(), f64::NAN);
            sink.rows(&Rows {
                stream: 0,
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
