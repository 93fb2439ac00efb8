//! Which sensor of a unit.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// What a sensor measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SensorKind {
    /// Angular rate.
    Gyro,
    /// Specific force.
    Accelerometer,
}

impl SensorKind {
    /// The kind in a name: `gyro` or `accel`.
    #[must_use]
    pub fn short_name(self) -> &'static str {
        match self {
            Self::Gyro => "gyro",
            Self::Accelerometer => "accel",
        }
    }
}

/// One sensor of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Sensor {
    /// What it measures.
    pub kind: SensorKind,
    /// Its place among the unit's sensors of its kind, from 0.
    pub instance: u8,
    /// The number by which the unit's software knows the part, where the log has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub device_id: Option<u32>,
}

impl Sensor {
    /// Names for three axes: `gyro0.x`.
    #[must_use]
    pub fn axis_names(&self) -> Vec<String> {
        ["x", "y", "z"].map(|axis| format!("{self}.{axis}")).to_vec()
    }
}

impl fmt::Display for Sensor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.kind.short_name(), self.instance)
    }
}

/// Which sensors of a log are wanted: `gyro`, `accel`, `gyro0`, or a part's number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorChoice {
    /// All of a kind.
    Kind(SensorKind),
    /// One, by its kind and place.
    Instance(SensorKind, u8),
    /// One, by its part's number.
    Device(u32),
}

/// A choice of sensors that is none.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{0}' is no sensor: give gyro, accel, gyro0 (or another number), or the part's device id as a number")]
pub struct SensorChoiceError(String);

impl FromStr for SensorChoice {
    type Err = SensorChoiceError;
    fn from_str(text: &str) -> Result<Self, SensorChoiceError> {
        let unknown = || SensorChoiceError(text.to_owned());
        if let Ok(id) = text.parse() {
            return Ok(Self::Device(id));
        }
        let (kind, place) = [SensorKind::Gyro, SensorKind::Accelerometer]
            .into_iter()
            .find_map(|kind| text.strip_prefix(kind.short_name()).map(|place| (kind, place)))
            .ok_or_else(unknown)?;
        if place.is_empty() {
            return Ok(Self::Kind(kind));
        }
        place.parse().map(|place| Self::Instance(kind, place)).map_err(|_| unknown())
    }
}

impl SensorChoice {
    /// Whether a sensor is one of those wanted.
    #[must_use]
    pub fn takes(self, sensor: &Sensor) -> bool {
        match self {
            Self::Kind(kind) => sensor.kind == kind,
            Self::Instance(kind, instance) => (sensor.kind, sensor.instance) == (kind, instance),
            Self::Device(id) => sensor.device_id == Some(id),
        }
    }
}
