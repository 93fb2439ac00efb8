//! What a calibration leaves of a log that it has not seen.

use std::slice::from_ref;

use pyo3::prelude::*;
use serde_json::to_string;
use zerorate_apply::verify::{Limits, VerifyOptions, known_columns, verify as verify_log};

use crate::calibration::Calibration;
use crate::errors::raised;
use crate::heard::heard;
use crate::json::loaded;
use crate::options::{Columns, parsed};
use crate::sources::Source;

/// What may be left, and of which sensors.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Against {
    max_rms: Option<String>,
    max_pp: Option<String>,
    max_offset: Option<String>,
    sensor: Option<String>,
    in_sample: bool,
}

/// Applies a calibration to a log and holds what is left against limits; gives what the command gives as JSON.
#[pyfunction]
pub fn verify<'py>(
    py: Python<'py>,
    source: &Source,
    calibration: &Calibration,
    columns: Columns,
    against: Against,
) -> PyResult<Bound<'py, PyAny>> {
    let [max_rms, max_pp, max_offset] = [&against.max_rms, &against.max_pp, &against.max_offset];
    let limits =
        Limits::for_all(parsed(max_rms.as_deref())?, parsed(max_pp.as_deref())?, parsed(max_offset.as_deref())?);
    let file = calibration.file.clone();
    limits.check(file.axes.keys().map(String::as_str)).map_err(|error| raised(&error))?;
    let (columns, sensor, in_sample) = (columns.checked()?, parsed(against.sensor.as_deref())?, against.in_sample);
    let text = heard(py, from_ref(&source.0), move |sources| -> PyResult<_> {
        let columns = known_columns(&sources[0], &file, columns);
        let options = VerifyOptions { columns, sensor, limits, in_sample, told_in: None };
        let verified = verify_log(&sources[0], &file, &options).map_err(|error| raised(&error))?;
        to_string(&verified).map_err(|error| raised(&error))
    })??;
    loaded(py, text)
}
