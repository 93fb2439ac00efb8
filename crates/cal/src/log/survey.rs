//! The first pass over a log: how much there is, how warm, and whether time runs forwards.

use super::{LogError, LogFault};
use crate::table::{Batch, Resolved, Table};
use crate::units::TimeUnit;

/// What one axis has to offer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AxisSurvey {
    /// Rows with a temperature and a rate.
    pub rows: u64,
    /// Rows without a temperature.
    pub missing_temperature: u64,
    /// Rows with a temperature and no rate.
    pub missing_rate: u64,
    /// The least temperature with a rate.
    pub min: f64,
    /// The greatest.
    pub max: f64,
}

impl AxisSurvey {
    /// Of no row yet.
    pub(crate) const EMPTY: Self =
        Self { rows: 0, missing_temperature: 0, missing_rate: 0, min: f64::INFINITY, max: f64::NEG_INFINITY };

    /// Takes in some rows.
    pub(crate) fn take(&mut self, temperatures: &[f64], rates: &[f64]) {
        for (temperature, rate) in temperatures.iter().zip(rates) {
            if !temperature.is_finite() {
                self.missing_temperature += 1;
            } else if !rate.is_finite() {
                self.missing_rate += 1;
            } else {
                self.rows += 1;
                self.min = self.min.min(*temperature);
                self.max = self.max.max(*temperature);
            }
        }
    }
}

/// What a log has to offer.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Survey {
    /// All rows.
    pub rows: u64,
    /// The first finite time, in the column's own unit; NaN without one.
    first_time: f64,
    last_time: f64,
    /// Seconds in one unit of the time column; NaN if not known.
    unit_s: f64,
    /// What was guessed.
    pub notes: Vec<String>,
}

impl Survey {
    /// Reads the whole log once.
    pub(super) fn of(table: &Table, columns: &Resolved) -> Result<Self, LogError> {
        let mut survey =
            Self { rows: 0, first_time: f64::NAN, last_time: f64::NAN, unit_s: f64::NAN, notes: Vec::new() };
        for batch in table.batches(&wanted(columns)).map_err(LogFault::named)? {
            let batch = batch.map_err(LogFault::named)?;
            survey.rows += batch.rows() as u64;
            if columns.time.is_some() {
                survey.take_time(&batch, table, columns)?;
            }
        }
        survey.settle_unit(table, columns);
        Ok(survey)
    }

    fn take_time(&mut self, batch: &Batch, table: &Table, columns: &Resolved) -> Result<(), LogError> {
        for (place, &time) in times(batch, columns).iter().enumerate().filter(|(_, time)| time.is_finite()) {
            if time < self.last_time {
                return Err(table.source().faulty(LogFault::TimeBackwards {
                    row: batch.first_row + place as u64 + 1,
                    column: columns.time.map(|column| table.names()[column].clone()).unwrap_or_default(),
                    before: self.last_time,
                    after: time,
                }));
            }
            if self.first_time.is_nan() {
                self.first_time = time;
            }
            self.last_time = time;
        }
        Ok(())
    }

    fn settle_unit(&mut self, table: &Table, columns: &Resolved) {
        let Some(time) = columns.time else {
            self.notes.push("no time column was found (`time` says which)".to_owned());
            return;
        };
        let name = &table.names()[time];
        let guessed = TimeUnit::by_duration(self.last_time - self.first_time);
        match columns.time_unit.or(guessed) {
            Some(unit) => self.unit_s = unit.seconds(),
            None => self
                .notes
                .push(format!("'{name}' names no unit and the log's length fits none (`time_unit` says which)")),
        }
        if let (None, Some(unit)) = (columns.time_unit, guessed) {
            let lasts = (self.last_time - self.first_time) * unit.seconds();
            self.notes.push(format!(
                "'{name}' names no unit: taken as {unit}, by which the log lasts {lasts:.0} s (`time_unit` says otherwise)"
            ));
        }
    }

    /// A time of the log's own unit in seconds from its first row; NaN if not known.
    pub(super) fn seconds(&self, time: f64) -> f64 {
        (time - self.first_time) * self.unit_s
    }

    /// The mean time between rows, seconds; NaN if not known.
    pub(super) fn step_s(&self) -> f64 {
        self.seconds(self.last_time) / (self.rows.max(2) - 1) as f64
    }
}

/// The columns that every pass reads: temperature, rates, and time where there is one.
pub(super) fn wanted(columns: &Resolved) -> Vec<usize> {
    std::iter::once(columns.temperature).chain(columns.rates.iter().copied()).chain(columns.time).collect()
}

/// The times of a batch of the wanted columns; empty without a time column.
pub(super) fn times<'a>(batch: &'a Batch, columns: &Resolved) -> &'a [f64] {
    if columns.time.is_some() { &batch.columns[1 + columns.rates.len()] } else { &[] }
}
