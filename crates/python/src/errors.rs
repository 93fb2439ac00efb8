//! Errors as Python's exceptions, each with the reason and what to do.

use std::error::Error as Fault;

use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use zerorate_cal::log_fit::LogFit;
use zerorate_words::sentence;

create_exception!(zerorate, Error, PyValueError, "What cannot be done, and what to do about it.");
create_exception!(
    zerorate,
    RejectedLog,
    Error,
    "A log that can be read and is no good for a calibration: `reasons` has why, a sentence each."
);

/// An error of a crate with its causes.
pub fn raised(fault: &(dyn Fault + 'static)) -> PyErr {
    told(&sentence(fault))
}

/// A sentence in which parameters are named as the crates name them; one of them is named otherwise here.
pub fn told(sentence: &str) -> PyErr {
    Error::new_err(sentence.replace("`rate`", "`rates`"))
}

/// A log that was rejected.
pub fn rejected(py: Python<'_>, fit: &LogFit) -> PyErr {
    let reasons: Vec<&str> = fit.reasons().collect();
    let error = RejectedLog::new_err(format!("{}: rejected: {}", fit.source(), reasons.join("; ")));
    match error.value(py).setattr("reasons", reasons) {
        Ok(()) => error,
        Err(other) => other,
    }
}
