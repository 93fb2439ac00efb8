//! A log's rows as arrays.

use std::slice::from_ref;

use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use zerorate_cal::log::{LogFile, Rows, Sink, Stream};
use zerorate_cal::table::named_in;
use zerorate_cal::units::TemperatureUnit;

use crate::errors::raised;
use crate::heard::heard;
use crate::options::Columns;
use crate::sources::Source;

/// A sensor's name, and its columns by name.
type Frame<Column> = (String, Vec<(String, Column)>);

/// Of each sensor its name and its columns: seconds, temperature, and a column an axis.
#[pyfunction]
pub fn read_log<'py>(
    py: Python<'py>,
    source: &Source,
    columns: Columns,
) -> PyResult<Vec<Frame<Bound<'py, PyArray1<f64>>>>> {
    let columns = columns.checked()?;
    let read = heard(py, from_ref(&source.0), move |sources| {
        let mut kept = Kept::default();
        LogFile::open(&sources[0], &columns).and_then(|log| log.read(&mut kept)).map(|_| kept)
    })?;
    let columns = |numbers: Vec<(String, Vec<f64>)>| {
        numbers.into_iter().map(|(name, numbers)| (name, numbers.into_pyarray(py))).collect()
    };
    let sensors = read.map_err(|error| raised(&error))?.0;
    Ok(sensors.into_iter().map(|(name, numbers)| (name, columns(numbers))).collect())
}

/// All rows of all sensors.
#[derive(Default)]
struct Kept(Vec<Frame<Vec<f64>>>);

impl Sink for Kept {
    fn stream(&mut self, stream: &Stream) -> bool {
        let name = stream.sensor.map_or_else(|| "gyro".to_owned(), |sensor| sensor.to_string());
        let temperature = match stream.temperature_unit {
            TemperatureUnit::C => "temperature_c",
            TemperatureUnit::Counts => "temperature_counts",
        };
        let axes = stream.names.iter().map(|name| named_in(name, stream.unit));
        let names = ["time_s", temperature].map(str::to_owned).into_iter().chain(axes);
        self.0.push((name, names.map(|name| (name, Vec::new())).collect()));
        true
    }

    fn rows(&mut self, rows: &Rows<'_>) {
        let taken = [rows.time_s, rows.temperature].into_iter().chain(rows.values.iter().map(Vec::as_slice));
        for ((_, kept), taken) in self.0[rows.sensor].1.iter_mut().zip(taken) {
            kept.extend_from_slice(taken);
        }
    }
}
