//! The averages that were fitted, as arrays.

use std::collections::BTreeMap;

use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use zerorate_cal::log_fit::LogFit;
use zerorate_fit::trace::TracePoint;

/// A column of what is told of a point: its name, and its number.
pub type Told<Point> = (&'static str, fn(&Point) -> f64);

/// What is told of each average, and in which order.
const COLUMNS: [Told<TracePoint>; 4] = [
    ("time_s", |point| point.time_s),
    ("temperature", |point| point.temperature),
    ("rate", |point| point.rate),
    ("residual", |point| point.residual),
];

/// Of each axis its averages, a column each.
pub fn groups<'py, 'a>(py: Python<'py>, fit: &'a LogFit) -> PyResult<BTreeMap<&'a str, Bound<'py, PyDict>>> {
    let mut axes = BTreeMap::new();
    for axis in &fit.axes {
        axes.insert(axis.name.as_str(), columns(py, &axis.trace, &COLUMNS)?);
    }
    Ok(axes)
}

/// Points as a column each of what is told of them.
pub fn columns<'py, Point>(py: Python<'py>, points: &[Point], told: &[Told<Point>]) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    for (name, of) in told {
        let numbers: Vec<f64> = points.iter().map(of).collect();
        columns.set_item(name, numbers.into_pyarray(py))?;
    }
    Ok(columns)
}
