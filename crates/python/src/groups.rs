//! The averages that were fitted, as arrays.

use std::collections::BTreeMap;

use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use zerorate_cal::log_fit::LogFit;
use zerorate_fit::trace::TracePoint;

/// What is told of each average, and in which order.
const COLUMNS: [(&str, fn(&TracePoint) -> f64); 4] = [
    ("time_s", |point| point.time_s),
    ("temperature", |point| point.temperature),
    ("rate", |point| point.rate),
    ("residual", |point| point.residual),
];

/// Of each axis its averages, a column each.
pub fn groups<'py, 'a>(py: Python<'py>, fit: &'a LogFit) -> PyResult<BTreeMap<&'a str, Bound<'py, PyDict>>> {
    let mut axes = BTreeMap::new();
    for axis in &fit.axes {
        let columns = PyDict::new(py);
        for (name, of) in COLUMNS {
            let numbers: Vec<f64> = axis.trace.iter().map(of).collect();
            columns.set_item(name, numbers.into_pyarray(py))?;
        }
        axes.insert(axis.name.as_str(), columns);
    }
    Ok(axes)
}
