//! One axis of a log, with a calibration's bias taken off.

use serde::Serialize;
use zerorate_fit::boot::left_after_zero;
use zerorate_fit::folds::TELLING;
use zerorate_fit::predict::Start;
use zerorate_fit::residual::ResidualStatistics;

use super::NoTest;
use crate::apply::TimeFault;
use zerorate_cal::calibration::AxisCalibration;
use zerorate_cal::condition::DropReason;
use zerorate_cal::log_fit::AxisFit;
use zerorate_cal::units::{RateUnit, TemperatureUnit};
use zerorate_fit::trace::TracePoint;

/// A rate that never changes is left as it is but for its last digits, and those are nobody's drift.
const ROUNDING: f64 = 1e-9;

/// An axis without a rate in more of the rows was not tested: what it did in most of the run nobody knows.
const LEAST_COVERED: f64 = 0.5;

/// How an axis of the log did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VerifiedAxis {
    /// The calibration's name of it.
    pub name: String,
    /// The log's.
    pub log_axis: String,
    /// The unit of all rates: the calibration's.
    pub rate_unit: RateUnit,
    /// What was recorded, about its mean, over averages of 10 s.
    pub raw: ResidualStatistics,
    /// What the calibration leaves, about its mean.
    pub corrected: ResidualStatistics,
    /// The mean that the calibration leaves: the zero of this run against that of the calibration's.
    pub offset: f64,
    /// What a device has left that takes its zero in the run's first half minute and corrects from then on: what a fit
    /// tells by the same name ([`zerorate_fit::drift_fit::FitStatistics::deployed`]).
    pub deployed: ResidualStatistics,
    /// What the calibration's fit told of that; `None` of a board, and where it could not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fit_told: Option<ResidualStatistics>,
    /// The same without the calibration: what a device has left that takes its zero and corrects nothing.
    pub uncorrected: ResidualStatistics,
    /// Whether more is left than was recorded, by more than a twentieth, by the root mean square about the mean or less a zero at the
    /// start: no correction would be better.
    pub worse: bool,
    /// Whether it is so about the mean.
    #[serde(skip)]
    pub worse_about_mean: bool,
    /// The least and the greatest temperature in the log.
    pub temperature: [f64; 2],
    /// The least and the greatest temperature that were measured for the calibration.
    pub calibrated_temperature: [f64; 2],
    /// Whether the curve goes on beyond those before it is held.
    #[serde(skip)]
    pub goes_on: bool,
    /// The share of the log outside those that were measured, 0 to 1: there nothing was measured that the curve could rest on.
    pub outside: f64,
    /// The share of the log's rows with a temperature that have a rate of this axis, 0 to 1: all that is told is of those.
    pub covered: f64,
    /// The limits that it misses, a sentence each; none where it passed.
    pub missed: Vec<String>,
    /// What was recorded and what is left, for figures.
    #[serde(skip)]
    pub points: Vec<VerifiedPoint>,
}

/// An average of the log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VerifiedPoint {
    /// Seconds from the log's first row; NaN if not known.
    pub time_s: f64,
    /// Temperature, in the log's unit.
    pub temperature: f64,
    /// As recorded, in the calibration's unit.
    pub raw: f64,
    /// Less the calibration's bias.
    pub corrected: f64,
}

/// Takes the `biases` off an axis, `factor` of whose unit are one of the log's, and says what is left. Limits are not looked at.
pub(super) fn verify(name: &str, own: &AxisCalibration, axis: &AxisFit, factor: f64, biases: &[f64]) -> VerifiedAxis {
    let points = corrected(&axis.trace, biases, factor);
    let raw: Vec<f64> = points.iter().map(|point| point.raw).collect();
    let left: Vec<f64> = points.iter().map(|point| point.corrected).collect();
    let times: Vec<f64> = points.iter().map(|point| point.time_s).collect();
    let temperatures = || points.iter().map(|point| point.temperature);
    let (measured, believed) = (own.fit.measured, own.fit.model.drift.valid);
    let outside = temperatures().filter(|t| *t < measured.min() || *t > measured.max()).count();
    let uncorrected = left_after_zero(raw.clone(), &times);
    let (raw, _) = ResidualStatistics::about_mean(&raw);
    let (corrected, offset) = ResidualStatistics::about_mean(&left);
    let deployed = left_after_zero(left, &times);
    let worse_about_mean = corrected.rms > TELLING * raw.rms + ROUNDING * offset.abs();
    VerifiedAxis {
        name: name.to_owned(),
        log_axis: axis.name.clone(),
        rate_unit: own.rate_unit,
        raw,
        corrected,
        offset,
        deployed,
        fit_told: own.fit.statistics.deployed,
        uncorrected,
        worse: worse_about_mean || deployed.rms > TELLING * uncorrected.rms,
        worse_about_mean,
        temperature: [temperatures().fold(f64::INFINITY, f64::min), temperatures().fold(f64::NEG_INFINITY, f64::max)],
        calibrated_temperature: [measured.min(), measured.max()],
        goes_on: believed.min() < measured.min() || believed.max() > measured.max(),
        outside: outside as f64 / points.len().max(1) as f64,
        covered: covered(axis),
        missed: Vec::new(),
        points,
    }
}

/// The share of rows with a rate, of those with a temperature.
fn covered(axis: &AxisFit) -> f64 {
    let used = axis.calibration.fit.statistics.samples_used as f64;
    let missing = axis.samples_rejected.iter().filter(|rejected| rejected.reason == DropReason::MissingRate);
    let missing = missing.map(|rejected| rejected.count as f64).sum::<f64>();
    used / (used + missing)
}

impl VerifiedAxis {
    /// Why it is no test of the axis, a sentence, where most of its rates are missing.
    pub(super) fn too_little(&self) -> Option<String> {
        let too_little = || {
            format!(
                "{}: {:.0} % of its rates are missing: what is left of the others is no test of it",
                self.name,
                100.0 * (1.0 - self.covered)
            )
        };
        (self.covered < LEAST_COVERED).then(too_little)
    }
}

/// How many of the calibration's unit of rates one of the log's is, where a calibration can be taken off a log's axis at all.
pub(super) fn factor(own: &AxisCalibration, axis: &AxisFit, temperature_unit: TemperatureUnit) -> Result<f64, NoTest> {
    let other_unit = |found: String, expected: String| NoTest::Unit { axis: axis.name.clone(), found, expected };
    let logged = axis.calibration.rate_unit;
    let Some(factor) = logged.in_unit(own.rate_unit) else {
        return Err(other_unit(logged.to_string(), own.rate_unit.to_string()));
    };
    if axis.temperature_unit != temperature_unit {
        return Err(other_unit(axis.temperature_unit.name().to_owned(), temperature_unit.name().to_owned()));
    }
    let is_timed = axis.trace.iter().any(|point| point.time_s.is_finite());
    if own.fit.model.needs_time(Start::Unknown) && !is_timed {
        return Err(TimeFault::NoTime.into());
    }
    Ok(factor)
}

/// The points of a log, `factor` of the calibration's unit to one of its own, each less its bias.
fn corrected(trace: &[TracePoint], biases: &[f64], factor: f64) -> Vec<VerifiedPoint> {
    let correct = |(point, bias): (&TracePoint, &f64)| {
        let raw = factor * point.rate;
        VerifiedPoint { time_s: point.time_s, temperature: point.temperature, raw, corrected: raw - bias }
    };
    let points = trace.iter().zip(biases).map(correct);
    points.filter(|point| point.temperature.is_finite() && point.corrected.is_finite()).collect()
}
