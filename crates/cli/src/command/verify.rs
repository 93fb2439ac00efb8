//! `zerorate verify`.

mod join;
mod page;

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use clap::Args;
use serde::Serialize;
use zerorate_apply::verify::{Limit, Limits, Verified, VerifyOptions, known_columns, verify};
use zerorate_cal::calibration::{Calibration, Kind};
use zerorate_cal::log::SensorChoice;
use zerorate_cal::source::{Source, in_quotes, line_at};

use self::join::join;
use super::Outcome;
use crate::log_arguments::{ColumnArguments, ShownUnits};
use crate::progress::Busy;
use crate::screen;

/// See what a calibration leaves of a log that it has not seen
///
/// Applies a calibration to the log of a second run and tells, for each axis, what was recorded and what is left, over
/// averages of 10 s. With limits it passes or fails: exit code 1 says that the unit failed. An axis of which more is left
/// than was recorded, by more than a twentieth, is told as worse. Told as well is one of which more than twice as much is
/// left as the fit told, and a log of which more than 2 % is outside the temperatures that were measured for the calibration.
/// None of these is a limit. The log that the calibration was fitted on is refused, for it is no test.
///
/// The log may be of another kind than the one that was fitted, as a CSV of an autopilot's gyro: axes of other names are
/// matched by what they measure and along which direction, where that is plain. rad/s and deg/s are converted.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Verify {
    /// The log of the second run, of any kind that fit reads
    #[arg(value_name = "LOG")]
    log: PathBuf,

    /// The calibration
    #[arg(long = "with", value_name = "CALIBRATION")]
    calibration: PathBuf,

    /// What may be left at most, root mean square about the mean: 0.5mrad/s, 0.02dps, 30deg/h, 12counts
    #[arg(long, value_name = "LIMIT", help_heading = "Limits")]
    max_rms: Option<Limit>,

    /// What may be left at most, peak to peak
    #[arg(long, value_name = "LIMIT", help_heading = "Limits")]
    max_pp: Option<Limit>,

    /// What the mean may be at most, without its sign
    #[arg(long, value_name = "LIMIT", help_heading = "Limits")]
    max_offset: Option<Limit>,

    /// Limits from a TOML file: max_rms = "0.5 mrad/s", max_pp, max_offset, and [axes.NAME] with the same for one axis
    #[arg(long, value_name = "FILE", help_heading = "Limits", conflicts_with_all = ["max_rms", "max_pp", "max_offset"])]
    limits: Option<PathBuf>,

    /// Take the log that the calibration was fitted on too: what is left is then in-sample, and proves nothing
    #[arg(long)]
    in_sample: bool,

    #[command(flatten)]
    units: ShownUnits,

    /// Print JSON on standard output, and nothing else there
    #[arg(long)]
    json: bool,

    /// Verify these sensors alone, of the calibration and of the log: gyro, accel, gyro0 or another number, or a part's
    /// device id
    #[arg(long, value_name = "SENSOR")]
    sensor: Option<SensorChoice>,

    #[command(flatten)]
    columns: ColumnArguments,
}

const EXAMPLES: &str = "\
Examples:
  zerorate verify second.csv --with calibration.json
  zerorate verify second.ulg --with calibration.json --max-rms 1mrad/s --max-pp 5mrad/s
  zerorate verify second.bin --with calibration.json --limits limits.toml --json
  zerorate verify chamber.csv --with flight.calibration.json --sensor gyro0
      a table, by the calibration of an autopilot's log that has several gyros

Exit codes: 0 within the limits, or none were given (then \"worse\" is a warning); 1 a limit is missed, or an axis is not
there or has lost most of its rates; 2 error.";

/// What was found, as JSON has it.
#[derive(Serialize)]
struct Found<'a> {
    schema: u32,
    #[serde(flatten)]
    verified: &'a Verified,
}

impl Verify {
    pub fn run(&self) -> Result<Outcome> {
        let calibration = Calibration::read(&(&self.calibration).into())?;
        if calibration.kind == Kind::AnalogueBoard {
            bail!(
                "{}: the calibration of an analogue board: its second run is part of zerorate calibrate",
                self.calibration.display()
            );
        }
        let limits = self.limits()?;
        limits.check(calibration.axes.keys().map(String::as_str))?;
        let log = Source::from(&self.log);
        let busy = Busy::reading(&self.log);
        let options = VerifyOptions {
            columns: known_columns(&log, &calibration, self.columns.columns()),
            sensor: self.sensor,
            limits,
            in_sample: self.in_sample,
            told_in: self.units.asked(),
        };
        let verified = verify(&log, &calibration, &options)?;
        drop(busy);
        let units = self.units.of(verified.axes.iter().map(|axis| axis.rate_unit))?;
        if self.json {
            verified.notes.iter().for_each(|note| screen::note(note));
            screen::print_json(&Found { schema: 1, verified: &verified })?;
        } else {
            let join = join((&self.calibration, &calibration), (&self.log, &verified), &self.columns);
            page::page(&verified, units, join.as_deref()).print()?;
        }
        Ok(if verified.passed == Some(false) { Outcome::Rejected } else { Outcome::Done })
    }

    fn limits(&self) -> Result<Limits> {
        let Some(path) = &self.limits else {
            return Ok(Limits::for_all(self.max_rms.clone(), self.max_pp.clone(), self.max_offset.clone()));
        };
        let text = fs::read_to_string(path).with_context(|| format!("{}: cannot be read", path.display()))?;
        toml::from_str(&text).map_err(|error| {
            let line = line_at(&text, error.span().map_or(0, |span| span.start));
            anyhow::anyhow!("{}:{line}: {}", path.display(), in_quotes(error.message()))
        })
    }
}
