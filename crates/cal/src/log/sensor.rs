//! Which sensors of a log are wanted.

use std::str::FromStr;

use imu_logs::{Sensor, SensorKind};
use thiserror::Error;

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
