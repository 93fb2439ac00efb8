//! The fit of logs.

use pyo3::prelude::*;
use zerorate_bench::recorded;
use zerorate_cal::fit::fit as fit_logs;
use zerorate_cal::source::Source as Readable;

use crate::calibration::Calibration;
use crate::errors::{raised, rejected};
use crate::heard::heard;
use crate::options::{Columns, How};
use crate::sources::Source;

/// Fits logs of one unit as one.
#[pyfunction]
pub fn fit(py: Python<'_>, sources: Vec<PyRef<'_, Source>>, columns: Columns, how: How) -> PyResult<Calibration> {
    let options = how.checked(columns)?;
    let sources: Vec<Readable> = sources.iter().map(|source| source.0.clone()).collect();
    let fitted = heard(py, &sources, move |sources| -> PyResult<_> {
        let fit = fit_logs(sources, &options).map_err(|error| raised(&error))?;
        if fit.judgement.rejected() {
            return Ok((fit, None));
        }
        let calibration = recorded::of_fit(sources, &fit, how.serial, how.labels.unwrap_or_default());
        Ok((fit, Some(calibration.map_err(|error| raised(&error))?)))
    })?;
    let (fit, calibration) = fitted?;
    match calibration {
        Some(file) => Ok(Calibration::fitted(file, fit)),
        None => Err(rejected(py, &fit)),
    }
}
