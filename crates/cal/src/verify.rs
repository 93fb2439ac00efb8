//! What a calibration leaves on a log that it has not seen, against pass limits.
//!
//! The log is conditioned as for a fit: start-up, spikes and times at which the unit was moved are left out, and what is
//! left is averaged over about 10 s. A gyro's zero of another day is another constant, so sizes are about the mean and the
//! mean is told beside them.

mod limits;

use std::fmt;

use serde::Serialize;
use thiserror::Error;
use zerorate_fit::model::Model;
use zerorate_fit::predict::{Predictor, Start};
use zerorate_fit::residual::ResidualStatistics;

pub use limits::{Limit, LimitError, Limits};

use crate::calibration::{AxisCalibration, Calibration, sha256};
use crate::fit::fit;
use crate::log::LogFault;
use crate::log_fit::{AxisFit, FitOptions, LogFit, LogFitError};
use crate::quality::{Reason, ReasonKind};
use crate::source::{Faulty, Source};
use crate::table::Columns;
use crate::trace::TracePoint;
use crate::units::{RateUnit, TemperatureUnit};

/// How an axis of the log did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VerifiedAxis {
    /// The axis's name.
    pub name: String,
    /// The unit of all rates.
    pub rate_unit: RateUnit,
    /// What was recorded, about its mean, over averages of about 10 s.
    pub raw: ResidualStatistics,
    /// What the calibration leaves, about its mean.
    pub corrected: ResidualStatistics,
    /// The mean that the calibration leaves: the zero of this run against that of the calibration's.
    pub offset: f64,
    /// The least and the greatest temperature in the log.
    pub temperature: [f64; 2],
    /// The share of the log outside the calibrated range, 0 to 1: there the curve was held at its end.
    pub outside: f64,
    /// The limits that it misses, a sentence each; none where it passed.
    pub missed: Vec<String>,
    /// What was recorded and what is left, for figures.
    #[serde(skip)]
    pub points: Vec<VerifiedPoint>,
}

/// A point of a figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VerifiedPoint {
    /// Seconds from the log's first row; NaN if not known.
    pub time_s: f64,
    /// Temperature, in the log's unit.
    pub temperature: f64,
    /// As recorded.
    pub raw: f64,
    /// Less the calibration's bias.
    pub corrected: f64,
}

/// How a log did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verified {
    /// The log, as it was given.
    pub log: String,
    /// Whether every axis of the calibration is there and meets its limits; `None` where no limit was given and none is
    /// missing: then nothing was tested.
    pub passed: Option<bool>,
    /// Whether the calibration was fitted on this very log: what is left is then in-sample, and no test.
    pub in_sample: bool,
    /// The temperature's unit.
    pub temperature_unit: TemperatureUnit,
    /// The axes that the calibration and the log share.
    pub axes: Vec<VerifiedAxis>,
    /// The calibration's axes of which the log has nothing that can be used, a sentence each.
    pub missing: Vec<String>,
    /// What was found wrong with the log, and what to know.
    pub warnings: Vec<String>,
}

/// Why a log cannot be verified.
#[derive(Debug, Error)]
pub enum VerifyError {
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogFitError),
    /// The log is no test of the calibration.
    #[error(transparent)]
    NoTest(#[from] Faulty<NoTest>),
    /// A limit makes no sense for an axis.
    #[error(transparent)]
    Limit(#[from] LimitError),
}

/// Why a log is no test of a calibration.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum NoTest {
    /// The log is the one that the calibration was fitted on.
    #[error(
        "the calibration was fitted on this very log (by its SHA-256), so it is no test of it: give a log of another run, or allow it (`in_sample`) to look all the same"
    )]
    InSample,
    /// The log is no good for this.
    #[error("{reasons}")]
    Unusable {
        /// Why.
        reasons: String,
    },
    /// No axis in common.
    #[error("it has {found}, and the calibration is for {expected}")]
    NoAxis {
        /// Its axes.
        found: String,
        /// The calibration's.
        expected: String,
    },
    /// The units differ.
    #[error("axis {axis} is in {found}, and the calibration's in {expected}: say which it is (`rate_unit`)")]
    Unit {
        /// The axis.
        axis: String,
        /// The log's unit.
        found: String,
        /// The calibration's.
        expected: String,
    },
}

/// Applies a calibration to a log and holds what is left against limits. With `in_sample` a log that the calibration was
/// fitted on is taken all the same.
///
/// # Errors
/// [`VerifyError`].
pub fn verify(
    log: &Source,
    calibration: &Calibration,
    columns: &Columns,
    limits: &Limits,
    in_sample: bool,
) -> Result<Verified, VerifyError> {
    let sha256 = sha256(log).map_err(|error| LogFitError::from(log.faulty::<LogFault>(error)))?;
    let is_own = calibration.sources.iter().any(|source| source.sha256 == sha256);
    if is_own && !in_sample {
        return Err(log.faulty(NoTest::InSample).into());
    }
    // The curve of this fit is not used: the simplest will do.
    let options =
        FitOptions { columns: columns.clone(), model: Model::Poly(1), allow_narrow: true, ..FitOptions::default() };
    let fit = fit(std::slice::from_ref(log), &options)?;
    if fit.axes.is_empty() {
        let reasons = fit.reasons().collect::<Vec<_>>().join("; ");
        return Err(log.faulty(NoTest::Unusable { reasons }).into());
    }
    let mut axes = Vec::new();
    for axis in &fit.axes {
        if let Some(own) = calibration.axes.get(&axis.name) {
            axes.push(verify_axis(log, axis, own, calibration, limits)?);
        }
    }
    if axes.is_empty() {
        let found = fit.axes.iter().map(|axis| axis.name.as_str()).collect::<Vec<_>>().join(", ");
        let expected = calibration.axes.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
        return Err(log.faulty(NoTest::NoAxis { found, expected }).into());
    }
    let missing: Vec<String> = calibration.axes.keys().filter_map(|name| missing(name, &fit)).collect();
    let is_within = missing.is_empty() && axes.iter().all(|axis| axis.missed.is_empty());
    let mut warnings: Vec<String> =
        fit.judgement.reasons.iter().filter(|r| !is_of_span(r)).map(|r| r.text.clone()).collect();
    warnings.extend(axes.iter().filter(|axis| axis.outside > 0.0).map(|axis| {
        format!(
            "{}: {:.0} % of the log is outside the calibrated temperatures, where the curve is held at its end",
            axis.name,
            (100.0 * axis.outside).ceil()
        )
    }));
    Ok(Verified {
        log: log.name().to_owned(),
        passed: (!limits.is_empty() || !is_within).then_some(is_within),
        in_sample: is_own,
        temperature_unit: calibration.temperature_unit,
        axes,
        missing,
        warnings,
    })
}

/// Why there is nothing of an axis, if there is nothing.
fn missing(name: &str, fit: &LogFit) -> Option<String> {
    if fit.axes.iter().any(|axis| axis.name == name) {
        return None;
    }
    let rejected = fit.verdicts.iter().filter(|axis| axis.name == name);
    let reasons: Vec<&str> = rejected.flat_map(|axis| &axis.judgement.reasons).map(|r| r.text.as_str()).collect();
    Some(if reasons.is_empty() {
        format!("{name}: the log has no such axis")
    } else {
        format!("{name}: nothing that can be used: {}", reasons.join("; "))
    })
}

/// A narrow span is no fault of a log that is not fitted.
fn is_of_span(reason: &Reason) -> bool {
    reason.kind == ReasonKind::NarrowSpan
}

fn verify_axis(
    log: &Source,
    axis: &AxisFit,
    own: &AxisCalibration,
    calibration: &Calibration,
    limits: &Limits,
) -> Result<VerifiedAxis, VerifyError> {
    let unit = |found: &dyn fmt::Display, expected: &dyn fmt::Display| {
        let (found, expected) = (found.to_string(), expected.to_string());
        log.faulty::<NoTest>(NoTest::Unit { axis: axis.name.clone(), found, expected }).into()
    };
    if axis.calibration.rate_unit != own.rate_unit {
        return Err(unit(&axis.calibration.rate_unit, &own.rate_unit));
    }
    if axis.temperature_unit != calibration.temperature_unit {
        return Err(unit(&axis.temperature_unit.name(), &calibration.temperature_unit.name()));
    }
    let points = corrected(own, &axis.trace);
    let raw: Vec<f64> = points.iter().map(|point| point.raw).collect();
    let left: Vec<f64> = points.iter().map(|point| point.corrected).collect();
    let temperatures = points.iter().map(|point| point.temperature);
    let outside = points
        .iter()
        .filter(|point| point.temperature < own.drift().valid.min() || point.temperature > own.drift().valid.max())
        .count();
    let (corrected, offset) = ResidualStatistics::about_mean(&left);
    let mut verified = VerifiedAxis {
        name: axis.name.clone(),
        rate_unit: own.rate_unit,
        raw: ResidualStatistics::about_mean(&raw).0,
        corrected,
        offset,
        temperature: [
            temperatures.clone().fold(f64::INFINITY, f64::min),
            temperatures.fold(f64::NEG_INFINITY, f64::max),
        ],
        outside: outside as f64 / points.len().max(1) as f64,
        missed: Vec::new(),
        points,
    };
    verified.missed = limits.missed(&verified)?;
    Ok(verified)
}

/// The points of a log with a calibration's bias taken off.
fn corrected(own: &AxisCalibration, trace: &[TracePoint]) -> Vec<VerifiedPoint> {
    let finite = |point: &&TracePoint| point.temperature.is_finite() && point.rate.is_finite();
    // The history begins with the log, as it does on a device that is switched on.
    let mut predictor = Predictor::new(&own.fit.model, Start::Unknown);
    let correct = |point: &TracePoint| VerifiedPoint {
        time_s: point.time_s,
        temperature: point.temperature,
        raw: point.rate,
        corrected: point.rate - predictor.predict(point.time_s, point.temperature).bias,
    };
    trace.iter().filter(finite).map(correct).collect()
}

#[cfg(test)]
mod tests;
