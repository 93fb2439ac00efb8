//! The class `Calibration`.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use zerorate_cal::calibration::Calibration as File;
use zerorate_cal::log_fit::LogFit;
use zerorate_cal::source::Source;
use zerorate_export::{ExportOptions, Format, export};
use zerorate_fit::predict::Start;
use zerorate_report::LogPage;

use crate::errors::{raised, told};
use crate::groups::groups;
use crate::json::loaded;
use crate::numbers::{Numbers, Seconds};
use crate::options::parsed;

/// What was fitted, as `calibration.json` keeps it; of a calibration that was just fitted its averages and its report too.
#[pyclass(frozen, module = "zerorate")]
pub struct Calibration {
    pub(crate) file: File,
    fit: Option<LogFit>,
}

impl Calibration {
    /// That of a fit.
    pub fn fitted(file: File, fit: LogFit) -> Self {
        Self { file, fit: Some(fit) }
    }

    fn fit(&self, what: &str) -> PyResult<&LogFit> {
        let missing = || told(&format!("a calibration that was read from a file has no {what}: fit its log again"));
        self.fit.as_ref().ok_or_else(missing)
    }
}

#[pymethods]
impl Calibration {
    /// Reads the file that `save` or the command wrote.
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        let file = File::read(&Source::file(&path)).map_err(|error| raised(&error))?;
        Ok(Self { file, fit: None })
    }

    /// Reads a calibration from its text.
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        let file = File::from_json(text).map_err(|error| raised(&error))?;
        Ok(Self { file, fit: None })
    }

    /// The text of `calibration.json`.
    fn to_json(&self) -> PyResult<String> {
        self.file.to_json().map_err(|error| raised(&error))
    }

    /// The same as a dict.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        loaded(py, self.to_json()?)
    }

    /// Writes `calibration.json`.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        Ok(fs::write(path, self.to_json()?)?)
    }

    /// The names of the axes.
    #[getter]
    fn axes(&self) -> Vec<&str> {
        self.file.axes.keys().map(String::as_str).collect()
    }

    /// Of each axis the unit of its rates.
    #[getter]
    fn rate_units(&self) -> BTreeMap<&str, &'static str> {
        self.file.axes.iter().map(|(name, axis)| (name.as_str(), axis.rate_unit.name())).collect()
    }

    /// The unit of every temperature.
    #[getter]
    fn temperature_unit(&self) -> &'static str {
        self.file.temperature_unit.name()
    }

    /// What to look at, a sentence each.
    #[getter]
    fn warnings(&self) -> Vec<&str> {
        self.file.warnings.iter().map(String::as_str).collect()
    }

    /// What to know of how the log was read, a sentence each; nothing of a calibration that was read from a file.
    #[getter]
    fn notes(&self) -> Vec<&str> {
        self.fit.iter().flat_map(|fit| &fit.notes).map(String::as_str).collect()
    }

    /// What a device takes off that is switched on with the first row: of each axis an array of shape (n,), in its rate unit.
    ///
    /// `temperature` is of shape (n,), in `temperature_unit`; `time` of shape (n,), seconds from anywhere or datetime64, is needed
    /// where the model lags behind its temperature. The recording's own drift in time is left out.
    #[pyo3(signature = (temperature, time=None))]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        temperature: Numbers,
        time: Option<Seconds>,
    ) -> PyResult<BTreeMap<&str, Bound<'py, PyArray1<f64>>>> {
        let (Numbers(temperature), time) = (temperature, time.map(|Seconds(time)| time));
        if let Some(time) = time.as_ref().filter(|time| time.len() != temperature.len()) {
            return Err(told(&format!("{} times for {} temperatures: give one each", time.len(), temperature.len())));
        }
        let needs_time = |name: &&String| self.file.axes[*name].fit.model.needs_time(Start::Unknown);
        if let Some(axis) = self.file.axes.keys().find(needs_time).filter(|_| time.is_none()) {
            return Err(told(&format!("{axis} lags behind its temperature: give the `time` of each, seconds")));
        }
        let time = time.unwrap_or_else(|| vec![f64::NAN; temperature.len()]);
        let rows = || time.iter().copied().zip(temperature.iter().copied());
        let predict =
            || self.file.axes.iter().map(|(name, axis)| (name.as_str(), axis.fit.model.biases(rows()))).collect();
        let predicted: Vec<(&str, Vec<f64>)> = py.detach(predict);
        Ok(predicted.into_iter().map(|(name, biases)| (name, biases.into_pyarray(py))).collect())
    }

    /// The static curve of one axis, in its rate unit, at temperatures of shape (n,); of a model with a history that for when it is not known.
    fn curve<'py>(&self, py: Python<'py>, axis: &str, temperature: Numbers) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let Some(found) = self.file.axes.get(axis) else {
            return Err(told(&format!("there is no axis '{axis}'; the axes are {}", self.axes().join(", "))));
        };
        let curve: Vec<f64> = temperature.0.iter().map(|&temperature| found.drift().evaluate(temperature).0).collect();
        Ok(curve.into_pyarray(py))
    }

    /// The text of a file for another program: px4, ardupilot, methodic-configurator, c, json or csv.
    #[pyo3(signature = (format, *, device_id=None, instance=None))]
    fn export(&self, format: &str, device_id: Option<u32>, instance: Option<u8>) -> PyResult<String> {
        let format: Format = format.parse().map_err(|error| raised(&error))?;
        let exported = export(&self.file, format, &ExportOptions { device_id, instance });
        Ok(exported.map_err(|error| raised(&error))?.text)
    }

    /// The report as one HTML page, with rates in `units` (mdps, deg/h) if given; of a calibration that was just fitted.
    #[pyo3(signature = (*, units=None))]
    fn report_html(&self, py: Python<'_>, units: Option<&str>) -> PyResult<String> {
        let (fit, units) = (self.fit("report")?, parsed(units)?);
        let File { unit_serial, labels, sources, .. } = &self.file;
        let serial = unit_serial.as_deref();
        let page =
            || LogPage { fit, units, serial, labels, sources, chamber: None, next_command: None, export_command: None };
        Ok(py.detach(|| page().to_html()))
    }

    /// Of each axis the averages that were fitted, arrays of shape (n,): `time_s`, seconds; `temperature`; `rate` and `residual`.
    fn groups<'py>(&self, py: Python<'py>) -> PyResult<BTreeMap<&str, Bound<'py, PyDict>>> {
        groups(py, self.fit("averages")?)
    }

    /// Draws each axis: what was fitted, and its curve.
    #[pyo3(signature = (*args, **keywords))]
    fn plot<'py>(
        slf: &Bound<'py, Self>,
        args: &Bound<'py, PyTuple>,
        keywords: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let all = PyTuple::new(slf.py(), [slf.as_any().clone()])?.add(args)?;
        slf.py().import("zerorate._plot")?.getattr("plot")?.call(all.cast::<PyTuple>()?, keywords)
    }

    fn __repr__(&self) -> String {
        let axis = |(name, axis): (&String, &zerorate_cal::calibration::AxisCalibration)| {
            format!("{name}: {}", axis.fit.chosen_model())
        };
        format!("<Calibration of {}>", self.file.axes.iter().map(axis).collect::<Vec<_>>().join(", "))
    }
}
