//! The calibration file, `calibration.json`: what was fitted, from which recordings, and how well.
//!
//! It serves the analogue board, whose axes `x` and `y` have a trim model and become a device record, and a log of a
//! digital gyro, whose axes have the names of the log's rate columns. Numbers are written so that they read back to the
//! same bits: a calibration that was written and read makes the same device record, bit for bit.
//!
//! The schema's version ([`SCHEMA`]) changes when a field's meaning does or a field that is needed is added. Fields that
//! a reader does not know it passes over, so that adding one needs no new version.

mod axis;
mod board;
mod celsius;
mod device;
mod drift_form;
mod error;
mod origin;
mod trim;

use std::collections::BTreeMap;
use std::io::Read;

use serde::{Deserialize, Serialize};
use zerorate_core::units::TemperatureScale;

pub use axis::AxisCalibration;
pub use board::BoardScale;
pub use celsius::CelsiusScale;
pub use device::{MadeRecord, NoDeviceRecord};
pub use error::{CalibrationError, CalibrationFault};
pub use origin::{Origin, sha256};
pub use trim::TrimCalibration;

use crate::source::Source;
use crate::units::{RateScale, RateUnit, TemperatureUnit, WrittenRate};

/// The version of the file that this code writes. It reads 1 as well, which has no history, drift in time, static cubic
/// or band, and 2, whose histories have no parts that are behind.
pub const SCHEMA: u32 = 3;

/// The oldest version that this code reads.
pub const OLDEST_SCHEMA: u32 = 1;

/// This program and its version, as calibrations name their maker.
pub const CREATED_BY: &str = concat!("zerorate ", env!("CARGO_PKG_VERSION"));

/// More bytes than a calibration has: a thousand times the paper's. A larger file is something else, and is not read.
const MOST_BYTES: u64 = 16 << 20;

/// What was calibrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A board with two analogue gyros and a trim part; everything in counts.
    AnalogueBoard,
    /// A log of a digital gyro.
    Log,
}

/// A calibration as it is kept in a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// What was calibrated.
    pub kind: Kind,
    /// The unit's serial; `None` where nobody gave one. A board's is needed for its device record.
    pub unit_serial: Option<String>,
    /// The program that made it, with its version: [`CREATED_BY`].
    pub created_by: String,
    /// The recordings that it rests on.
    pub sources: Vec<Origin>,
    /// The unit of every temperature in it.
    pub temperature_unit: TemperatureUnit,
    /// What a temperature code stands for on the board, in the temperature's unit; `None` for a log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_scale: Option<TemperatureScale>,
    /// The board's converter and temperature sensors; `None` for a log, and for the paper's board.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub board: Option<BoardScale>,
    /// The time from group to group on the board, seconds, by which a history runs there; `None` for a log.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group_period_s: Option<f64>,
    /// The time from one average that was fitted to the next, seconds, as a rule, of several logs the longest: what its figures are
    /// of. `None` of a board, of a log without times, and of older files.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub averaged_over_s: Option<f64>,
    /// The axes by name: `x` and `y` of a board, the rate columns of a table, `gyro0.x` of a
    /// log that tells of sensors.
    pub axes: BTreeMap<String, AxisCalibration>,
    /// What to look at, a sentence each.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// What whoever made it knows of it, by name, as `operator` and `station`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub labels: BTreeMap<String, String>,
    /// The unit of rates in which its sentences are told, and are to be told on, where one was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub told_in: Option<WrittenRate>,
    /// The simulated bench that it was made on, as "plant typical, seed 7"; `None` of what was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulated: Option<String>,
    /// The set-up that it was made with, as it was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub setup: Option<serde_json::Value>,
}

/// A calibration as it is written: the schema's version first.
#[derive(Serialize)]
struct Versioned<'a> {
    schema: u32,
    #[serde(flatten)]
    calibration: &'a Calibration,
}

/// What is read before anything else.
#[derive(Deserialize)]
struct Head {
    schema: Option<serde_json::Value>,
    /// What a summary does not have.
    kind: Option<serde_json::Value>,
}

impl Calibration {
    /// A calibration made by this program, of axes by their names.
    #[must_use]
    pub fn new(
        kind: Kind,
        unit_serial: Option<String>,
        sources: Vec<Origin>,
        temperature_unit: TemperatureUnit,
        axes: BTreeMap<String, AxisCalibration>,
    ) -> Self {
        Self {
            kind,
            unit_serial,
            created_by: CREATED_BY.to_owned(),
            sources,
            temperature_unit,
            temperature_scale: None,
            board: None,
            group_period_s: None,
            averaged_over_s: None,
            axes,
            warnings: Vec::new(),
            labels: BTreeMap::new(),
            told_in: None,
            simulated: None,
            setup: None,
        }
    }

    /// Reads a calibration.
    ///
    /// # Errors
    /// [`CalibrationFault`]: when the source cannot be read, is no calibration, has a schema that this code does not know,
    /// or is malformed, with line and column.
    pub fn read(source: &Source) -> Result<Self, CalibrationError> {
        let read = || {
            let mut bytes = Vec::new();
            source.open()?.take(MOST_BYTES + 1).read_to_end(&mut bytes)?;
            let text = String::from_utf8(bytes).ok().filter(|text| text.len() as u64 <= MOST_BYTES);
            let text = text.filter(|text| text.trim_start().starts_with('{'));
            Self::from_json(&text.ok_or(CalibrationFault::NotOne)?)
        };
        read().map_err(|fault| source.faulty(fault))
    }

    /// Reads a calibration from its text.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn from_json(text: &str) -> Result<Self, CalibrationFault> {
        let head: Head = serde_json::from_str(text)?;
        let known = u64::from(OLDEST_SCHEMA)..=u64::from(SCHEMA);
        match head.schema.as_ref().map(serde_json::Value::as_u64) {
            Some(Some(found)) if known.contains(&found) => match head.kind {
                Some(_) => Ok(serde_json::from_str(text)?),
                None => Err(CalibrationFault::NotOne),
            },
            Some(Some(found)) => Err(CalibrationFault::UnknownSchema { found }),
            Some(None) | None => Err(CalibrationFault::NotOne),
        }
    }

    /// The unit for what is told of its axes in this unit: that of their drifts, as of a fit's.
    #[must_use]
    pub fn scale(&self, unit: RateUnit) -> RateScale {
        scale(self.axes.values(), unit, self.told_in)
    }

    /// What is to be known of the axes that it does not help, a sentence each.
    pub fn no_gains(&self) -> impl Iterator<Item = String> {
        self.axes.iter().filter_map(|(name, axis)| axis.no_gain(name, self.told_in))
    }

    /// The same of what autopilots are given: of the cubics.
    pub fn no_gains_of_cubics(&self) -> impl Iterator<Item = String> {
        self.axes.iter().filter_map(|(name, axis)| axis.no_gain_of_cubic(name, self.told_in))
    }

    /// The file's text.
    ///
    /// # Errors
    /// [`CalibrationFault::Unwritable`], when the text would not read back: a number in it is not finite.
    pub fn to_json(&self) -> Result<String, CalibrationFault> {
        let unwritable = |error: &dyn std::fmt::Display| CalibrationFault::Unwritable { what: error.to_string() };
        let versioned = Versioned { schema: SCHEMA, calibration: self };
        let mut text = serde_json::to_string_pretty(&versioned).map_err(|error| unwritable(&error))?;
        text.push('\n');
        // JSON has no NaN: it is written as null, which only a reader notices.
        Self::from_json(&text).map_err(|_| unwritable(&"a number in it is not finite"))?;
        Ok(text)
    }
}

/// The unit for what is told of those axes that are in this unit: that of their drifts.
pub(crate) fn scale<'a>(
    axes: impl Iterator<Item = &'a AxisCalibration>,
    unit: RateUnit,
    asked: Option<WrittenRate>,
) -> RateScale {
    let axes = axes.filter(|axis| axis.rate_unit == unit);
    let drifts: Vec<f64> = axes.map(|axis| axis.measured_drift().peak_to_peak()).collect();
    RateScale::of(unit, &drifts, asked)
}

#[cfg(test)]
mod tests;
