//! What can be wrong with a log, and what to do about it.

use std::io;

use thiserror::Error;

use crate::packed::PackedFault;
use crate::recording::RecordingFault;
use crate::source::Faulty;
use crate::table::TableFault;
use crate::units::{RateUnit, WrittenTemperature};

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
        "column '{column}' goes from {min:.0} to {max:.0}, which no gyro sees in {written}: say its unit (`temperature_unit` {}), or name the column that has the gyro's own temperature (`temperature`)",
        .rather.option()
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
        /// The unit it may be in.
        rather: WrittenTemperature,
    },
    /// Rates whose unit was guessed, and that speak against the guess.
    #[error(
        "column '{column}' names no unit, and as {guessed} the gyro would never rest: say its unit (`rate_unit` dps, or rad/s if it did move all the time)"
    )]
    DoubtfulRate {
        /// The rate column's name.
        column: String,
        /// The guess.
        guessed: RateUnit,
    },
}

impl LogFault {
    /// What is wrong with a table or a recording is wrong with the log.
    pub(crate) fn named<F: Into<Self> + std::fmt::Display>(error: Faulty<F>) -> LogError {
        Faulty { name: error.name, fault: error.fault.into() }
    }
}
