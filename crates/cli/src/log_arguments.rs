//! The options that say what a log holds and how it is fitted.

use std::path::{Path, PathBuf};

use clap::Args;
use zerorate_cal::log::SensorChoice;
use zerorate_cal::log_fit::FitOptions;
use zerorate_cal::source::Source;
use zerorate_cal::table::Columns;
use zerorate_cal::units::{RateUnit, TimeUnit};
use zerorate_fit::drift_fit::ResidualOver;
use zerorate_fit::model::Model;

/// A group may take this long: rows of a log are no closer, and a ramp has more than a few.
const MIN_GROUP_S: f64 = 0.01;
const MAX_GROUP_S: f64 = 600.0;

/// Which column is which. What is left open is taken from the names where they make it plain.
#[derive(Debug, Args)]
#[command(next_help_heading = "Columns (guessed from their names where these make it plain)")]
pub struct ColumnArguments {
    /// The time column
    #[arg(long, value_name = "COL")]
    time: Option<String>,

    /// The time's unit: s, ms, us or ns
    #[arg(long, value_name = "UNIT")]
    time_unit: Option<TimeUnit>,

    /// The temperature column
    #[arg(long, value_name = "COL")]
    temperature: Option<String>,

    /// The rate columns, separated by commas
    #[arg(long, value_name = "COL,COL,COL", value_delimiter = ',')]
    rate: Vec<String>,

    /// The rates' unit: dps (degrees per second), rad/s or counts
    #[arg(long, value_name = "UNIT")]
    rate_unit: Option<RateUnit>,
}

impl ColumnArguments {
    /// As the fit takes them.
    pub fn columns(&self) -> Columns {
        Columns {
            time: self.time.clone(),
            temperature: self.temperature.clone(),
            rates: self.rate.clone(),
            time_unit: self.time_unit,
            rate_unit: self.rate_unit,
        }
    }
}

/// A log and how it is fitted.
#[derive(Debug, Args)]
pub struct LogArguments {
    /// The log: PX4 ULog, ArduPilot DataFlash, CSV, TSV, Parquet or a recording of the bench, recognised by what is in it.
    /// Several logs of one unit, as of a cold and a warm day, make one fit
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<PathBuf>,

    /// The drift model: poly:1 to poly:5, table:1 to table:32 (straight pieces), or auto: the simplest of curve,
    /// history (hysteresis, lag) and slow drift in time that predicts unseen data as well as the best
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

    /// Seconds over which rows are averaged before the fit; without this about 10, and less where the log is short
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    group_seconds: Option<f64>,

    #[command(flatten)]
    columns: ColumnArguments,
}

/// A time that a group can take.
fn seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "give a number of seconds".to_owned())?;
    if (MIN_GROUP_S..=MAX_GROUP_S).contains(&seconds) {
        Ok(seconds)
    } else {
        Err(format!("give {MIN_GROUP_S} to {MAX_GROUP_S} seconds"))
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
        }
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
