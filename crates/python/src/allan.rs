//! The Allan deviation.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use zerorate_fit::allan::{Allan, AllanPoint};

use crate::errors::raised;
use crate::groups::{Told, columns};
use crate::heard::heard;
use crate::json::loaded;
use crate::numbers::Numbers;

/// What is told of each averaging time.
const COLUMNS: [Told<AllanPoint>; 5] = [
    ("tau_s", |point| point.tau_s),
    ("deviation", |point| point.deviation),
    ("low", |point| point.low),
    ("high", |point| point.high),
    ("degrees_of_freedom", |point| point.degrees_of_freedom),
];

/// The overlapping Allan deviation of evenly spaced rates of shape (n,) at constant temperature, `period_s` seconds apart; NaN
/// marks a gap.
///
/// Gives a dict of arrays of one shape: `tau_s`, averaging time, seconds; `deviation` and its confidence bounds `low` and
/// `high`, in the rates' unit; `degrees_of_freedom`; and the `coefficients`: angle random walk, bias instability, rate random walk.
/// `filtered_below_s` is the averaging time below which samples resemble their neighbours, as behind a filter, or None;
/// `smooth_trend`, whether the curve rises by a smooth trend, which is no noise.
#[pyfunction]
pub fn allan_deviation<'py>(py: Python<'py>, rates: Numbers, period_s: f64) -> PyResult<Bound<'py, PyDict>> {
    let found = heard(py, &[], move |_| Allan::of(&rates.0, period_s))?;
    let found = found.map_err(|error| raised(&error))?;
    let told = columns(py, &found.points, &COLUMNS)?;
    let coefficients = serde_json::to_string(&found.coefficients).map_err(|error| raised(&error))?;
    told.set_item("filtered_below_s", found.filtered_below_s)?;
    told.set_item("smooth_trend", found.smooth_trend)?;
    told.set_item("coefficients", loaded(py, coefficients)?)?;
    Ok(told)
}
