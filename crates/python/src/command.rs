//! The command `zerorate`, for the script that pip installs.

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the command, the program's name first, and gives its exit code.
#[pyfunction]
pub fn command(py: Python<'_>, typed: Vec<OsString>) -> u8 {
    py.detach(|| zerorate::run(typed))
}
