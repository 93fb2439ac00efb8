//! Which sensor of a vehicle.

use std::fmt;

/// What a sensor measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize), serde(rename_all = "kebab-case"))]
pub enum SensorKind {
    /// Angular rate, rad/s.
    Gyro,
    /// Specific force, m/s^2.
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

/// One sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sensor {
    /// What it measures.
    pub kind: SensorKind,
    /// Its place among the sensors of its kind, from 0.
    pub instance: u8,
    /// The number by which the autopilot knows the part, where the log has it.
    #[cfg_attr(feature = "serde", serde(default, skip_serializing_if = "Option::is_none"))]
    pub device_id: Option<u32>,
}

impl Sensor {
    /// Names for the three axes: `gyro0.x`.
    #[must_use]
    pub fn axis_names(&self) -> [String; 3] {
        ["x", "y", "z"].map(|axis| format!("{self}.{axis}"))
    }
}

impl fmt::Display for Sensor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.kind.short_name(), self.instance)
    }
}
