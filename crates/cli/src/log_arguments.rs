//! The options that say what a log holds and how it is fitted.

use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use clap::Args;
use zerorate_cal::log::SensorChoice;
use zerorate_cal::log_fit::{FitOptions, GROUP_SECONDS};
use zerorate_cal::source::Source;
use zerorate_cal::table::Columns;
use zerorate_cal::units::{RateUnit, TimeUnit, WrittenRate, WrittenTemperature};
use zerorate_fit::drift_fit::ResidualOver;
use zerorate_fit::model::Model;

use crate::output::word;

/// Which column is which. What is left open is taken from the names where they make it plain.
#[derive(Debug, Default, PartialEq, Args)]
#[command(next_help_heading = "Columns (guessed from their names where these make it plain)")]
pub struct ColumnArguments {
    /// The time column
    #[arg(long, value_name = "COL")]
    time: Option<String>,

    /// The temperature column; of several gyros the one that they have in common
    #[arg(long, value_name = "COL")]
    temperature: Option<String>,

    /// The rate columns, separated by commas
    #[arg(long, value_name = "COL,COL,COL", value_delimiter = ',')]
    rate: Vec<String>,

    #[command(flatten)]
    units: UnitArguments,
}

/// In which unit a log's columns are written.
#[derive(Debug, Default, PartialEq, Args)]
#[command(next_help_heading = "Units (as the columns' names say where these are left out)")]
pub struct UnitArguments {
    /// The time's unit: h, min, s, ms, us or ns
    #[arg(long, value_name = "UNIT")]
    pub time_unit: Option<TimeUnit>,

    /// The temperature's unit: celsius (C), fahrenheit (F), kelvin (K) or counts; degrees are read as degrees C
    #[arg(long, value_name = "UNIT")]
    pub temperature_unit: Option<WrittenTemperature>,

    /// The rates' unit: dps (deg/s), mdps, deg/h, rad/s, mrad/s or counts; mdps and deg/h are read as dps, mrad/s as rad/s
    #[arg(long, value_name = "UNIT")]
    pub rate_unit: Option<WrittenRate>,
}

/// The unit in which people are told rates.
#[derive(Debug, Clone, Copy, Args)]
pub struct ShownUnits {
    /// Tell rates in this unit, on the screen, in tables and in figures: dps (deg/s), mdps, deg/h, rad/s, mrad/s or counts;
    /// without it in dps of a log in degrees (dps, mdps, deg/h), in rad/s of one in radians, or in thousandths of these. What a
    /// calibration was fitted with is kept in it, for info, export and report. JSON stays in dps or rad/s, which it names
    #[arg(long, value_name = "UNIT", help_heading = "Output")]
    units: Option<WrittenRate>,
}

impl ShownUnits {
    /// The unit asked for.
    pub fn asked(self) -> Option<WrittenRate> {
        self.units
    }

    /// The unit asked for, if rates in one of these units can be told in it. Accelerations stay in their own.
    pub fn of(self, found: impl Iterator<Item = RateUnit>) -> Result<Option<WrittenRate>> {
        let Some(asked) = self.units else { return Ok(None) };
        let found: Vec<RateUnit> = found.collect();
        let fits = found.is_empty() || found.iter().any(|unit| asked.in_unit(*unit).is_some());
        ensure!(
            fits,
            "--units {asked}: the rates are in {}, and are told in those alone, not in {asked}: leave --units out",
            found[0]
        );
        Ok(Some(asked))
    }
}

impl ColumnArguments {
    /// As the fit takes them.
    pub fn columns(&self) -> Columns {
        Columns {
            time: self.time.clone(),
            temperature: self.temperature.clone(),
            rates: self.rate.clone(),
            time_unit: self.units.time_unit,
            temperature_unit: self.units.temperature_unit,
            rate_unit: self.units.rate_unit,
            else_rate_unit: None,
            likely_rate_unit: None,
        }
    }

    /// As it is typed again, each option after a space: nothing where all was left to the names.
    pub fn typed(&self) -> String {
        let units = &self.units;
        let rate = Some(self.rate.join(",")).filter(|rate| !rate.is_empty());
        let given = [
            ("--time", self.time.clone()),
            ("--temperature", self.temperature.clone()),
            ("--rate", rate),
            ("--time-unit", units.time_unit.map(|unit| unit.to_string())),
            ("--temperature-unit", units.temperature_unit.map(|unit| unit.option().to_owned())),
            ("--rate-unit", units.rate_unit.map(|unit| unit.to_string())),
        ];
        let typed = |(option, value): (&str, Option<String>)| value.map(|value| format!(" {option} {}", word(&value)));
        given.into_iter().filter_map(typed).collect()
    }
}

/// A log and how it is fitted.
#[derive(Debug, Args)]
pub struct LogArguments {
    /// The log: PX4 ULog, ArduPilot DataFlash, text in columns (CSV, TSV, semicolons), Parquet or a recording of the bench,
    /// each also in gzip or alone in a zip, recognised by what is in it. Several logs of one unit, as of a cold and a
    /// warm day, make one fit
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,

    /// The drift model: poly:1 to poly:5, table:1 to table:32 (straight pieces), or auto: curve,
    /// history (hysteresis, lag) and drift in time, each as strong as the data say; poly:3 where that, or the
    /// cubic that autopilots get of it, predicts better by more than 5 %. With --plain auto is the simplest polynomial whose
    /// held-out rms is within one standard error of the best one's
    #[arg(long, value_name = "MODEL", default_value = "auto")]
    model: Model,

    /// Ordinary least squares on every row with numbers, each counted once: no averaging, nothing left out. To compare
    /// with other tools
    #[arg(long)]
    plain: bool,

    /// Accept a temperature span under 10 C; the calibration then holds for that span alone
    #[arg(long)]
    allow_narrow: bool,

    /// Fit these sensors alone: gyro, accel, gyro0 or another number, or a part's device id. Without this all are fitted
    #[arg(long, value_name = "SENSOR")]
    sensor: Option<SensorChoice>,

    /// Seconds over which rows are averaged before the fit; without this about 10, more where a row comes
    /// seldom, and less where the log is short
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    group_seconds: Option<f64>,

    #[command(flatten)]
    columns: ColumnArguments,
}

/// A time that a group can take.
fn seconds(text: &str) -> std::result::Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "give a number of seconds".to_owned())?;
    if GROUP_SECONDS.contains(&seconds) {
        Ok(seconds)
    } else {
        Err(format!("give {} to {} seconds", GROUP_SECONDS.start(), GROUP_SECONDS.end()))
    }
}

impl LogArguments {
    /// As the fit takes them.
    pub fn options(&self) -> FitOptions {
        FitOptions {
            columns: self.columns.columns(),
            model: self.model,
            plain: self.plain,
            allow_narrow: self.allow_narrow,
            group_s: self.group_seconds,
            sensor: self.sensor,
            ..FitOptions::default()
        }
    }

    /// The columns and their units, as they are typed again.
    pub fn typed_columns(&self) -> String {
        self.columns.typed()
    }

    /// The logs, as paths.
    pub fn paths(&self) -> Vec<&Path> {
        self.files.iter().map(PathBuf::as_path).collect()
    }

    /// The logs, to be read.
    pub fn sources(&self) -> Vec<Source> {
        self.files.iter().map(Source::from).collect()
    }

    /// Whether the plain fit was asked for.
    pub fn is_plain(&self) -> bool {
        self.plain
    }

    /// What the fit's residuals are of.
    pub fn over(&self) -> ResidualOver {
        if self.plain { ResidualOver::Rows } else { ResidualOver::Groups }
    }
}
