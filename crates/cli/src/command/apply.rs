//! `zerorate apply`.

mod table;

use std::io::{BufWriter, IntoInnerError};
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::Args;
use serde::Serialize;
use zerorate_apply::apply::{Applied, AppliedSensors, AppliedTo, ApplyError, apply, apply_to_sensors, in_common};
use zerorate_cal::calibration::{AxisCalibration, Calibration, Kind, sha256};
use zerorate_cal::log::{SensorChoice, autopilot_format};
use zerorate_cal::source::Source;
use zerorate_cal::source::whole_file::WholeFile;
use zerorate_cal::units::from_to;
use zerorate_fit::predict::Start;

use self::table::Found;
use super::Outcome;
use crate::log_arguments::ColumnArguments;
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
/// temperature_c, x, y, z, and predicted_ and corrected_ of each.
///
/// Axes are matched as verify matches them: by the part's number, by the name, else by what is measured along which
/// direction, so that gyro0.x of an autopilot's log is x_rad_s of a table of the same unit; what was taken for what is told.
///
/// It predicts as a device would that started with the log's first row: the history of a model that has
/// one (hysteresis, lag) begins there, and what is predicted is uncertain until enough of it was seen.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Apply {
    /// The calibration that `zerorate fit --out` wrote
    calibration: PathBuf,

    /// The log: text in columns or Parquet, also packed by gzip or zip, PX4 ULog or ArduPilot
    /// DataFlash
    #[arg(value_name = "FILE")]
    log: PathBuf,

    /// Write the corrected log here, as CSV
    #[arg(long, value_name = "FILE")]
    out: PathBuf,

    /// Correct these sensors alone, of the calibration and of the log: gyro, accel, gyro0 or another number, or a part's
    /// device id
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
    columns: ColumnArguments,
}

const EXAMPLES: &str = "\
Examples:
  zerorate apply calibration.json flight.csv --out corrected.csv
  zerorate apply calibration.json imu.parquet --temperature die_temp --out corrected.csv
  zerorate apply flight.calibration.json flight.ulg --sensor gyro --out corrected.csv
  zerorate apply flight.calibration.json chamber.csv --sensor gyro0 --out corrected.csv
      a table, by the calibration of an autopilot's log that has several gyros

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
        told.notes.extend(self.drift_of_another(&log, &calibration)?);
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

    /// That what is added of the recording's own is of another recording, as far as its bytes tell.
    fn drift_of_another(&self, log: &Source, calibration: &Calibration) -> Result<Option<String>> {
        let adds = |axis: &AxisCalibration| axis.fit.model.time_drift.is_some() || axis.fit.model.history.is_some();
        if !self.with_time_drift || !calibration.axes.values().any(adds) {
            return Ok(None);
        }
        let own = sha256(log).with_context(|| self.log.display().to_string())?;
        let is_own = calibration.sources.iter().any(|source| source.sha256 == own);
        let told = || {
            format!(
                "--with-time-drift: {} is, by its bytes, no log that the calibration was fitted on: the drift in time that was \
                 added, and the history that was believed from the first row on, are that log's, and wrong here unless this is a \
                 copy of it",
                self.log.display()
            )
        };
        Ok((!is_own).then(told))
    }

    /// An autopilot's log.
    fn sensors(&self, log: &Source, calibration: &Calibration) -> Result<Told> {
        ensure!(
            self.columns == ColumnArguments::default(),
            "{}: an autopilot's log says itself which is which: leave out --temperature, --time, --rate and their units",
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
        let Found { table, time, models, notes } =
            table::found(&(&self.log).into(), calibration, self.columns.columns(), self.sensor).with_context(|| {
                format!("{} is for the rate columns of {}", self.calibration.display(), whose(calibration))
            })?;
        let time = time.as_ref().map(|(name, clock)| (name.as_str(), clock));
        let to = AppliedTo { time, start: self.start() };
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
        let rows = |count: u64| format!("{} {}", thousands(count), if count == 1 { "row" } else { "rows" });
        let rows_are = |count: u64| format!("{} {}", rows(count), if count == 1 { "is" } else { "are" });
        let (written, columns) = (rows(applied.rows), columns.join(", "));
        page.sentence("", &format!("Wrote {}: {written}, {columns} corrected.", self.out.display()));
        let believed = from_to(*min, *max);
        let goes_on = applied.unmeasured - applied.outside;
        if goes_on > 0 {
            let (rows, [coldest, hottest]) = (rows_are(goes_on), measured_temperature);
            let measured = from_to(*coldest, *hottest);
            let text = format!(
                "{rows} outside {measured} {unit}, the coldest and the warmest average that was fitted, and within {believed} {unit}: there the curve goes on as it ends"
            );
            page.sentence("  - ", &text);
        }
        if applied.outside > 0 {
            let rows = rows_are(applied.outside);
            let text = format!(
                "{rows} outside {believed} {unit}, over which the curve is believed: there it was held at its end"
            );
            page.sentence("  - ", &text);
        }
        if applied.uncertain > 0 {
            let rows = rows_are(applied.uncertain);
            let text = format!(
                "{rows} from before enough of the temperature's history was seen: there the prediction is uncertain by up to what the history adds"
            );
            page.sentence("  - ", &text);
        }
        if applied.without_temperature > 0 {
            let rows = rows_are(applied.without_temperature);
            page.sentence("  - ", &format!("{rows} without a temperature: kept, without a correction"));
        }
        if let Some(line) = applied.cut_line {
            let text = format!("the file ends without a line feed: line {line} may be cut, and was left out");
            page.sentence("  - ", &text);
        }
        notes.iter().for_each(|note| page.sentence("  - ", note));
        page
    }
}

/// Whose columns a calibration is for.
fn whose(calibration: &Calibration) -> &'static str {
    match calibration.kind {
        Kind::Log => "the log that was fitted",
        Kind::AnalogueBoard => "an analogue board (x and y, in counts)",
    }
}
