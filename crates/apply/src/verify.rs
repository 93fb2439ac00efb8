//! What a calibration leaves on a log that it has not seen, against pass limits.
//!
//! The log is conditioned as for a fit: start-up, spikes and times at which the unit was moved are left out, and what is
//! left is averaged over 10 s, however long or short the log is. A gyro's zero of another day is another constant, so sizes
//! are about the mean and the mean is told beside them; what a device has left that takes its zero at the start is told,
//! too.
//!
//! The log may be of another kind than the one that was fitted: axes are matched by [`Verified`]'s rules, rad/s and degrees
//! a second are converted.

mod axis;
mod limits;
mod rows;
mod told;

use serde::Serialize;
use thiserror::Error;
use zerorate_fit::model::Model;
use zerorate_fit::predict::DriftModel;

use crate::apply::TimeFault;
pub use axis::{VerifiedAxis, VerifiedPoint};
pub use limits::{Limit, LimitError, Limits};

use zerorate_cal::calibration::{Calibration, Origin, sha256};
use zerorate_cal::condition::GROUP_S;
use zerorate_cal::fit::fit;
use zerorate_cal::log::{LogFault, SensorChoice};
use zerorate_cal::log_fit::{AxisFit, FitOptions, LogFit, LogFitError, are_alike};
pub use zerorate_cal::matching::Unmatched;
use zerorate_cal::matching::{Known, calibrated, places, renamed};
use zerorate_cal::quality::{Reason, ReasonKind, Verdict};
use zerorate_cal::source::{Faulty, Source};
use zerorate_cal::table::{Columns, Table};
use zerorate_cal::units::{TemperatureUnit, WrittenRate};
use zerorate_fit::trace::period_s;

/// How a log is to be verified.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct VerifyOptions {
    /// Which column is which, in a table.
    pub columns: Columns,
    /// The sensors to verify, of the calibration and of the log; `None` for all.
    pub sensor: Option<SensorChoice>,
    /// What may be left.
    pub limits: Limits,
    /// Take a log that the calibration was fitted on all the same.
    pub in_sample: bool,
    /// The unit in which sentences tell rates, where they can be told in it; `None` for the calibration's own, or a
    /// thousandth of it.
    pub told_in: Option<WrittenRate>,
}

/// How a log did. An axis of the log is a calibration's where it is of the same part by its number, else where it has the
/// same name, else where no other measures the same in the same direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verified {
    /// The log, as it was given.
    pub log: String,
    /// Rejected where it did not pass; a warning where there is a reason.
    pub verdict: Verdict,
    /// Whether every axis of the calibration is there, has most of its rates and meets its limits; `None` where no limit was
    /// given and none is missing: then nothing was tested.
    pub passed: Option<bool>,
    /// Whether the calibration was fitted on this very log, on rows of it or on a copy: what is left is then in-sample,
    /// and no test.
    pub in_sample: bool,
    /// The temperature's unit.
    pub temperature_unit: TemperatureUnit,
    /// The time from one average to the next, seconds, as a rule; `None` where the log has no times.
    pub averaged_over_s: Option<f64>,
    /// The same of the averages whose figures the calibration's fit told; `None` where its log had no times, and of a board.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fit_averaged_over_s: Option<f64>,
    /// The axes that the calibration and the log share.
    pub axes: Vec<VerifiedAxis>,
    /// The calibration's axes of which the log has nothing that can be used, a sentence each.
    pub missing: Vec<String>,
    /// What was found wrong with the log or with what the calibration does to it, and what to know.
    pub reasons: Vec<Reason>,
    /// What was guessed, a sentence each.
    pub notes: Vec<String>,
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
    /// The log is the one that the calibration was fitted on, by its hash, by the hashes of runs of its rows or by its noise.
    #[error(
        "the calibration was fitted on this very log, on rows of it or on a copy, so it is no test of it: give a log of another run, or allow it (`in_sample`) to look all the same"
    )]
    InSample,
    /// The log is no good for this.
    #[error("{reasons}")]
    Unusable {
        /// Why.
        reasons: String,
    },
    /// Its axes are not the calibration's.
    #[error(transparent)]
    Unmatched(#[from] Unmatched),
    /// A model needs what it does not tell.
    #[error(transparent)]
    Time(#[from] TimeFault),
    /// The units differ, and are of different quantities.
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

/// The columns of a log as far as its calibration tells them: where rates were not named and the log is a table that has
/// all of the calibration's axes, those, in the calibration's unit where no name says one. Of other columns that unit is
/// likely, and a guess that is told.
#[must_use]
pub fn known_columns(log: &Source, calibration: &Calibration, asked: Columns) -> Columns {
    let own_unit = calibration.axes.values().find_map(|axis| WrittenRate::of(axis.rate_unit));
    let names: Vec<String> = calibration.axes.keys().cloned().collect();
    let has_all = || Table::open(log).is_ok_and(|table| names.iter().all(|name| table.names().contains(name)));
    match asked.rates.is_empty() && has_all() {
        true => Columns { rates: names, else_rate_unit: own_unit, ..asked },
        false => Columns { likely_rate_unit: own_unit, ..asked },
    }
}

/// Applies a calibration to a log and holds what is left against limits.
///
/// # Errors
/// [`VerifyError`].
pub fn verify(log: &Source, calibration: &Calibration, options: &VerifyOptions) -> Result<Verified, VerifyError> {
    let no_test = |fault: NoTest| VerifyError::from(log.faulty(fault));
    let refused =
        |in_sample: bool| if in_sample && !options.in_sample { Err(no_test(NoTest::InSample)) } else { Ok(()) };
    let sha256 = sha256(log).map_err(|error| LogFitError::from(log.faulty::<LogFault>(error)))?;
    let is_same_file = calibration.sources.iter().any(|source| source.sha256 == sha256);
    refused(is_same_file)?;
    let fit = conditioned(log, options)?;
    if fit.axes.is_empty() {
        let mut all = fit.verdicts.iter().flat_map(|axis| &axis.judgement.reasons);
        let reasons = match all.any(|reason| reason.kind == ReasonKind::TooFewGroups) {
            true => format!("it has too few averages over {GROUP_S:.0} s to tell anything: give a longer log"),
            false => fit.reasons().collect::<Vec<_>>().join("; "),
        };
        return Err(no_test(NoTest::Unusable { reasons }));
    }
    let calibrated = calibrated(calibration, options.sensor);
    let logged: Vec<Known<'_>> = fit.axes.iter().map(known).collect();
    let places = places(&calibrated, &logged).map_err(|error| no_test(error.into()))?;
    let has_its_rows = |source: &Origin| fit.sources.iter().any(|log| log.rows.are_among(&source.rows));
    let in_sample = is_same_file || calibration.sources.iter().any(has_its_rows);
    // A unit that has lost an axis fails, by whatever log.
    refused(in_sample && places.iter().all(Option::is_some))?;
    let matched = calibrated.iter().zip(&places).filter_map(|(own, place)| Some((own.name, &fit.axes[(*place)?])));
    let matched: Vec<(&str, &AxisFit)> = matched.collect();
    let own = |name: &str| &calibration.axes[name];
    let factor = |(name, axis): &(&str, &AxisFit)| axis::factor(own(name), axis, calibration.temperature_unit);
    let factors: Vec<f64> = matched.iter().map(factor).collect::<Result<_, _>>().map_err(no_test)?;
    let models: Vec<(&AxisFit, &DriftModel)> =
        matched.iter().map(|(name, axis)| (*axis, &own(name).fit.model)).collect();
    let biases = rows::mean_biases(log, &options.columns, &models).map_err(LogFitError::from)?;
    let mut axes = Vec::new();
    let mut notes = fit.notes.clone();
    for (((name, axis), factor), biases) in matched.iter().zip(factors).zip(&biases) {
        notes.extend(renamed(&axis.name, name));
        let mut verified = axis::verify(name, own(name), axis, factor, biases);
        verified.missed = options.limits.missed(&verified, options.told_in)?;
        verified.missed.extend(verified.too_little());
        axes.push(verified);
    }
    notes.extend(unknown(&fit.axes, &places, &calibrated));
    notes.extend(told::little_seen(&axes, calibration.temperature_unit));
    let absent = calibrated.iter().zip(&places).filter(|(_, place)| place.is_none());
    let missing: Vec<String> = absent.map(|(own, _)| missing(own, &fit)).collect();
    let is_within = missing.is_empty() && axes.iter().all(|axis| axis.missed.is_empty());
    let passed = (!options.limits.is_empty() || !is_within).then_some(is_within);
    let averaged_over_s = period_s(&fit.axes[0].trace);
    // Of an older file nobody knows.
    let alike = averaged_over_s.zip(calibration.averaged_over_s).is_some_and(|(own, fits)| are_alike(own, fits));
    notes.extend(told::few_in_the_zero(averaged_over_s));
    let reasons = told::reasons(&fit, &axes, calibration.temperature_unit, options.told_in, alike);
    let verdict = match (passed, reasons.is_empty()) {
        (Some(false), _) => Verdict::Rejected,
        (_, false) => Verdict::Warning,
        (_, true) => Verdict::Good,
    };
    Ok(Verified {
        log: log.name().to_owned(),
        verdict,
        passed,
        in_sample,
        temperature_unit: calibration.temperature_unit,
        averaged_over_s,
        fit_averaged_over_s: calibration.averaged_over_s,
        axes,
        missing,
        reasons,
        notes,
    })
}

/// The log's groups. The curve of this fit is not used: the simplest will do.
fn conditioned(log: &Source, options: &VerifyOptions) -> Result<LogFit, LogFitError> {
    let options = FitOptions {
        columns: options.columns.clone(),
        model: Model::Poly(1),
        allow_narrow: true,
        // Limits are held against averages of one length, whatever the log's.
        group_s: Some(GROUP_S),
        sensor: options.sensor,
        keep_steps: true,
        ..FitOptions::default()
    };
    fit(std::slice::from_ref(log), &options)
}

/// The axes of a log that the calibration does not have, of the quantities that it has: nothing was said of them.
fn unknown(logged: &[AxisFit], places: &[Option<usize>], calibrated: &[Known<'_>]) -> Option<String> {
    let alike = |axis: &AxisFit| {
        calibrated.iter().any(|own| own.unit.is_of_acceleration() == axis.calibration.rate_unit.is_of_acceleration())
    };
    let others = logged.iter().enumerate().filter(|(place, axis)| !places.contains(&Some(*place)) && alike(axis));
    let names: Vec<&str> = others.map(|(_, axis)| axis.name.as_str()).collect();
    (!names.is_empty()).then(|| format!("not in the calibration, and not verified: {}", names.join(", ")))
}

/// Why there is nothing of an axis.
fn missing(own: &Known<'_>, fit: &LogFit) -> String {
    let verdict =
        fit.verdicts.iter().find(|axis| axis.name == own.name).filter(|axis| !axis.judgement.reasons.is_empty());
    if let Some(verdict) = verdict {
        format!("{}: nothing that can be used: {}", own.name, verdict.why())
    } else if own.unit.is_of_acceleration()
        && !fit.axes.iter().any(|axis| axis.calibration.rate_unit.is_of_acceleration())
    {
        format!("{}: the log has no accelerometer; to verify the gyros alone give `sensor` gyro", own.name)
    } else {
        format!("{}: the log has no such axis", own.name)
    }
}

/// An axis of a log that was fitted.
fn known(axis: &AxisFit) -> Known<'_> {
    Known { name: &axis.name, sensor: axis.calibration.sensor, unit: axis.calibration.rate_unit }
}

#[cfg(test)]
mod tests;
