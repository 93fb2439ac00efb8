//! What the page asks for.

use std::fmt::Display;
use std::str::FromStr;

use serde::Deserialize;
use thiserror::Error;
use zerorate_cal::log_fit::FitOptions;
use zerorate_cal::table::Columns;
use zerorate_cal::units::WrittenRate;

/// Logs of one unit, and what their user knows of them: each by the name of the page's field, and empty where nothing was
/// said.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Asked {
    /// The logs, in the order in which the page keeps them.
    pub files: Vec<AskedFile>,
    /// The unit's serial number.
    pub serial: String,
    /// The unit in which rates are told.
    pub units: String,
    time: String,
    temperature: String,
    /// Separated by commas.
    rate: String,
    time_unit: String,
    temperature_unit: String,
    rate_unit: String,
    sensor: String,
    allow_narrow: bool,
}

/// A file of the page.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AskedFile {
    /// Its name.
    pub name: String,
    /// Its length, bytes.
    pub length: u64,
}

/// A field that says what is not known.
#[derive(Debug, Error)]
#[error("`{field}`: {why}")]
pub struct FieldError {
    field: &'static str,
    why: String,
}

impl Asked {
    /// How the logs are to be fitted.
    ///
    /// # Errors
    /// [`FieldError`], of the first field that is not understood.
    pub fn options(&self) -> Result<FitOptions, FieldError> {
        let named = |name: &str| said(name).map(str::to_owned);
        let columns = Columns {
            time: named(&self.time),
            temperature: named(&self.temperature),
            rates: self.rate.split(',').filter_map(named).collect(),
            time_unit: read("time_unit", &self.time_unit)?,
            temperature_unit: read("temperature_unit", &self.temperature_unit)?,
            rate_unit: read("rate_unit", &self.rate_unit)?,
            else_rate_unit: None,
            likely_rate_unit: None,
        };
        Ok(FitOptions {
            columns,
            allow_narrow: self.allow_narrow,
            sensor: read("sensor", &self.sensor)?,
            told_in: self.told_in()?,
            ..FitOptions::default()
        })
    }

    /// The unit in which rates are told, if one was asked for.
    ///
    /// # Errors
    /// [`FieldError`].
    pub fn told_in(&self) -> Result<Option<WrittenRate>, FieldError> {
        read("units", &self.units)
    }

    /// The serial number, if one was given.
    #[must_use]
    pub fn serial(&self) -> Option<&str> {
        said(&self.serial)
    }
}

fn said(text: &str) -> Option<&str> {
    Some(text.trim()).filter(|text| !text.is_empty())
}

fn read<T: FromStr>(field: &'static str, text: &str) -> Result<Option<T>, FieldError>
where
    T::Err: Display,
{
    let read = said(text).map(str::parse).transpose();
    read.map_err(|why: T::Err| FieldError { field, why: why.to_string() })
}
