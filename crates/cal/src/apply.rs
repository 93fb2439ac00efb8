//! What `zerorate apply` does: a log with the bias by a calibration beside every rate.

use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use thiserror::Error;
use zerorate_core::drift::{Drift, History, HistoryState, Knowledge, Memory, Term, evaluate_dynamic};

use crate::calibration::TimeDrift;
use crate::table::{TableError, TableFile, TimeUnit};
use crate::whole_file::WholeFile;

/// The model to apply to one rate column.
#[derive(Debug, Clone, PartialEq)]
pub struct AppliedDrift {
    /// The rate column's name.
    pub column: String,
    /// The curve, in the column's unit and the temperature column's. Outside its valid range it is held at its end. With a
    /// history, the one for when that is not known.
    pub drift: Drift,
    /// What the drift remembers; it starts at the log's first row with a temperature.
    pub history: Option<History>,
    /// The drift in time of the recording that the model came from. With one, the log is taken for that recording: its
    /// rows have that recording's times, and the history is believed from its start, as the fit did.
    pub time_drift: Option<TimeDrift>,
}

/// The columns of a log that a model needs beside the rates.
#[derive(Debug, Clone, PartialEq)]
pub struct AppliedTo<'a> {
    /// The temperature column's name.
    pub temperature: &'a str,
    /// The time column's name; `None` where the log has none.
    pub time: Option<&'a str>,
    /// The time's unit; without one the log's length decides ([`TimeUnit::by_duration`]).
    pub time_unit: Option<TimeUnit>,
    /// Predict rows of the recording that the models came from: with their drift in time and a history that is believed
    /// from its start.
    pub own_recording: bool,
}

/// What was done.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Applied {
    /// Rows written.
    pub rows: u64,
    /// Rows without a temperature, whose predictions are empty.
    pub without_temperature: u64,
    /// Rows with a temperature outside a curve's valid range, at which the curve was held.
    pub outside: u64,
    /// Rows at which a history was not known yet: the prediction leans on the static curve.
    pub uncertain: u64,
}

/// Why a log cannot be corrected.
#[derive(Debug, Error)]
pub enum ApplyError {
    /// The log cannot be read.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A model has a lag or a drift in time, and the log has no time.
    #[error(
        "{}: the model needs the time of each row, and no time column was found: say which with --time", path.display()
    )]
    NoTime {
        /// The log.
        path: PathBuf,
    },
    /// The time column's unit is not known.
    #[error(
        "{}: column '{column}' names no unit and the log's length fits none: say it with --time-unit", path.display()
    )]
    NoTimeUnit {
        /// The log.
        path: PathBuf,
        /// The time column.
        column: String,
    },
    /// The corrected log cannot be written.
    #[error("{}: cannot be written: {source}: an earlier file there is as it was", path.display())]
    Write {
        /// The output file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

/// Writes a log again as comma-separated text, every row and column kept, with `predicted_<column>` (the bias by the
/// model) and `corrected_<column>` (rate less bias) added for each model. A row without a rate still gets its prediction;
/// a row without a temperature gets neither. The output appears at once when it is whole.
///
/// A history runs through every row with a temperature, as it would on a device that started with the first.
///
/// # Errors
/// When the log cannot be read, a column is not there, a model needs a time that the log does not have, or the output
/// cannot be written.
pub fn apply(log: &Path, to: &AppliedTo<'_>, drifts: &[AppliedDrift], output: &Path) -> Result<Applied, ApplyError> {
    let table = TableFile::open(log)?;
    let mut columns = vec![table.column(to.temperature)?];
    for drift in drifts {
        columns.push(table.column(&drift.column)?);
    }
    let needs_time = drifts.iter().any(|drift| drift.needs_time(to.own_recording));
    let clock = if needs_time { Some(Clock::of(&table, to)?) } else { None };
    columns.extend(clock.as_ref().map(|clock| clock.column));
    let write_error = |source| ApplyError::Write { path: output.to_owned(), source };
    let file = WholeFile::create(output).map_err(write_error)?;
    let mut predictors: Vec<Predictor<'_>> =
        drifts.iter().map(|drift| Predictor::new(drift, to.own_recording)).collect();
    write(&table, &columns, clock.as_ref(), &mut predictors, file, write_error)
}

impl AppliedDrift {
    fn needs_time(&self, own_recording: bool) -> bool {
        let lags = |term: &Term| matches!(term.memory, Memory::Lag { .. });
        let history = self.history.as_ref().is_some_and(|history| history.terms().iter().any(lags));
        history || (own_recording && self.time_drift.is_some())
    }
}

/// The time of a log's rows.
struct Clock {
    column: usize,
    first: f64,
    unit_s: f64,
}

impl Clock {
    fn of(table: &TableFile, to: &AppliedTo<'_>) -> Result<Self, ApplyError> {
        let name = to.time.ok_or_else(|| ApplyError::NoTime { path: table.path().to_owned() })?;
        let column = table.column(name)?;
        let (mut first, mut last) = (f64::NAN, f64::NAN);
        for batch in table.batches(&[column])? {
            for time in batch?.columns[0].iter().copied().filter(|time| time.is_finite()) {
                first = if first.is_nan() { time } else { first };
                last = time;
                if to.time_unit.is_some() {
                    break;
                }
            }
            if to.time_unit.is_some() && first.is_finite() {
                break;
            }
        }
        let unit = to.time_unit.or_else(|| TimeUnit::by_duration(last - first));
        let none = || ApplyError::NoTimeUnit { path: table.path().to_owned(), column: name.to_owned() };
        Ok(Self { column, first, unit_s: unit.ok_or_else(none)?.seconds() })
    }

    /// Seconds from the log's first row.
    fn seconds(&self, time: f64) -> f64 {
        (time - self.first) * self.unit_s
    }
}

/// A model at work on a log.
struct Predictor<'a> {
    applied: &'a AppliedDrift,
    own_recording: bool,
    state: HistoryState,
    before_s: f64,
}

impl<'a> Predictor<'a> {
    fn new(applied: &'a AppliedDrift, own_recording: bool) -> Self {
        Self { applied, own_recording, state: HistoryState::default(), before_s: f64::NAN }
    }

    /// The bias of a row, and whether its history is known.
    fn predict(&mut self, time_s: f64, temperature: f64) -> (f64, Knowledge) {
        let AppliedDrift { drift, history, time_drift, .. } = self.applied;
        if let Some(history) = history {
            // A row without a time leaves its step to the next; NaN is no step.
            let step = time_s - self.before_s;
            if time_s.is_finite() {
                self.before_s = time_s;
            }
            history.advance(drift, &mut self.state, temperature, step);
        }
        if !self.own_recording {
            let (bias, _, knowledge) = evaluate_dynamic(drift, history.as_ref(), &self.state, temperature);
            return (bias, knowledge);
        }
        let bias = match history {
            Some(history) if !temperature.is_nan() => history.evaluate_as_known(&self.state),
            _ => drift.evaluate(temperature).0,
        };
        (bias + time_drift.map_or(0.0, |drift| drift.at(time_s)), Knowledge::Known)
    }
}

fn write(
    table: &TableFile,
    columns: &[usize],
    clock: Option<&Clock>,
    predictors: &mut [Predictor<'_>],
    file: WholeFile,
    write_error: impl Fn(io::Error) -> ApplyError + Copy,
) -> Result<Applied, ApplyError> {
    let csv_error = |error: csv::Error| write_error(error.into());
    let mut writer = csv::Writer::from_writer(BufWriter::new(file));
    let names = predictors.iter().map(|predictor| &predictor.applied.column);
    let added = names.flat_map(|name| [format!("predicted_{name}"), format!("corrected_{name}")]);
    writer.write_record(table.names().iter().cloned().chain(added)).map_err(csv_error)?;
    let mut applied = Applied::default();
    for batch in table.batches_with_cells(columns)? {
        let batch = batch?;
        for (row, cells) in batch.cells.iter().enumerate() {
            let temperature = batch.columns[0][row];
            let time_s = clock.map_or(f64::NAN, |clock| clock.seconds(batch.columns[1 + predictors.len()][row]));
            let mut added = Vec::with_capacity(2 * predictors.len());
            let (mut outside, mut uncertain) = (false, false);
            for (predictor, column) in predictors.iter_mut().zip(&batch.columns[1..]) {
                let (predicted, knowledge) = predictor.predict(time_s, temperature);
                let valid = predictor.applied.drift.valid;
                outside |= temperature < valid.min() || temperature > valid.max();
                uncertain |= knowledge == Knowledge::Uncertain && !temperature.is_nan();
                added.extend([predicted, column[row] - predicted].map(cell));
            }
            writer.write_record(cells.iter().cloned().chain(added)).map_err(csv_error)?;
            applied.rows += 1;
            applied.without_temperature += u64::from(temperature.is_nan());
            applied.outside += u64::from(outside);
            applied.uncertain += u64::from(uncertain);
        }
    }
    let buffer = writer.into_inner().map_err(|error| write_error(error.into_error()))?;
    let file = buffer.into_inner().map_err(|error| write_error(error.into_error()))?;
    file.finish().map_err(write_error)?;
    Ok(applied)
}

/// A number's cell; empty where there is none.
fn cell(value: f64) -> String {
    if value.is_nan() { String::new() } else { value.to_string() }
}

#[cfg(test)]
mod tests;
