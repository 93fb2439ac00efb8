//! Python's keywords as the crates' options.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::str::FromStr;

use pyo3::prelude::*;
use zerorate_cal::log_fit::{FitOptions, GROUP_SECONDS};
use zerorate_cal::table;

use crate::errors::told;

/// Which column is which, and in what unit.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Columns {
    time: Option<String>,
    temperature: Option<String>,
    rates: Option<Vec<String>>,
    time_unit: Option<String>,
    temperature_unit: Option<String>,
    rate_unit: Option<String>,
}

impl Columns {
    /// As the crates take them.
    pub fn checked(self) -> PyResult<table::Columns> {
        Ok(table::Columns {
            time: self.time,
            temperature: self.temperature,
            rates: self.rates.unwrap_or_default(),
            time_unit: parsed(self.time_unit.as_deref())?,
            temperature_unit: parsed(self.temperature_unit.as_deref())?,
            rate_unit: parsed(self.rate_unit.as_deref())?,
            else_rate_unit: None,
            likely_rate_unit: None,
        })
    }
}

/// How a log is fitted, and what its calibration is to say besides.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct How {
    model: String,
    plain: bool,
    allow_narrow: bool,
    group_seconds: Option<f64>,
    sensor: Option<String>,
    /// The unit's serial number.
    pub serial: Option<String>,
    /// What whoever fits it knows of it, by name.
    pub labels: Option<BTreeMap<String, String>>,
}

impl How {
    /// As the crates take it.
    pub fn checked(&self, columns: Columns) -> PyResult<FitOptions> {
        if let Some(seconds) = self.group_seconds.filter(|seconds| !GROUP_SECONDS.contains(seconds)) {
            let (least, most) = (GROUP_SECONDS.start(), GROUP_SECONDS.end());
            return Err(told(&format!("`group_seconds` {seconds}: give {least} to {most} seconds")));
        }
        Ok(FitOptions {
            columns: columns.checked()?,
            model: self.model.parse().map_err(|error| told(&format!("{error}")))?,
            plain: self.plain,
            allow_narrow: self.allow_narrow,
            group_s: self.group_seconds,
            sensor: parsed(self.sensor.as_deref())?,
            ..FitOptions::default()
        })
    }
}

/// A text that a crate reads, if one was given.
pub fn parsed<T: FromStr>(text: Option<&str>) -> PyResult<Option<T>>
where
    T::Err: Display,
{
    text.map(str::parse).transpose().map_err(|error: T::Err| told(&error.to_string()))
}
