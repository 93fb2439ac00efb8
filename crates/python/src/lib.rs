//! The half of the Python package `zerorate` that is in Rust: the command's own code on what Python has in memory.
//!
//! What users call is in `python/zerorate`; here numbers change hands, and nothing is computed that a crate of ours computes.
//! While a crate is at work Python's lock is released, and Ctrl-C is heard.

mod allan;
mod calibration;
mod command;
mod errors;
mod fit;
mod groups;
mod heard;
mod json;
mod numbers;
mod options;
mod read_log;
mod sources;
mod verify;

use pyo3::prelude::*;

#[pymodule]
fn _zerorate(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("Error", py.get_type::<errors::Error>())?;
    module.add("RejectedLog", py.get_type::<errors::RejectedLog>())?;
    module.add_class::<calibration::Calibration>()?;
    module.add_class::<sources::Source>()?;
    module.add_function(wrap_pyfunction!(fit::fit, module)?)?;
    module.add_function(wrap_pyfunction!(verify::verify, module)?)?;
    module.add_function(wrap_pyfunction!(read_log::read_log, module)?)?;
    module.add_function(wrap_pyfunction!(allan::allan_deviation, module)?)?;
    module.add_function(wrap_pyfunction!(command::command, module)?)
}
