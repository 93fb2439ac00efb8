#![doc = include_str!("../README.md")]

mod ardupilot;
mod c;
mod code;
mod cubic;
mod px4;
mod sensors;
mod table;

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

pub use cubic::{Cubic, Loss};
pub use sensors::{ExportedAxis, ExportedSensor};

use zerorate_cal::calibration::Calibration;
use zerorate_cal::quality::{NO_HYSTERESIS, TAKEN_AS};
use zerorate_cal::units::RateUnit;

/// A form in which a calibration can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// PX4's parameter file, as QGroundControl loads it.
    Px4,
    /// ArduPilot's parameter file, as Mission Planner and MAVProxy load it.
    ArduPilot,
    /// ArduPilot's parameters as the MethodicConfigurator keeps them.
    MethodicConfigurator,
    /// A header in C99.
    C,
    /// The static cubics in JSON.
    Json,
    /// The curves as a table over temperature.
    Csv,
}

impl Format {
    /// All of them, in the order in which help lists them.
    pub const ALL: [Self; 6] = [Self::Px4, Self::ArduPilot, Self::MethodicConfigurator, Self::C, Self::Json, Self::Csv];

    /// What a file of it is usually called.
    #[must_use]
    pub fn file_name(self) -> &'static str {
        match self {
            Self::Px4 => "calibration.params",
            Self::ArduPilot => "calibration.parm",
            Self::MethodicConfigurator => "03_imu_temperature_calibration_results.param",
            Self::C => "zerorate_calibration.h",
            Self::Json => "calibration.static.json",
            Self::Csv => "calibration.csv",
        }
    }
}

impl From<imu_logs::Format> for Format {
    /// The form in which the autopilot that wrote a log takes parameters.
    fn from(log: imu_logs::Format) -> Self {
        match log {
            imu_logs::Format::ULog => Self::Px4,
            imu_logs::Format::DataFlash => Self::ArduPilot,
        }
    }
}

/// A format that was asked for and is none.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "'{0}' is no format: give px4, ardupilot, methodic-configurator, c, json or csv; in Rust the crate zerorate-core evaluates the device record itself"
)]
pub struct FormatError(String);

impl FromStr for Format {
    type Err = FormatError;
    fn from_str(text: &str) -> Result<Self, FormatError> {
        Self::ALL.into_iter().find(|format| format.to_string() == text).ok_or_else(|| FormatError(text.to_owned()))
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Px4 => "px4",
            Self::ArduPilot => "ardupilot",
            Self::MethodicConfigurator => "methodic-configurator",
            Self::C => "c",
            Self::Json => "json",
            Self::Csv => "csv",
        })
    }
}

/// What a log did not say, and the user may.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ExportOptions {
    /// The sensor's device id, where the calibration has none.
    pub device_id: Option<u32>,
    /// The sensor's place, from 0, where the calibration has none.
    pub instance: Option<u8>,
}

/// A calibration in a format.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported {
    /// The file's text.
    pub text: String,
    /// The sensors in it.
    pub sensors: Vec<ExportedSensor>,
    /// What to know and to do, a sentence each; they stand in the file too where it has comments.
    pub notes: Vec<String>,
}

/// Why a calibration cannot be exported.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ExportError {
    /// Nothing to export.
    #[error("the calibration has no axis")]
    NoAxis,
    /// The rates are no angular rates.
    #[error(
        "axis {axis} is in {unit}, and {format} takes rad/s: how many of these are one rad/s is not known; fit the log with the unit of its rates (`rate_unit`), or give it to c or csv"
    )]
    NotARate {
        /// The axis's name.
        axis: String,
        /// Its unit.
        unit: RateUnit,
        /// The format.
        format: Format,
    },
    /// The temperatures are no temperatures.
    #[error("the calibration's temperatures are in counts, and {format} takes degrees C: give it to c or csv")]
    NotInDegrees {
        /// The format.
        format: Format,
    },
    /// PX4 finds a sensor by its id.
    #[error(
        "{sensor} has no device id, and PX4 finds a sensor's parameters by it (TC_G0_ID): give its number (`device_id`; in PX4's console, `listener sensor_gyro` shows it), or fit the ULog itself"
    )]
    NoDeviceId {
        /// The sensor.
        sensor: String,
    },
    /// One id was given, and it cannot be that of two parts.
    #[error(
        "{sensors} have no device ids of their own, and one was given (`device_id`): it is one part's; fit and export each sensor by itself (`sensor`)"
    )]
    OneIdForSeveral {
        /// The sensors without an id.
        sensors: String,
    },
    /// More sensors of a kind than the autopilot has places for.
    #[error("{sensor}: {format} has places for {places} sensors of a kind")]
    NoPlace {
        /// The sensor.
        sensor: String,
        /// The format.
        format: Format,
        /// Its places.
        places: u8,
    },
    /// Two axes claim one place.
    #[error(
        "'{first}' and '{second}' are both axis {axis} of {sensor}: name the columns so that x, y and z can be told"
    )]
    SameAxis {
        /// An axis's name.
        first: String,
        /// Another's.
        second: String,
        /// The letter.
        axis: char,
        /// The sensor.
        sensor: String,
    },
    /// An axis's letter cannot be told.
    #[error("'{axis}' does not say whether it is x, y or z: {format} must know; name the column so")]
    NoLetter {
        /// The axis's name.
        axis: String,
        /// The format.
        format: Format,
    },
    /// The curve's numbers do not fit the integers of the source code.
    #[error("axis {axis}: its curve cannot be written in 32-bit integers: {why}")]
    TooLarge {
        /// The axis's name.
        axis: String,
        /// What does not fit.
        why: String,
    },
}

/// Writes a calibration in a format.
///
/// # Errors
/// [`ExportError`], when the calibration lacks what the format needs.
pub fn export(calibration: &Calibration, format: Format, options: &ExportOptions) -> Result<Exported, ExportError> {
    if calibration.axes.is_empty() {
        return Err(ExportError::NoAxis);
    }
    match format {
        Format::Px4 => px4::write(calibration, options),
        Format::ArduPilot => ardupilot::write(calibration, options, ' '),
        Format::MethodicConfigurator => ardupilot::write(calibration, options, ','),
        Format::C => c::write(calibration),
        Format::Json => table::write_json(calibration, options),
        Format::Csv => Ok(table::write_csv(calibration)),
    }
}

/// Where the calibration came from, a line each, for the head of a file.
fn origin(calibration: &Calibration) -> Vec<String> {
    let mut lines = vec![format!("written by {}", zerorate_cal::calibration::CREATED_BY)];
    lines.extend(calibration.unit_serial.as_ref().map(|serial| format!("unit {}", one_line(serial))));
    let of = |source: &zerorate_cal::calibration::Origin| {
        format!("from {}, SHA-256 {}", one_line(&source.file), one_line(&source.sha256))
    };
    lines.extend(calibration.sources.iter().map(of));
    lines
}

/// What to know of a calibration in whatever format: the axes that what is exported does not help (`no_gains`), and what a model
/// may have and no format holds, and what was guessed of its log or is not in it.
fn to_know(calibration: &Calibration, no_gains: impl Iterator<Item = String>) -> Vec<String> {
    let drifts = calibration.axes.iter().filter(|(_, axis)| axis.fit.model.time_drift.is_some());
    let names: Vec<String> = drifts.map(|(name, _)| one_line(name)).collect();
    let left_out = (!names.is_empty()).then(|| {
        format!(
            "the drift in time ('+ time', '+ start-up') of {} is not exported: it is that log's own, and no other run repeats it",
            names.join(", ")
        )
    });
    // A unit that was guessed may be wrong by a factor, and a curve of one direction by the hysteresis: both go where it goes.
    let of_the_log =
        calibration.warnings.iter().filter(|text| [TAKEN_AS, NO_HYSTERESIS].iter().any(|said| text.contains(said)));
    let of_the_log = of_the_log.map(|text| format!("of the log that was fitted: {}", one_line(text)));
    no_gains.map(|text| one_line(&text)).chain(left_out).chain(of_the_log).collect()
}

/// The same of the cubics of its sensors. A log of one direction says nothing of a hysteresis: of a run that goes the other way too
/// the model leaves it as the cubic does.
fn to_know_of_cubics(calibration: &Calibration, sensors: &[ExportedSensor]) -> Vec<String> {
    let mut notes = to_know(calibration, calibration.no_gains_of_cubics());
    let cost = |axis: &ExportedAxis| axis.loss.cubic_rms > axis.loss.chosen_rms && axis.loss.chosen_rms.is_some();
    let is_one_way = calibration.warnings.iter().any(|text| text.contains(NO_HYSTERESIS));
    if is_one_way && sensors.iter().flat_map(|sensor| sensor.axes.iter().flatten()).any(cost) {
        notes.push(ONE_WAY.to_owned());
    }
    notes
}

/// How far what a cubic costs holds after a log of one direction, for people.
const ONE_WAY: &str = "how much more a cubic leaves than the model is told of runs that go the way of this log: of one that goes back as \
    well both leave what differs between the ways, and the cubic is nearer to the model than is told";

/// A text from outside as it may stand in a comment: nothing in it ends the comment or the line.
fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect::<String>().replace("*/", "* /")
}

#[cfg(test)]
mod tests;
