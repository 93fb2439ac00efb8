//! The fit of a recording of the bench: the group means of its ramps, axis by axis.
//!
//! What speaks against a unit is judged on counts and extremes ([`AxisSurvey`], [`ResidualSurvey`]), not on the groups
//! themselves, so that a query engine that only gives sums comes to the same verdicts with the same words.

mod judge;
mod survey;

use std::path::Path;

use zerorate_core::units::Axis;

pub use judge::{judge_residual, judge_survey};
pub use survey::{AxisSurvey, ResidualSurvey, StretchSurvey, stretch_of};

use crate::drift_fit::{DriftFit, DriftFitError, fit_drift};
use crate::fit::FitError;
use crate::log_fit::{AxisFit, AxisVerdict, FitOptions, LogFit};
use crate::quality::{Judgement, Reason, ReasonKind, TemperatureUnit, Verdict};
use crate::recording::{GroupRow, Recording};
use crate::table::RateUnit;

/// The phases whose groups a drift is fitted to.
pub const RAMPS: [&str; 2] = ["heating", "cooling"];

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
}

/// The bit of a recording's flags that says that the reading was at an end of the converter.
pub const SATURATED: u16 = 4;

impl RampMeans {
    /// The ramps of an axis of a recording.
    #[must_use]
    pub fn of(recording: &Recording, axis: Axis) -> Self {
        let mut means = Self::default();
        let ramps = |row: &&GroupRow| row.axis == axis && RAMPS.contains(&row.phase.as_str());
        for row in recording.rows.iter().filter(ramps) {
            let (temperature, reading) = (row.sums.mean_temperature().0, row.sums.mean_zro().0);
            means.push(row.group, row.t_s, (temperature, reading), row.sums.n, row.flags);
        }
        means
    }

    /// Takes in one group: its number, its time in seconds, its mean temperature and reading in counts, its samples and
    /// the device's flags. A group without samples is left out.
    pub fn push(&mut self, group: u32, t_s: f64, (temperature, reading): (f64, f64), samples: u32, flags: u16) {
        if samples == 0 {
            return;
        }
        self.groups.push(group);
        self.times_s.push(t_s);
        self.temperatures.push(temperature);
        self.readings.push(reading);
        self.samples += u64::from(samples);
        self.saturated += u64::from(flags & SATURATED != 0);
    }
}

/// Fits the ramps of a recording, each axis by itself. Group means are fitted as they are, each counted once: they are
/// what conditioning makes of a log.
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
    let fit = if own.rejected() { None } else { fit(name, means, options, &mut own) };
    if let Some(fit) = &fit {
        judge_residual(&mut own, name, &residual_survey(means, fit));
    }
    let verdict = own.verdict;
    for reason in own.reasons {
        judgement.add_as(verdict_of(&reason, options.allow_narrow), reason);
    }
    fit.map(|fit| AxisFit { verdict, ..fit })
}

fn fit(name: &str, means: &RampMeans, options: &FitOptions, judgement: &mut Judgement) -> Option<AxisFit> {
    match fit_drift(&means.temperatures, &means.readings, options.model) {
        Ok(fit) => Some(axis_fit(name, means, fit)),
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

fn axis_fit(name: &str, means: &RampMeans, fit: DriftFit) -> AxisFit {
    let mut trace = fit.trace;
    // A place among the groups becomes its time.
    for point in &mut trace {
        point.time_s = at(&means.times_s, point.time_s);
    }
    AxisFit {
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
    }
}

/// The value at a place that may lie between two of them.
// A place lies within the values.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn at(values: &[f64], place: f64) -> f64 {
    let (below, part) = (place.floor(), place.fract());
    let value = |place: f64| values.get(place as usize).or(values.last()).copied().unwrap_or(f64::NAN);
    value(below) + part * (value(below + 1.0) - value(below))
}

fn residual_survey(means: &RampMeans, fit: &AxisFit) -> ResidualSurvey {
    let mut survey = ResidualSurvey::default();
    for (temperature, reading) in means.temperatures.iter().zip(&means.readings) {
        survey.push(reading - fit.drift.evaluate(*temperature).0);
    }
    survey
}

#[cfg(test)]
mod tests;
