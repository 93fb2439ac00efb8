//! `zerorate apply`.

use std::io::{BufWriter, IntoInnerError};
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::Args;
use serde::Serialize;
use zerorate_cal::apply::{AppliedModel, AppliedTo, ApplyError, apply};
use zerorate_cal::calibration::{Calibration, Kind};
use zerorate_cal::table::{Columns, Table};
use zerorate_cal::units::{TimeUnit, WrittenRate};
use zerorate_cal::whole_file::WholeFile;
use zerorate_fit::predict::Start;

use super::Outcome;
use crate::log_arguments::UnitArguments;
use crate::progress::Busy;
use crate::screen::{Page, thousands};
use crate::{output, screen};

/// Correct a log by a calibration
///
/// Writes the log again as CSV, every row and column kept, with two columns added for each calibrated rate column:
/// predicted_COLUMN, the bias that the calibration gives for the row's temperature, and corrected_COLUMN, the rate less
/// that. A row with a temperature and no rate (empty or nan) still gets its prediction. Outside the calibrated range of
/// temperature the curve is held at its end, and such rows are counted.
///
/// It predicts as a device would that started with the log's first row: a model with a history (hysteresis, lag) leans on
/// its static curve until enough of the history was seen.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Apply {
    /// The calibration that `zerorate fit --out` wrote
    calibration: PathBuf,

    /// The log: text in columns or Parquet, also packed by gzip or zip, its rate columns named as in the log that was fitted
    #[arg(value_name = "FILE")]
    log: PathBuf,

    /// Write the corrected log here, as CSV
    #[arg(long, value_name = "FILE")]
    out: PathBuf,

    /// The temperature column, where its name does not make it plain
    #[arg(long, value_name = "COL")]
    temperature: Option<String>,

    /// The time column, where its name does not make it plain; models with lags need one
    #[arg(long, value_name = "COL")]
    time: Option<String>,

    /// The log is the recording that the calibration came from: add the slow drift in time that was found in it, and
    /// believe the history from the first row on, as the fit did
    #[arg(long)]
    with_time_drift: bool,

    #[command(flatten)]
    force: output::Force,

    /// Print JSON on standard output, and nothing else there
    #[arg(long)]
    json: bool,

    // The last: its heading would stand over what follows.
    #[command(flatten)]
    units: UnitArguments,
}

const EXAMPLES: &str = "\
Examples:
  zerorate apply calibration.json flight.csv --out corrected.csv
  zerorate apply calibration.json imu.parquet --temperature die_temp --out corrected.csv

To test a calibration on data it has not seen: empty the rate cells of some rows, fit, apply, and compare
predicted_COLUMN with what was in the cells.";

/// What was done, as JSON has it.
#[derive(Serialize)]
struct Done<'a> {
    schema: u32,
    out: &'a std::path::Path,
    columns: Vec<&'a str>,
    rows: u64,
    rows_without_temperature: u64,
    rows_outside_calibrated_range: u64,
    rows_with_unknown_history: u64,
    /// The last line, where the file ends without a line feed; it was left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    cut_line: Option<u64>,
    calibrated_temperature: [f64; 2],
    temperature_unit: &'static str,
}

/// What was found of the log's columns.
struct Found {
    table: Table,
    time: Option<String>,
    time_unit: Option<TimeUnit>,
    models: Vec<AppliedModel>,
}

impl Apply {
    pub fn run(&self) -> Result<Outcome> {
        output::check("--out", &self.out, &[&self.log, &self.calibration])?;
        let calibration = Calibration::read(&(&self.calibration).into())?;
        let Found { table, time, time_unit, models } = self.columns(&calibration)?;
        self.force.corrected_log("--out", &self.out)?;
        let busy = Busy::reading(&self.log);
        let to = AppliedTo {
            time: time.as_deref(),
            time_unit,
            start: if self.with_time_drift { Start::OwnRecording } else { Start::Unknown },
        };
        let cannot = || format!("{}: cannot be written: an earlier file there is as it was", self.out.display());
        let mut out = BufWriter::new(WholeFile::create(&self.out).with_context(cannot)?);
        let applied = apply(&table, &to, &models, &mut out).map_err(|error| match error {
            ApplyError::Write(error) => anyhow::Error::new(error).context(cannot()),
            other => other.into(),
        })?;
        let file = out.into_inner().map_err(IntoInnerError::into_error);
        file.and_then(WholeFile::finish).with_context(cannot)?;
        drop(busy);
        let min = models.iter().map(|own| own.model.drift.valid.min()).fold(f64::NEG_INFINITY, f64::max);
        let max = models.iter().map(|own| own.model.drift.valid.max()).fold(f64::INFINITY, f64::min);
        let unit = calibration.temperature_unit.name();
        let columns: Vec<&str> = models.iter().map(|own| own.column.as_str()).collect();
        if self.json {
            screen::print_json(&Done {
                schema: 1,
                out: &self.out,
                columns,
                rows: applied.rows,
                rows_without_temperature: applied.without_temperature,
                rows_outside_calibrated_range: applied.outside,
                rows_with_unknown_history: applied.uncertain,
                cut_line: applied.cut_line,
                calibrated_temperature: [min, max],
                temperature_unit: unit,
            })?;
            return Ok(Outcome::Done);
        }
        let mut page = Page::default();
        let columns = columns.join(", ");
        page.sentence(
            "",
            &format!("Wrote {}: {} rows, {columns} corrected.", self.out.display(), thousands(applied.rows)),
        );
        if applied.outside > 0 {
            let rows = thousands(applied.outside);
            let text = format!(
                "{rows} rows are outside the calibrated {min:.1} to {max:.1} {unit}: there the curve was held at its end"
            );
            page.sentence("  - ", &text);
        }
        if applied.uncertain > 0 {
            let rows = thousands(applied.uncertain);
            let text = format!(
                "{rows} rows come before enough of the temperature's history was seen: there the prediction leans on the static curve"
            );
            page.sentence("  - ", &text);
        }
        if applied.without_temperature > 0 {
            let rows = thousands(applied.without_temperature);
            page.sentence("  - ", &format!("{rows} rows have no temperature: they were kept, without a correction"));
        }
        if let Some(line) = applied.cut_line {
            let text = format!("the file ends without a line feed: line {line} may be cut, and was left out");
            page.sentence("  - ", &text);
        }
        page.print()?;
        Ok(Outcome::Done)
    }

    /// The columns, and what to apply to which rate column, in the log's order.
    fn columns(&self, calibration: &Calibration) -> Result<Found> {
        let table = Table::open(&(&self.log).into())?;
        let asked = Columns {
            temperature: self.temperature.clone(),
            time: self.time.clone(),
            rates: calibration.axes.keys().cloned().collect(),
            time_unit: self.units.time_unit,
            temperature_unit: self.units.temperature_unit,
            rate_unit: self.units.rate_unit,
            else_rate_unit: calibration.axes.values().find_map(|axis| WrittenRate::of(axis.rate_unit)),
        };
        let found = asked.resolve(&table).with_context(|| {
            let whose = match calibration.kind {
                Kind::Log => "the log that was fitted",
                Kind::AnalogueBoard => "an analogue board (x and y, in counts)",
            };
            format!("{} is for the rate columns of {whose}", self.calibration.display())
        })?;
        let mut models: Vec<(usize, AppliedModel)> = Vec::new();
        for sensor in &found.sensors {
            let temperature = &table.names()[sensor.temperature];
            let (own, of_log) = (calibration.temperature_unit, sensor.written_temperature.unit());
            ensure!(
                own == of_log,
                "{}: column '{temperature}' is in {}, and the calibration's temperatures are in {}: give the column in {2} with --temperature",
                self.log.display(),
                of_log.name(),
                own.name()
            );
            for rate in &sensor.rates {
                let axis = &calibration.axes[&rate.name];
                let to_own = WrittenRate::of(sensor.rate_unit).and_then(|unit| unit.in_unit(axis.rate_unit));
                let to_own = to_own.with_context(|| {
                    format!(
                        "{}: column '{}' is in {}, and the calibration's in {}: say which it is (--rate-unit)",
                        self.log.display(),
                        rate.name,
                        sensor.rate_unit,
                        axis.rate_unit
                    )
                })?;
                let model = AppliedModel {
                    column: rate.name.clone(),
                    temperature: temperature.clone(),
                    written_temperature: sensor.written_temperature,
                    model: axis.fit.model.clone(),
                    factor: rate.factor * to_own,
                };
                models.push((rate.column, model));
            }
        }
        models.sort_by_key(|(place, _)| *place);
        Ok(Found {
            time: found.time.map(|place| table.names()[place].clone()),
            time_unit: found.time_unit,
            models: models.into_iter().map(|(_, model)| model).collect(),
            table,
        })
    }
}
