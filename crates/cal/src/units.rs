//! The units of times, rates and temperatures. Nothing is converted but where data enter.

mod scale;
mod written;

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use scale::{RateScale, decimal, from_to};
pub use written::{WrittenRate, WrittenTemperature};

/// The least temperature span of a calibration, degrees C: below it a curve is mostly noise.
pub const MIN_SPAN_C: f64 = 10.0;

/// The least span where temperature is in counts: 10 C at the paper's 34 counts a degree (docs/paper.md, "What the paper
/// leaves open").
pub const MIN_SPAN_COUNTS: f64 = 340.0;

/// The unit of a time column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeUnit {
    /// Hours.
    H,
    /// Minutes.
    Min,
    /// Seconds.
    S,
    /// Milliseconds.
    Ms,
    /// Microseconds.
    Us,
    /// Nanoseconds.
    Ns,
}

impl TimeUnit {
    const ALL: [Self; 6] = [Self::H, Self::Min, Self::S, Self::Ms, Self::Us, Self::Ns];
    /// Those in which a clock counts: a column that does not say its unit is in one of them.
    const COUNTED: [Self; 4] = [Self::S, Self::Ms, Self::Us, Self::Ns];

    /// One unit in seconds.
    #[must_use]
    pub fn seconds(self) -> f64 {
        match self {
            Self::H => 3600.0,
            Self::Min => 60.0,
            Self::S => 1.0,
            Self::Ms => 1e-3,
            Self::Us => 1e-6,
            Self::Ns => 1e-9,
        }
    }

    /// The next larger unit in which a clock counts; `None` of seconds.
    #[must_use]
    pub fn larger(self) -> Option<Self> {
        let place = Self::COUNTED.iter().position(|unit| *unit == self)?;
        place.checked_sub(1).map(|larger| Self::COUNTED[larger])
    }

    /// The one unit by which a log lasts from 100 s to 100 000 s (28 h), as a thermal log does: the units lie a factor of
    /// 1000 apart, so at most one fits. `None` where none does.
    #[must_use]
    pub fn by_duration(duration: f64) -> Option<Self> {
        Self::COUNTED.into_iter().find(|unit| (100.0..100_000.0).contains(&(duration * unit.seconds())))
    }
}

/// The unit of rates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum RateUnit {
    /// Degrees per second.
    #[serde(rename = "dps")]
    Dps,
    /// Radians per second.
    #[serde(rename = "rad/s")]
    RadPerS,
    /// Counts of an A/D.
    #[serde(rename = "counts")]
    Counts,
    /// Metres per second squared: an accelerometer's.
    #[serde(rename = "m/s^2")]
    MetresPerS2,
}

/// A unit that was asked for and is none.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{text}' is no unit here: give {known}")]
pub struct UnitError {
    text: String,
    known: &'static str,
}

impl RateUnit {
    /// Whether it is an accelerometer's.
    #[must_use]
    pub fn is_of_acceleration(self) -> bool {
        match self {
            Self::MetresPerS2 => true,
            Self::Dps | Self::RadPerS | Self::Counts => false,
        }
    }

    /// What is measured in it, in a sentence.
    pub(crate) fn quantity(self) -> &'static str {
        if self.is_of_acceleration() { "acceleration" } else { "rate" }
    }
}

impl FromStr for TimeUnit {
    type Err = UnitError;
    fn from_str(text: &str) -> Result<Self, UnitError> {
        let known = Self::ALL.into_iter().find(|unit| unit.to_string() == text);
        known.ok_or_else(|| UnitError { text: text.to_owned(), known: "h, min, s, ms, us or ns" })
    }
}

impl fmt::Display for TimeUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::H => "h",
            Self::Min => "min",
            Self::S => "s",
            Self::Ms => "ms",
            Self::Us => "us",
            Self::Ns => "ns",
        })
    }
}

impl fmt::Display for RateUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl RateUnit {
    /// Each of some units once, in their order.
    #[must_use]
    pub fn each(units: impl Iterator<Item = Self>) -> Vec<Self> {
        let mut each = Vec::new();
        for unit in units {
            if !each.contains(&unit) {
                each.push(unit);
            }
        }
        each
    }

    /// The unit as it is written after a number.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Dps => "dps",
            Self::RadPerS => "rad/s",
            Self::Counts => "counts",
            Self::MetresPerS2 => "m/s^2",
        }
    }

    /// How many of another unit one of this is; `None` where they are of different quantities, or nobody knows, as of an
    /// A/D's counts.
    #[must_use]
    pub fn in_unit(self, other: Self) -> Option<f64> {
        match (self, other) {
            (own, other) if own == other => Some(1.0),
            (Self::Dps, Self::RadPerS) => Some(1.0_f64.to_radians()),
            (Self::RadPerS, Self::Dps) => Some(1.0_f64.to_degrees()),
            _ => None,
        }
    }
}

/// The unit of temperatures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum TemperatureUnit {
    /// Degrees Celsius.
    C,
    /// Counts of an A/D.
    #[serde(rename = "counts")]
    Counts,
}

impl TemperatureUnit {
    /// The least span of a calibration in this unit.
    #[must_use]
    pub fn min_span(self) -> f64 {
        match self {
            Self::C => MIN_SPAN_C,
            Self::Counts => MIN_SPAN_COUNTS,
        }
    }

    /// The unit as it is written after a number.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::C => "C",
            Self::Counts => "counts",
        }
    }
}
