//! The fit of a recording of the bench: the group means of its ramps, axis by axis.
//!
//! What speaks against a unit is judged on counts and extremes ([`AxisSurvey`], [`ResidualSurvey`]), not on the groups
//! themselves, so that a query engine that only gives sums comes to the same verdicts with the same words.

mod judge;
mod survey;

use std::path::Path;

use zerorate_core::drift::{MAX_ORDER, Scale, Shape};
use zerorate_core::units::Axis;

pub use judge::{judge_residual, judge_survey};
pub use survey::{AxisSurvey, ResidualSurvey, StretchSurvey, stretch_of};

use crate::auto::{self, Series};
use crate::choose::Model;
use crate::drift_fit::{DriftFitError, fit_drift, span};
use crate::fit::{Basis, Fit, FitError};
use crate::log_fit::{AxisFit, AxisVerdict, FitOptions, LogFit, TracePoint, trace};
use crate::quality::{Judgement, Reason, ReasonKind, TemperatureUnit, Verdict};
use crate::recording::{GroupRow, Recording};
use crate::table::RateUnit;

/// The phases whose groups a drift is fitted to.
pub const RAMPS: [&str; 2] = ["heating", "cooling"];

/// The bit of a recording's flags that says that the reading was at an end of the converter.
pub const SATURATED: u16 = 4;

/// The order of the polynomial whose residuals are searched for wild groups.
pub const JUDGED_ORDER: usize = MAX_ORDER;

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
    /// The device's flags.
    pub flags: u16,
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
            flags: row.flags,
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
        let ramps = |row: &&GroupRow| row.axis == axis && RAMPS.contains(&row.phase.as_str());
        for row in recording.rows.iter().filter(ramps) {
            means.push(&RampGroup::from(row));
        }
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
        self.saturated += u64::from(group.flags & SATURATED != 0);
        let (lowest, highest) = self.taps.unwrap_or((group.tap, group.tap));
        self.taps = Some((lowest.min(group.tap), highest.max(group.tap)));
    }
}

/// Fits the ramps of a recording, each axis by itself. Group means are fitted as they are: they are what conditioning
/// makes of a log. `auto` chooses among all models, history included, and believes wild groups less; a model asked for is
/// fitted by ordinary least squares, each group counted once.
#[must_use]
pub fn fit_recording(recording: &Recording, path: &Path, options: &FitOptions) -> LogFit {
    let mut fit = LogFit {
        source: path.display().to_string(),
        sources: vec![path.to_owned()],
        autopilot: None,
        judgement: Judgement::default(),
        verdicts: Vec::new(),
        notes: Vec::new(),
        axes: Vec::new(),
        stretches: Vec::new(),
        steps: Vec::new(),
    };
    let expected = recording.info.ramp_groups();
    for axis in Axis::BOTH {
        let means = RampMeans::of(recording, axis);
        let mut judgement = Judgement::default();
        fit.axes.extend(fit_axis(axis.name(), &means, expected, options, &mut judgement));
        for reason in &judgement.reasons {
            fit.judgement.add_as(verdict_of(reason, options.allow_narrow), reason.clone());
        }
        fit.verdicts.push(AxisVerdict { name: axis.name().to_owned(), judgement });
    }
    // A board is calibrated as a whole or not at all.
    if fit.judgement.rejected() {
        fit.axes.clear();
    }
    fit
}

/// What a reason makes of a unit.
#[must_use]
pub fn verdict_of(reason: &Reason, allow_narrow: bool) -> Verdict {
    match reason.kind {
        ReasonKind::NarrowSpan if allow_narrow => Verdict::Warning,
        kind => kind.verdict(),
    }
}

/// Judges and fits the ramps of one axis. `expected` is the number of groups that the set-up gives a ramp. An axis that
/// is rejected for its groups is not fitted; one that is rejected for its residual is, so that it can be looked at.
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
        judge_residual(&mut own, name, residuals);
    }
    let verdict = own.verdict;
    for reason in own.reasons {
        judgement.add_as(verdict_of(&reason, options.allow_narrow), reason);
    }
    fitted.map(|(fit, _)| AxisFit { verdict, ..fit })
}

fn fit(
    name: &str,
    means: &RampMeans,
    options: &FitOptions,
    judgement: &mut Judgement,
) -> Option<(AxisFit, ResidualSurvey)> {
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

/// The fit by `auto`: robust, its order and terms chosen by held-out error, with a history where the recording holds both
/// directions of the ramp.
fn fit_chosen(name: &str, means: &RampMeans) -> Result<(AxisFit, ResidualSurvey), DriftFitError> {
    let (_, measured) = span(&means.temperatures, &means.readings, Model::Auto)?;
    let groups = means.readings.len();
    let (weight, log) = (vec![1.0; groups], vec![0; groups]);
    let series = Series {
        time_s: &means.times_s,
        temperature: &means.temperatures,
        rate: &means.readings,
        weight: &weight,
        log: &log,
        drifts_in_time: false,
    };
    let mut auto = auto::fit(&series, measured, Model::Auto)?;
    // The chamber has gone as far as the unit is to be believed.
    auto.drift.valid = measured;
    let mut survey = ResidualSurvey::default();
    auto.residuals.iter().for_each(|residual| survey.push(*residual));
    let trace = trace_of(means, &auto.residuals);
    let units = (RateUnit::Counts, TemperatureUnit::Counts);
    Ok((AxisFit { samples_used: means.samples, ..AxisFit::of_auto(name, units, auto, trace) }, survey))
}

/// The fit of the model asked for: ordinary least squares.
fn fit_asked(name: &str, means: &RampMeans, model: Model) -> Result<(AxisFit, ResidualSurvey), DriftFitError> {
    let fit = fit_drift(&means.temperatures, &means.readings, model)?;
    let judged = if let Model::Poly(_) = model { judged_curve(means, fit.choice.solution.scale) } else { None };
    let judged = judged.as_ref().unwrap_or(&fit.drift.shape);
    let mut survey = ResidualSurvey::default();
    for (temperature, reading) in means.temperatures.iter().zip(&means.readings) {
        survey.push(reading - judged.evaluate(*temperature));
    }
    let groups = means.temperatures.iter().zip(&means.readings);
    let left: Vec<f64> = groups.map(|(t, reading)| reading - fit.drift.shape.evaluate(*t)).collect();
    let trace = trace_of(means, &left);
    let axis = AxisFit {
        name: name.to_owned(),
        sensor: None,
        verdict: Verdict::Good,
        rate_unit: RateUnit::Counts,
        temperature_unit: TemperatureUnit::Counts,
        reference_temperature: None,
        drift: fit.drift,
        history: None,
        time_drift: None,
        static_cubic: None,
        band: Vec::new(),
        nested: None,
        choice: fit.choice,
        in_sample: fit.in_sample,
        held_out: fit.held_out,
        samples_used: means.samples,
        samples_rejected: Vec::new(),
        trace,
    };
    Ok((axis, survey))
}

/// The polynomial of [`JUDGED_ORDER`]; `None` where the groups do not settle it.
fn judged_curve(means: &RampMeans, scale: Scale) -> Option<Shape> {
    let mut fit = Fit::new(scale, Basis::Powers(JUDGED_ORDER), 1);
    for (temperature, reading) in means.temperatures.iter().zip(&means.readings) {
        fit.push(*temperature, &[*reading]);
    }
    fit.finish().ok()?.first()?.shape()
}

/// The ramps for figures, with what a fit leaves of each group.
fn trace_of(means: &RampMeans, residuals: &[f64]) -> Vec<TracePoint> {
    trace(residuals.iter().enumerate().map(|(group, residual)| TracePoint {
        time_s: means.times_s[group],
        temperature: means.temperatures[group],
        rate: means.readings[group],
        residual: *residual,
    }))
}

#[cfg(test)]
mod tests;
