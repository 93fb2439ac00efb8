//! Arguments that are arrays of numbers, as the package's Python makes them: what is masked is NaN.

use numpy::PyReadonlyArray1;
use pyo3::prelude::*;

/// Numbers of shape (n,).
pub struct Numbers(pub Vec<f64>);

/// Times of shape (n,): seconds from anywhere, or dates.
pub struct Seconds(pub Vec<f64>);

impl<'py> FromPyObject<'_, 'py> for Numbers {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        made("numbers", given).map(Self)
    }
}

impl<'py> FromPyObject<'_, 'py> for Seconds {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        made("seconds", given).map(Self)
    }
}

/// By a function of the package that gives float64.
fn made(function: &str, given: Borrowed<'_, '_, PyAny>) -> PyResult<Vec<f64>> {
    let made = given.py().import("zerorate._sources")?.getattr(function)?.call1((given,))?;
    Ok(made.extract::<PyReadonlyArray1<'_, f64>>()?.as_array().to_vec())
}
