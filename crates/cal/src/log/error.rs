//! What can be wrong with a log, and what to do about it.

use std::io;

use thiserror::Error;

use crate::recording::RecordingFault;
use crate::source::Faulty;
use crate::source::packed::PackedFault;
use crate::table::TableFault;
use crate::units::{RateUnit, TimeUnit, WrittenTemperature};

/// Why a log cannot be read, with its name.
pub type LogError = Faulty<LogFault>;

/// Why a log cannot be read.
#[derive(Debug, Error)]
pub enum LogFault {
    /// The file cannot be opened or read.
    #[error("cannot be read: {0}")]
    Read(#[from] io::Error),
    /// The file is packed and cannot be unpacked.
    #[error(transparent)]
    Packed(#[from] PackedFault),
    /// A table cannot be read.
    #[error(transparent)]
    Table(#[from] TableFault),
    /// A recording of the bench cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingFault),
    /// A row's time is before that of the row above it.
    #[error(
        "row {row}: column '{column}' runs backwards, from {before} to {after}: the log is damaged, or several were joined: split it there"
    )]
    TimeBackwards {
        /// The row, from 1, the header not counted.
        row: u64,
        /// The time column's name.
        column: String,
        /// The time above.
        before: f64,
        /// The time in the row.
        after: f64,
    },
    /// Temperatures that no gyro sees, in the unit that they are taken for.
    #[error(
        "column '{column}' goes from {min:.0} to {max:.0}, which no gyro sees in {written}: {}, or name the column that has the gyro's own temperature (`temperature`)",
        advice(*.rather)
    )]
    NotCelsius {
        /// The temperature column's name.
        column: String,
        /// The least, as it is written.
        min: f64,
        /// The greatest.
        max: f64,
        /// The unit it is taken for.
        written: WrittenTemperature,
        /// The unit it may be in, if it is in one.
        rather: Option<WrittenTemperature>,
    },
    /// Times in whose unit the rows come faster than from any gyro, or are over at once.
    #[error(
        "column '{column}' says {unit}, by which the log's {rows} rows last {lasts_s:.2e} s, and no gyro is logged so fast: say its unit (`time_unit`{})",
        rather.map(|unit| format!(" {unit}")).unwrap_or_default()
    )]
    DoubtfulTime {
        /// The time column's name.
        column: String,
        /// The unit that it says.
        unit: TimeUnit,
        /// How long the log would last.
        lasts_s: f64,
        /// Its rows.
        rows: u64,
        /// The unit it may be in, if one fits.
        rather: Option<TimeUnit>,
    },
    /// A recording and an autopilot's log say themselves what is what.
    #[error(
        "{form} has no columns to choose and says its units itself: leave out what names a column or a unit (`time`, `temperature`, `rate`, `time_unit`, `temperature_unit`, `rate_unit`)"
    )]
    NoColumns {
        /// What it is.
        form: &'static str,
    },
    /// Rates whose unit was guessed, and that speak against the guess.
    #[error(
        "column '{column}' names no unit, and as {guessed} the gyro would never rest: say its unit (`rate_unit` dps, mdps or rad/s; {guessed} if it did move all the time)"
    )]
    DoubtfulRate {
        /// The rate column's name.
        column: String,
        /// The guess.
        guessed: RateUnit,
    },
}

/// What to do with a column of temperatures that are in another unit. `temperature_unit` is of all logs of a fit.
fn advice(rather: Option<WrittenTemperature>) -> String {
    rather.map_or_else(
        || "it seems to be in two units: convert it to degrees C".to_owned(),
        |unit| {
            format!(
                "say its unit (`temperature_unit` {}), or convert it where another log is in another",
                unit.option()
            )
        },
    )
}

impl LogFault {
    /// What is wrong with a table or a recording is wrong with the log.
    pub(crate) fn named<F: Into<Self> + std::fmt::Display>(error: Faulty<F>) -> LogError {
        Faulty { name: error.name, fault: error.fault.into() }
    }
}
