//! `zerorate apply`.

use std::io::{BufWriter, IntoInnerError};
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::Args;
use serde::Serialize;
use zerorate_apply::apply::{
    Applied, AppliedModel, AppliedSensors, AppliedTo, ApplyError, apply, apply_to_sensors, in_common,
};
use zerorate_bench::whole_file::WholeFile;
use zerorate_cal::calibration::{Calibration, Kind};
use zerorate_cal::log::{SensorChoice, autopilot_format, doubts};
use zerorate_cal::quality::ReasonKind;
use zerorate_cal::source::Source;
use zerorate_cal::table::{Columns, Table};
use zerorate_cal::units::{TimeUnit, WrittenRate};
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
/// Of an autopilot's log the rows of every calibrated sensor are written, one table for all: sensor, rate_unit, time_s,
/// temperature_c, x, y, z, and predicted_ and corrected_ of each. Its axes are matched as verify matches them.
///
/// It predicts as a device would that started with the log's first row: the history of a model that has
/// one (hysteresis, lag) begins there, and what is predicted is uncertain until enough of it was seen.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Apply {
    /// The calibration that `zerorate fit --out` wrote
    calibration: PathBuf,

    /// The log: text in columns or Parquet, also packed by gzip or zip, its rate columns named as in the log that was fitted;
    /// PX4 ULog or ArduPilot DataFlash
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

    /// Correct these sensors of an autopilot's log alone: gyro, accel, gyro0 or another number, or a part's device id
    #[arg(long, value_name = "SENSOR")]
    sensor: Option<SensorChoice>,

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
  zerorate apply flight.calibration.json flight.ulg --sensor gyro --out corrected.csv

To test a calibration on data it has not seen: empty the rate cells of some rows, fit, apply, and compare
predicted_COLUMN with what was in the cells.";

/// What was done, as JSON has it.
#[derive(Serialize)]
struct Done<'a> {
    schema: u32,
    out: &'a std::path::Path,
    columns: Vec<String>,
    rows: u64,
    rows_without_temperature: u64,
    rows_outside_calibrated_range: u64,
    rows_outside_measured_range: u64,
    rows_with_unknown_history: u64,
    /// The last line, where the file ends without a line feed; it was left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    cut_line: Option<u64>,
    calibrated_temperature: [f64; 2],
    measured_temperature: [f64; 2],
    temperature_unit: &'static str,
}

/// What was done, for people and for JSON.
struct Told {
    /// The axes corrected.
    columns: Vec<String>,
    applied: Applied,
    calibrated_temperature: [f64; 2],
    measured_temperature: [f64; 2],
    notes: Vec<String>,
}

/// What was found of the log's columns.
struct Found {
    table: Table,
    time: Option<String>,
    time_unit: Option<TimeUnit>,
    models: Vec<AppliedModel>,
    /// The units that were guessed.
    notes: Vec<String>,
}

impl Apply {
    pub fn run(&self) -> Result<Outcome> {
        output::check("--out", &self.out, &[&self.log, &self.calibration])?;
        let calibration = Calibration::read(&(&self.calibration).into())?;
        let log = Source::from(&self.log);
        let mut told = if autopilot_format(&log)?.is_some() {
            self.sensors(&log, &calibration)?
        } else {
            self.table(&calibration)?
        };
        told.notes.extend(calibration.no_gains());
        if self.json {
            told.notes.iter().for_each(|note| screen::note(note));
            screen::print_json(&Done {
                schema: 1,
                out: &self.out,
                columns: told.columns,
                rows: told.applied.rows,
                rows_without_temperature: told.applied.without_temperature,
                rows_outside_calibrated_range: told.applied.outside,
                rows_outside_measured_range: told.applied.unmeasured,
                rows_with_unknown_history: told.applied.uncertain,
                cut_line: told.applied.cut_line,
                calibrated_temperature: told.calibrated_temperature,
                measured_temperature: told.measured_temperature,
                temperature_unit: calibration.temperature_unit.name(),
            })?;
        } else {
            self.page(&told, calibration.temperature_unit.name()).print()?;
        }
        Ok(Outcome::Done)
    }

    /// An autopilot's log.
    fn sensors(&self, log: &Source, calibration: &Calibration) -> Result<Told> {
        ensure!(
            self.temperature.is_none() && self.time.is_none() && self.units == UnitArguments::default(),
            "{}: an autopilot's log says itself which is which: leave out --temperature, --time and their units",
            self.log.display()
        );
        let mut done = self.written(|out| apply_to_sensors(log, calibration, self.sensor, self.start(), out))?;
        for (sensors, why) in
            [(&done.passed_over, "not in the calibration"), (&done.not_asked_for, "not asked for by --sensor")]
        {
            if !sensors.is_empty() {
                done.notes.push(format!("{}: {why}, and not written", sensors.join(", ")));
            }
        }
        let AppliedSensors { corrected: columns, applied, calibrated_temperature, measured_temperature, notes, .. } =
            done;
        Ok(Told { columns, applied, calibrated_temperature, measured_temperature, notes })
    }

    /// A table.
    fn table(&self, calibration: &Calibration) -> Result<Told> {
        let Found { table, time, time_unit, models, notes } = self.columns(calibration)?;
        let to = AppliedTo { time: time.as_deref(), time_unit, start: self.start() };
        let applied = self.written(|out| apply(&table, &to, &models, out))?;
        let calibrated_temperature = in_common(models.iter().map(|own| own.model.drift.valid));
        let measured_temperature = in_common(models.iter().map(|own| own.measured));
        let columns = models.into_iter().map(|own| own.column).collect();
        Ok(Told { columns, applied, calibrated_temperature, measured_temperature, notes })
    }

    fn start(&self) -> Start {
        if self.with_time_drift { Start::OwnRecording } else { Start::Unknown }
    }

    /// Writes the output whole or not at all.
    fn written<T>(&self, write: impl FnOnce(&mut BufWriter<WholeFile>) -> Result<T, ApplyError>) -> Result<T> {
        self.force.corrected_log("--out", &self.out)?;
        let busy = Busy::reading(&self.log);
        let cannot = || format!("{}: cannot be written: an earlier file there is as it was", self.out.display());
        let mut out = BufWriter::new(WholeFile::create(&self.out).with_context(cannot)?);
        let done = write(&mut out).map_err(|error| match error {
            ApplyError::Write(error) => anyhow::Error::new(error).context(cannot()),
            other => other.into(),
        })?;
        let file = out.into_inner().map_err(IntoInnerError::into_error).with_context(cannot)?;
        if let Some(new) = file.written() {
            self.force.corrected_log_of_another("--out", &self.out, new)?;
        }
        file.finish().with_context(cannot)?;
        drop(busy);
        Ok(done)
    }

    fn page(&self, told: &Told, unit: &str) -> Page {
        let Told { columns, applied, calibrated_temperature: [min, max], measured_temperature, notes } = told;
        let mut page = Page::default();
        let (rows, columns) = (thousands(applied.rows), columns.join(", "));
        page.sentence("", &format!("Wrote {}: {rows} rows, {columns} corrected.", self.out.display()));
        if applied.unmeasured > 0 {
            let (rows, [coldest, hottest]) = (thousands(applied.unmeasured), measured_temperature);
            let text = format!(
                "{rows} rows are outside {coldest:.1} to {hottest:.1} {unit}, which was measured: there the curve rests on nothing"
            );
            page.sentence("  - ", &text);
        }
        if applied.outside > 0 {
            let rows = thousands(applied.outside);
            let text = format!(
                "{rows} rows are outside {min:.1} to {max:.1} {unit}, over which the curve is believed: there it was held at its end"
            );
            page.sentence("  - ", &text);
        }
        if applied.uncertain > 0 {
            let rows = thousands(applied.uncertain);
            let text = format!(
                "{rows} rows come before enough of the temperature's history was seen: there the prediction is uncertain by up to the hysteresis"
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
        notes.iter().for_each(|note| page.sentence("  - ", note));
        page
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
                    measured: axis.fit.measured,
                    factor: rate.factor * to_own,
                };
                models.push((rate.column, model));
            }
        }
        models.sort_by_key(|(place, _)| *place);
        let doubts = doubts(&table, &found)?;
        let guessed = doubts
            .into_iter()
            .filter(|reason| matches!(reason.kind, ReasonKind::AssumedUnit | ReasonKind::GuessedUnit));
        Ok(Found {
            notes: guessed.map(|reason| reason.text).collect(),
            time: found.time.map(|place| table.names()[place].clone()),
            time_unit: found.time_unit,
            models: models.into_iter().map(|(_, model)| model).collect(),
            table,
        })
    }
}
