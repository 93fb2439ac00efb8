//! Pass limits, with their units.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use serde::Deserialize;
use thiserror::Error;

use super::VerifiedAxis;
use zerorate_cal::units::{RateScale, RateUnit, WrittenRate};

/// A size with its unit, as it was written: `0.5 mrad/s`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub struct Limit {
    /// The size in `unit`, above zero.
    value: f64,
    unit: RateUnit,
    /// As it was written.
    text: String,
}

/// A limit that makes no sense.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum LimitError {
    /// Not a number with a unit.
    #[error(
        "'{0}' is no limit: give a number above zero and a unit, as 0.5mrad/s, 0.02dps, 30deg/h, 12counts or 0.01m/s^2"
    )]
    Unclear(String),
    /// A unit of another quantity.
    #[error("the limit of {text} cannot be held against axis {axis}, which is in {unit}")]
    OtherQuantity {
        /// The limit.
        text: String,
        /// The axis.
        axis: String,
        /// Its unit.
        unit: RateUnit,
    },
    /// Limits for an axis that there is not.
    #[error("the limits name axis '{0}', which the log or the calibration does not have")]
    NoSuchAxis(String),
}

/// What a limit's unit may be called, what it is, and how many of that.
const UNITS: [(&str, RateUnit, f64); 12] = [
    ("mrad/s", RateUnit::RadPerS, 1e-3),
    ("urad/s", RateUnit::RadPerS, 1e-6),
    ("rad/s", RateUnit::RadPerS, 1.0),
    ("mdps", RateUnit::Dps, 1e-3),
    ("dps", RateUnit::Dps, 1.0),
    ("mdeg/s", RateUnit::Dps, 1e-3),
    ("deg/s", RateUnit::Dps, 1.0),
    ("deg/h", RateUnit::Dps, 1.0 / 3600.0),
    ("dph", RateUnit::Dps, 1.0 / 3600.0),
    ("counts", RateUnit::Counts, 1.0),
    ("mm/s^2", RateUnit::MetresPerS2, 1e-3),
    ("m/s^2", RateUnit::MetresPerS2, 1.0),
];

impl FromStr for Limit {
    type Err = LimitError;
    fn from_str(text: &str) -> Result<Self, LimitError> {
        let unclear = || LimitError::Unclear(text.to_owned());
        let at = text.find(|c: char| !(c.is_ascii_digit() || ".+-eE".contains(c))).ok_or_else(unclear)?;
        let (number, name) = (text[..at].trim(), text[at..].trim());
        let (_, unit, factor) = UNITS.iter().find(|(own, _, _)| *own == name).ok_or_else(unclear)?;
        let value: f64 = number.parse().map_err(|_| unclear())?;
        if !(value.is_finite() && value > 0.0) {
            return Err(unclear());
        }
        Ok(Self { value: value * factor, unit: *unit, text: format!("{number} {name}") })
    }
}

impl TryFrom<String> for Limit {
    type Error = LimitError;
    fn try_from(text: String) -> Result<Self, LimitError> {
        text.parse()
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Limit {
    /// The limit in an axis's unit.
    pub(super) fn in_unit(&self, axis: &str, unit: RateUnit) -> Result<f64, LimitError> {
        let other = || LimitError::OtherQuantity { text: self.text.clone(), axis: axis.to_owned(), unit };
        self.unit.in_unit(unit).map(|factor| self.value * factor).ok_or_else(other)
    }
}

/// Limits on what is left, each optional.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// Root mean square about the mean.
    pub max_rms: Option<Limit>,
    /// Peak to peak.
    pub max_pp: Option<Limit>,
    /// The mean, without its sign.
    pub max_offset: Option<Limit>,
}

/// Limits for all axes, and for some by name. As TOML: `max_rms = "0.5 mrad/s"`, and `[axes."gyro0.x"]` with the same
/// fields for one.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Root mean square about the mean.
    pub max_rms: Option<Limit>,
    /// Peak to peak.
    pub max_pp: Option<Limit>,
    /// The mean, without its sign.
    pub max_offset: Option<Limit>,
    /// Limits of single axes, in place of the above.
    #[serde(default)]
    pub axes: BTreeMap<String, Bounds>,
}

impl Limits {
    /// The same limits for all axes.
    #[must_use]
    pub fn for_all(max_rms: Option<Limit>, max_pp: Option<Limit>, max_offset: Option<Limit>) -> Self {
        Self { max_rms, max_pp, max_offset, axes: BTreeMap::new() }
    }

    /// Whether there is no limit at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        let none = |bounds: &Bounds| bounds.max_rms.is_none() && bounds.max_pp.is_none() && bounds.max_offset.is_none();
        self.max_rms.is_none() && self.max_pp.is_none() && self.max_offset.is_none() && self.axes.values().all(none)
    }

    /// Refuses limits for axes that are not among `names`.
    ///
    /// # Errors
    /// [`LimitError::NoSuchAxis`].
    pub fn check<'a>(&self, names: impl Iterator<Item = &'a str> + Clone) -> Result<(), LimitError> {
        let unknown = self.axes.keys().find(|axis| !names.clone().any(|name| name == *axis));
        unknown.map_or(Ok(()), |axis| Err(LimitError::NoSuchAxis(axis.clone())))
    }

    /// The limits that an axis misses, a sentence each, which tells rates in the unit asked for.
    pub(super) fn missed(&self, axis: &VerifiedAxis, told_in: Option<WrittenRate>) -> Result<Vec<String>, LimitError> {
        let own = self.axes.get(&axis.name);
        let bound = |of: fn(&Bounds) -> &Option<Limit>, all: &Option<Limit>| {
            own.and_then(|own| of(own).clone()).or_else(|| all.clone())
        };
        let checks = [
            ("rms", bound(|b| &b.max_rms, &self.max_rms), axis.corrected.rms),
            ("peak to peak", bound(|b| &b.max_pp, &self.max_pp), axis.corrected.pp),
            ("mean", bound(|b| &b.max_offset, &self.max_offset), axis.offset.abs()),
        ];
        let mut missed = Vec::new();
        for (what, limit, found) in checks {
            if let Some(limit) = limit {
                // What is no number does not pass.
                let most = limit.in_unit(&axis.name, axis.rate_unit)?;
                if found.is_nan() || found > most {
                    let (name, times) = (&axis.name, found / most);
                    // Two numbers that are written alike are no statement.
                    let times = match format!("{times:.2}").as_str() {
                        "1.00" => "just over".to_owned(),
                        times => format!("{times} times"),
                    };
                    missed.push(format!(
                        "{name}: {what} {}, {times} the limit of {limit}",
                        RateScale::of(axis.rate_unit, &[found], told_in).told(found)
                    ));
                }
            }
        }
        Ok(missed)
    }
}
