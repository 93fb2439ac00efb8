//! The fit of a recording of the bench: the group means of its ramps, axis by axis.
//!
//! What speaks against a unit is judged on counts, extremes and how far groups are from those beside them.

mod judge;
mod neighbours;
mod survey;
mod unit;

use std::time::SystemTime;

use zerorate_core::drift::Shape;
use zerorate_core::units::Axis;
use zerorate_fit::auto;
use zerorate_fit::drift_fit::DriftFit;
use zerorate_fit::least_squares::FitError;
use zerorate_fit::model::Model;
use zerorate_fit::ramp::{DriftFitError, fit_drift, span};
use zerorate_fit::residual::Residuals;
use zerorate_fit::series::{NextRun, Series};

pub use judge::judge_survey;
pub use survey::{AxisSurvey, FoldSurvey, fold_of};
pub use unit::UnitFit;

use crate::calibration::AxisCalibration;
use crate::log_fit::{AxisFit, FitOptions, LogFit};
use crate::quality::{Judgement, Reason, ReasonKind, Verdict};
use crate::recording::{GroupRow, Recording, status};
use crate::source::Source;
use crate::units::{RateUnit, TemperatureUnit};
use zerorate_fit::trace::{self, TracePoint};

/// One axis of one group of a ramp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RampGroup {
    /// The group's number.
    pub group: u32,
    /// Seconds from the recording's first group.
    pub time_s: f64,
    /// Mean temperature, counts.
    pub temperature: f64,
    /// Mean zero-rate reading, counts.
    pub reading: f64,
    /// Samples in it.
    pub samples: u32,
    /// What the device said of it: bits of [`status`].
    pub status_bits: u16,
    /// The wiper's position, taps.
    pub tap: u16,
}

impl From<&GroupRow> for RampGroup {
    fn from(row: &GroupRow) -> Self {
        Self {
            group: row.group,
            time_s: row.t_s,
            temperature: row.sums.mean_temperature().0,
            reading: row.sums.mean_zro().0,
            samples: row.sums.n,
            status_bits: row.status_bits,
            tap: row.tap,
        }
    }
}

/// The groups of one axis's ramps, in the order in which they were taken; those without a sample are left out.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RampMeans {
    /// The groups' numbers.
    pub groups: Vec<u32>,
    /// Seconds from the recording's first group.
    pub times_s: Vec<f64>,
    /// Mean temperatures, counts.
    pub temperatures: Vec<f64>,
    /// Mean zero-rate readings, counts.
    pub readings: Vec<f64>,
    /// Samples in all of them.
    pub samples: u64,
    /// Groups at an end of the converter.
    pub saturated: u64,
    /// The lowest and the highest tap, where there is a group.
    pub taps: Option<(u16, u16)>,
}

impl RampMeans {
    /// The ramps of an axis of a recording.
    #[must_use]
    pub fn of(recording: &Recording, axis: Axis) -> Self {
        let mut means = Self::default();
        let ramps = |row: &&GroupRow| row.axis == axis && row.phase.is_ramp();
        let mut ramps: Vec<&GroupRow> = recording.rows.iter().filter(ramps).collect();
        // Nothing says that a file has them in order.
        ramps.sort_by_key(|row| row.group);
        ramps.into_iter().for_each(|row| means.push(&RampGroup::from(row)));
        means
    }

    /// Takes in one group; one without samples is left out.
    pub fn push(&mut self, group: &RampGroup) {
        if group.samples == 0 {
            return;
        }
        self.groups.push(group.group);
        self.times_s.push(group.time_s);
        self.temperatures.push(group.temperature);
        self.readings.push(group.reading);
        self.samples += u64::from(group.samples);
        self.saturated += u64::from(group.status_bits & status::SATURATED != 0);
        let (lowest, highest) = self.taps.unwrap_or((group.tap, group.tap));
        self.taps = Some((lowest.min(group.tap), highest.max(group.tap)));
    }
}

/// Fits the ramps of a recording, each axis by itself. Group means are fitted as they are: they are what conditioning
/// makes of a log. `auto` chooses among all models, history included, and believes outliers less; a model asked for is
/// fitted by ordinary least squares, each group counted once.
#[must_use]
pub fn fit_recording(recording: &Recording, source: &Source, options: &FitOptions) -> LogFit {
    let mut fit = LogFit::new(std::slice::from_ref(source));
    fit.sources[0].started = recording.info.started.map(SystemTime::from);
    if !recording.rows.iter().any(|row| row.phase.is_ramp()) {
        fit.judgement.add(Reason::new(ReasonKind::TooFewGroups, recording.without_a_ramp()));
        return fit;
    }
    let ramps = Axis::BOTH.map(|axis| RampMeans::of(recording, axis));
    let unit = UnitFit::of(&ramps, expected_groups(recording), options);
    (fit.judgement, fit.verdicts) = (unit.judgement, unit.verdicts);
    // A board is calibrated as a whole or not at all.
    if !fit.judgement.rejected() {
        fit.axes = unit.axes;
    }
    fit
}

/// The groups that the ramps of a recording are to have: those of the set-up, where the bench drove the chamber. A chamber that
/// it could not ask, whose air no row tells, goes at its own pace, and the ramp ends where that arrives: only a recording that
/// was not finished is held against the plan.
fn expected_groups(recording: &Recording) -> Option<u64> {
    let driven = recording.rows.iter().any(|row| row.chamber_c.is_finite());
    recording.info.ramp_groups().filter(|_| driven || recording.cut)
}

/// What a reason makes of a unit.
#[must_use]
pub fn verdict_of(reason: &Reason, allow_narrow: bool) -> Verdict {
    match reason.kind {
        ReasonKind::NarrowSpan if allow_narrow => Verdict::Warning,
        kind => kind.verdict(),
    }
}

/// Judges and fits the ramps of one axis, whose name each reason begins with. `expected` is the number of groups that the
/// set-up gives a ramp. An axis that is rejected for its groups is not fitted; one that is rejected for wild ones is, so that
/// it can be looked at.
pub fn fit_axis(
    name: &str,
    means: &RampMeans,
    expected: Option<u64>,
    options: &FitOptions,
    judgement: &mut Judgement,
) -> Option<AxisFit> {
    let mut own = Judgement::default();
    judge_survey(&mut own, name, &AxisSurvey::of(means), expected, options);
    let fitted = if own.rejected() { None } else { fit(name, means, options, &mut own) };
    if let Some((_, residuals)) = &fitted {
        judge::judge_distances(&mut own, name, &Residuals::of(neighbours::distances(residuals)));
    }
    let verdict = own.verdict;
    let named = format!("{name}: ");
    for reason in own.reasons {
        let text = if reason.text.starts_with(&named) { reason.text } else { named.clone() + &reason.text };
        let reason = Reason { text, ..reason };
        judgement.add_as(verdict_of(&reason, options.allow_narrow), reason);
    }
    fitted.map(|(fit, _)| AxisFit { verdict, ..fit })
}

fn fit(name: &str, means: &RampMeans, options: &FitOptions, judgement: &mut Judgement) -> Option<(AxisFit, Vec<f64>)> {
    let fitted = match options.model {
        Model::Auto => fit_chosen(name, means),
        model => fit_asked(name, means, model),
    };
    match fitted {
        Ok(fitted) => Some(fitted),
        Err(error) => {
            let kind = match &error {
                DriftFitError::Stuck { .. } => ReasonKind::StuckTemperature,
                DriftFitError::Fit(FitError::NotFinite) | DriftFitError::NotFinite { .. } => ReasonKind::NoFiniteRows,
                _ => ReasonKind::TooFewGroups,
            };
            judgement.add(Reason::new(kind, format!("{name}: {error}")));
            None
        }
    }
}

/// The fit by `auto`: robust, as strong as the data say, with a history where the recording holds both
/// directions of the ramp.
fn fit_chosen(name: &str, means: &RampMeans) -> Result<(AxisFit, Vec<f64>), DriftFitError> {
    let (_, measured) = span(&means.temperatures, &means.readings, Model::Auto)?;
    let groups = means.readings.len();
    let (weight, log) = (vec![1.0; groups], vec![0; groups]);
    let series = Series {
        time_s: &means.times_s,
        temperature: &means.temperatures,
        shown: &means.temperatures,
        rate: &means.readings,
        weight: &weight,
        log: &log,
        next: NextRun::Same,
    };
    let fitted = auto::fit(&series, measured, Model::Auto)?;
    Ok((of_fit(name, means, fitted.fit, &fitted.residuals), fitted.residuals))
}

/// The fit of the model asked for: ordinary least squares.
fn fit_asked(name: &str, means: &RampMeans, model: Model) -> Result<(AxisFit, Vec<f64>), DriftFitError> {
    let fit = fit_drift(&means.temperatures, &means.readings, model)?;
    let shape: &Shape = &fit.model.drift.shape;
    let groups = means.temperatures.iter().zip(&means.readings);
    let residuals: Vec<f64> = groups.map(|(temperature, reading)| reading - shape.evaluate(*temperature)).collect();
    Ok((of_fit(name, means, fit, &residuals), residuals))
}

/// The axis, with what its fit leaves of each group.
fn of_fit(name: &str, means: &RampMeans, fit: DriftFit, residuals: &[f64]) -> AxisFit {
    let mut calibration = AxisCalibration::of_fit(fit, RateUnit::Counts);
    calibration.fit.statistics.samples_used = means.samples;
    let point = |(group, residual): (usize, &f64)| TracePoint {
        log: 0,
        time_s: means.times_s[group],
        temperature: means.temperatures[group],
        rows: None,
        rate: means.readings[group],
        residual: *residual,
    };
    AxisFit {
        name: name.to_owned(),
        verdict: Verdict::Good,
        temperature_unit: TemperatureUnit::Counts,
        calibration,
        samples_rejected: Vec::new(),
        trace: trace::of_groups(residuals.iter().enumerate().map(point)),
    }
}

#[cfg(test)]
mod tests;
