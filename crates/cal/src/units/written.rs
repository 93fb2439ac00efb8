//! The units in which people write columns: read, a column is in the unit that everything here counts in.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::{RateUnit, TemperatureUnit, UnitError};

/// 0 degrees C in kelvin.
const ZERO_C_IN_KELVIN: f64 = 273.15;
/// Freezing water in degrees Fahrenheit, and Fahrenheit's degrees in one of Celsius.
const ZERO_C_IN_FAHRENHEIT: f64 = 32.0;
const FAHRENHEIT_A_DEGREE: f64 = 1.8;

/// The unit in which a column of temperatures is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WrittenTemperature {
    /// Degrees Celsius.
    Celsius,
    /// Degrees Fahrenheit.
    Fahrenheit,
    /// Kelvin.
    Kelvin,
    /// Counts of an A/D.
    Counts,
}

impl WrittenTemperature {
    /// The unit once it is read.
    #[must_use]
    pub fn unit(self) -> TemperatureUnit {
        match self {
            Self::Celsius | Self::Fahrenheit | Self::Kelvin => TemperatureUnit::C,
            Self::Counts => TemperatureUnit::Counts,
        }
    }

    /// A temperature of the column in [`WrittenTemperature::unit`].
    #[must_use]
    pub fn read(self, written: f64) -> f64 {
        match self {
            Self::Celsius | Self::Counts => written,
            Self::Fahrenheit => (written - ZERO_C_IN_FAHRENHEIT) / FAHRENHEIT_A_DEGREE,
            Self::Kelvin => written - ZERO_C_IN_KELVIN,
        }
    }
}

impl WrittenTemperature {
    /// The unit as it is given for a parameter.
    #[must_use]
    pub fn option(self) -> &'static str {
        match self {
            Self::Celsius => "celsius",
            Self::Fahrenheit => "fahrenheit",
            Self::Kelvin => "kelvin",
            Self::Counts => "counts",
        }
    }
}

impl FromStr for WrittenTemperature {
    type Err = UnitError;
    fn from_str(text: &str) -> Result<Self, UnitError> {
        match text.to_lowercase().as_str() {
            "celsius" | "c" | "°c" | "degc" => Ok(Self::Celsius),
            "fahrenheit" | "f" | "°f" | "degf" => Ok(Self::Fahrenheit),
            "kelvin" | "k" => Ok(Self::Kelvin),
            "counts" => Ok(Self::Counts),
            _ => Err(UnitError { text: text.to_owned(), known: "celsius, fahrenheit, kelvin or counts" }),
        }
    }
}

impl fmt::Display for WrittenTemperature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Celsius => "degrees C",
            Self::Fahrenheit => "degrees Fahrenheit",
            Self::Kelvin => "kelvin",
            Self::Counts => "counts",
        })
    }
}

/// The unit in which a column of rates is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum WrittenRate {
    /// Degrees per second.
    #[serde(rename = "dps")]
    Dps,
    /// Thousandths of a degree per second.
    #[serde(rename = "mdps")]
    MilliDps,
    /// Degrees per hour.
    #[serde(rename = "deg/h")]
    DegPerHour,
    /// Radians per second.
    #[serde(rename = "rad/s")]
    RadPerS,
    /// Thousandths of a radian per second.
    #[serde(rename = "mrad/s")]
    MilliRadPerS,
    /// Counts of an A/D.
    #[serde(rename = "counts")]
    Counts,
}

impl WrittenRate {
    /// The unit once it is read.
    #[must_use]
    pub fn unit(self) -> RateUnit {
        match self {
            Self::Dps | Self::MilliDps | Self::DegPerHour => RateUnit::Dps,
            Self::RadPerS | Self::MilliRadPerS => RateUnit::RadPerS,
            Self::Counts => RateUnit::Counts,
        }
    }

    /// One of this in a unit of rates; `None` between a rate and counts.
    #[must_use]
    pub fn in_unit(self, unit: RateUnit) -> Option<f64> {
        let own = match self {
            Self::Dps | Self::RadPerS | Self::Counts => 1.0,
            Self::MilliDps | Self::MilliRadPerS => 1e-3,
            Self::DegPerHour => 1.0 / 3600.0,
        };
        self.unit().in_unit(unit).map(|factor| own * factor)
    }

    /// The unit itself, as a column is written in it; `None` for that of accelerometers.
    #[must_use]
    pub fn of(unit: RateUnit) -> Option<Self> {
        match unit {
            RateUnit::Dps => Some(Self::Dps),
            RateUnit::RadPerS => Some(Self::RadPerS),
            RateUnit::Counts => Some(Self::Counts),
            RateUnit::MetresPerS2 => None,
        }
    }
}

impl WrittenRate {
    /// The unit as it is written after a number.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Dps => "dps",
            Self::MilliDps => "mdps",
            Self::DegPerHour => "deg/h",
            Self::RadPerS => "rad/s",
            Self::MilliRadPerS => "mrad/s",
            Self::Counts => "counts",
        }
    }
}

impl FromStr for WrittenRate {
    type Err = UnitError;
    fn from_str(text: &str) -> Result<Self, UnitError> {
        match text.to_lowercase().as_str() {
            "dps" | "deg/s" | "°/s" => Ok(Self::Dps),
            "mdps" | "mdeg/s" => Ok(Self::MilliDps),
            "deg/h" | "°/h" | "dph" => Ok(Self::DegPerHour),
            "rad/s" => Ok(Self::RadPerS),
            "mrad/s" => Ok(Self::MilliRadPerS),
            "counts" => Ok(Self::Counts),
            _ => Err(UnitError { text: text.to_owned(), known: "dps, mdps, deg/h, rad/s, mrad/s or counts" }),
        }
    }
}

impl fmt::Display for WrittenRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-12 * b.abs().max(1.0)
    }

    #[test]
    fn freezing_and_boiling_water_and_absolute_zero_are_where_they_are() {
        assert!(close(WrittenTemperature::Fahrenheit.read(212.0), 100.0));
        assert!(close(WrittenTemperature::Fahrenheit.read(-40.0), -40.0));
        assert!(close(WrittenTemperature::Kelvin.read(0.0), -273.15));
        assert!(close(WrittenTemperature::Counts.read(9000.0), 9000.0));
    }

    #[test]
    fn the_earths_rate_is_one_in_all_units() {
        // 15.041 deg/h (IERS: 7.292115e-5 rad/s).
        for (unit, written) in [
            (WrittenRate::DegPerHour, 15.041_067),
            (WrittenRate::MilliDps, 4.178_074),
            (WrittenRate::MilliRadPerS, 0.072_921_15),
        ] {
            let rad_s = written * unit.in_unit(RateUnit::RadPerS).unwrap();
            assert!((rad_s / 7.292_115e-5 - 1.0).abs() < 1e-6, "{unit}: {rad_s}");
            assert_eq!(unit.to_string().parse(), Ok(unit));
        }
        assert_eq!(WrittenRate::Counts.in_unit(RateUnit::Dps), None);
        assert_eq!("°/s".parse(), Ok(WrittenRate::Dps));
        assert_eq!("F".parse(), Ok(WrittenTemperature::Fahrenheit));
        let none = "rpm".parse::<WrittenRate>().unwrap_err().to_string();
        assert_eq!(none, "'rpm' is no unit here: give dps, mdps, deg/h, rad/s, mrad/s or counts");
    }
}
