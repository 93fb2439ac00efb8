//! What `zerorate apply` does: a log with the bias by a calibration beside every rate.

mod same;
mod sensors;

use std::io::{self, Write};

use thiserror::Error;
use zerorate_core::drift::{Coverage, Knowledge, ValidRange};
use zerorate_fit::predict::{DriftModel, Prediction, Predictor, Start};

pub use same::are_of_one_log;
pub use sensors::{AppliedSensors, COLUMNS, SensorFault, apply_to_sensors};

use zerorate_cal::log::{Clock, LogError, Ticks};
use zerorate_cal::source::Faulty;
use zerorate_cal::table::{Table, TableError};
use zerorate_cal::units::WrittenTemperature;

/// The model to apply to one rate column.
#[derive(Debug, Clone, PartialEq)]
pub struct AppliedModel {
    /// The rate column's name.
    pub column: String,
    /// The temperature column's name.
    pub temperature: String,
    /// The unit in which that is written.
    pub written_temperature: WrittenTemperature,
    /// The model, in its own unit of rates and of temperature.
    pub model: DriftModel,
    /// The temperatures that it was fitted to.
    pub measured: ValidRange,
    /// One of what is written in the column, in the model's unit of rates.
    pub factor: f64,
}

/// The temperatures that all of some ranges hold, least and greatest.
pub fn in_common(ranges: impl Iterator<Item = ValidRange>) -> [f64; 2] {
    ranges.fold([f64::NEG_INFINITY, f64::INFINITY], |[min, max], range| [min.max(range.min()), max.min(range.max())])
}

/// The time of a log, and what is known where it begins.
#[derive(Debug, Clone)]
pub struct AppliedTo<'a> {
    /// The time column's name, and its clock as the log was surveyed; `None` where the log has none.
    pub time: Option<(&'a str, &'a Clock)>,
    /// What is known where the log begins.
    pub start: Start,
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
    /// Rows with a temperature outside of what a curve was fitted to, those among them: there it goes on as it ends.
    pub unmeasured: u64,
    /// Rows at which a history was not known yet: the prediction is uncertain by up to what it adds.
    pub uncertain: u64,
    /// The file's last line, where it was cut and left out.
    pub cut_line: Option<u64>,
}

/// What is to be known of one row, of all its models together.
#[derive(Debug, Clone, Copy, Default)]
struct RowTold {
    without_temperature: bool,
    outside: bool,
    unmeasured: bool,
    uncertain: bool,
}

impl RowTold {
    /// Takes in what one model predicts of the row.
    fn take(&mut self, temperature: f64, measured: ValidRange, predicted: &Prediction) {
        let is_outside = |coverage| matches!(coverage, Coverage::Below | Coverage::Above);
        self.without_temperature |= temperature.is_nan();
        self.outside |= is_outside(predicted.coverage);
        self.unmeasured |= is_outside(measured.coverage(temperature));
        self.uncertain |= predicted.knowledge == Knowledge::Uncertain && !temperature.is_nan();
    }
}

impl Applied {
    /// Counts a row that was written.
    fn count(&mut self, row: RowTold) {
        self.rows += 1;
        self.without_temperature += u64::from(row.without_temperature);
        self.outside += u64::from(row.outside);
        self.unmeasured += u64::from(row.unmeasured);
        self.uncertain += u64::from(row.uncertain);
    }
}

/// Why a log cannot be corrected.
#[derive(Debug, Error)]
pub enum ApplyError {
    /// The log cannot be read.
    #[error(transparent)]
    Table(#[from] TableError),
    /// An autopilot's log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The calibration is not for an autopilot's log.
    #[error(transparent)]
    Sensor(#[from] Faulty<SensorFault>),
    /// The log's time is not known.
    #[error(transparent)]
    Time(#[from] Faulty<TimeFault>),
    /// The corrected log cannot be written.
    #[error("{0}")]
    Write(#[from] io::Error),
}

/// Why the time of a log's rows is not known.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum TimeFault {
    /// A model has a lag or a drift in time, and the log has no time.
    #[error("the model needs the time of each row, and no time column was found: say which (`time`)")]
    NoTime,
    /// The time column's unit is not known.
    #[error("column '{column}' names no unit and the log's length fits none: say it (`time_unit`)")]
    NoUnit {
        /// The time column.
        column: String,
    },
}

/// Writes a table again as comma-separated text, every row and column kept, with `predicted_<column>` (the bias by the
/// model, in the column's unit) and `corrected_<column>` (rate less bias) added for each model. A row without a rate
/// still gets its prediction; a row without a temperature gets neither.
///
/// A history runs through every row with a temperature, as it would on a device that started with the first.
///
/// # Errors
/// When the log cannot be read, a column is not there, a model needs a time that the log does not have, or the output
/// cannot be written.
pub fn apply(
    table: &Table,
    to: &AppliedTo<'_>,
    models: &[AppliedModel],
    output: impl Write,
) -> Result<Applied, ApplyError> {
    let mut columns = Vec::new();
    for model in models {
        columns.extend([table.column(&model.temperature)?, table.column(&model.column)?]);
    }
    let needs_time = models.iter().any(|own| own.model.needs_time(to.start));
    let mut ticks = None;
    if needs_time {
        let (column, own) = timed(table, to)?;
        columns.push(column);
        ticks = Some(own);
    }
    let mut predictors: Vec<Predictor<'_>> = models.iter().map(|own| Predictor::new(&own.model, to.start)).collect();
    let csv_error = |error: csv::Error| ApplyError::Write(error.into());
    let mut writer = csv::Writer::from_writer(output);
    let added =
        models.iter().flat_map(|own| [format!("predicted_{}", own.column), format!("corrected_{}", own.column)]);
    writer.write_record(table.names().iter().cloned().chain(added)).map_err(csv_error)?;
    let mut applied = Applied::default();
    for batch in table.batches_with_cells(&columns)? {
        let batch = batch?;
        applied.cut_line = batch.cut_line;
        for (row, cells) in batch.cells.iter().enumerate() {
            let seconds = |ticks: &mut Ticks<'_>| ticks.seconds(batch.columns[2 * models.len()][row]);
            let time_s = ticks.as_mut().map_or(f64::NAN, seconds);
            let mut added = Vec::with_capacity(2 * models.len());
            let mut told = RowTold::default();
            for ((predictor, own), columns) in predictors.iter_mut().zip(models).zip(batch.columns.chunks(2)) {
                let temperature = own.written_temperature.read(columns[0][row]);
                let predicted = predictor.predict(time_s, temperature);
                told.take(temperature, own.measured, &predicted);
                let bias = predicted.bias / own.factor;
                added.extend([bias, columns[1][row] - bias].map(cell));
            }
            writer.write_record(cells.iter().chain(&added)).map_err(csv_error)?;
            applied.count(told);
        }
    }
    writer.flush()?;
    Ok(applied)
}

/// A number's cell; empty where there is none.
fn cell(value: f64) -> String {
    if value.is_nan() { String::new() } else { value.to_string() }
}

/// The place of a log's column of times, and these from the first row on.
fn timed<'a>(table: &Table, to: &AppliedTo<'a>) -> Result<(usize, Ticks<'a>), ApplyError> {
    let (name, clock) = to.time.ok_or_else(|| table.source().faulty::<TimeFault>(TimeFault::NoTime))?;
    if !clock.is_known() {
        return Err(table.source().faulty::<TimeFault>(TimeFault::NoUnit { column: name.to_owned() }).into());
    }
    Ok((table.column(name)?, clock.again()))
}

#[cfg(test)]
mod tests;
