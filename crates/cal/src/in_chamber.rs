//! A chamber's recording beside the log of a board that lay in it: where its air was, and what sensor and rate were at the end
//! of each soak.

mod clocks;
mod told;

use std::time::SystemTime;

use serde::Serialize;
use thiserror::Error;
use zerorate_fit::trace::TracePoint;

use crate::condition::mean;
use crate::log_fit::{AxisFit, LogFit};
use crate::recording::utc::rfc3339;
use crate::recording::{ChamberMoment, ChamberRecording, Phase};
use crate::units::{TemperatureUnit, WrittenRate};

/// The end of a soak: its last quarter, when the board has come to the air's temperature if it ever does.
const END_OF_SOAK: f64 = 0.25;

/// Why a recording cannot be joined to a log.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum JoinError {
    /// Several logs were fitted.
    #[error("a chamber's recording is joined to one log: fit each by itself to see the air beside it")]
    Several,
    /// Nobody knows when the log was begun.
    #[error(
        "{log} does not say at what time of day it was begun (an autopilot knows it by satellite), so the chamber's recording cannot be joined by time: give the log's second at which the recording began (`chamber_at`)"
    )]
    NoTimeOfDay {
        /// The log.
        log: String,
    },
    /// The log has no times.
    #[error("{log} has no times, so the chamber's recording cannot be joined to it")]
    NoTimes {
        /// The log.
        log: String,
    },
    /// The two are not of the same time.
    #[error(
        "the chamber's recording is not of the log's time: it goes from {from_s:.0} to {to_s:.0} s on the log's own clock, and the log from 0 to {log_s:.0} s; {why}"
    )]
    Apart {
        /// Where the recording begins.
        from_s: f64,
        /// Where it ends.
        to_s: f64,
        /// Where the log ends.
        log_s: f64,
        /// What that rests on, and what to do.
        why: &'static str,
    },
    /// The temperatures are no degrees.
    #[error("the log's temperatures are counts and not degrees: the chamber's air cannot stand beside them")]
    NotCelsius,
}

/// Why two recordings are apart, where the time of day joins them.
const BY_CLOCKS: &str = "both are told by the time of day, so see whether a clock was wrong, or give the log's second at which the recording \
     began (`chamber_at`)";
/// And where somebody has said how.
const AS_GIVEN: &str = "so it was said (`chamber_at`): give the log's second at which the recording began";

/// A soak within a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Soak {
    /// When it began, seconds of the log.
    pub from_s: f64,
    /// When it ended.
    pub to_s: f64,
    /// Where the chamber was sent, degrees C.
    pub set_c: f64,
    /// The air's mean over the last quarter, degrees C; NaN where nobody knows it.
    pub air_c: f64,
    /// What the axes showed meanwhile, by name; none of an axis with no group there.
    pub axes: Vec<SoakedAxis>,
}

/// An axis at the end of a soak.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SoakedAxis {
    /// The axis.
    pub name: String,
    /// The sensor's own temperature, degrees C.
    pub sensor_c: f64,
    /// The rate less the fitted curve, in the axis's unit, in-sample.
    pub residual: f64,
    /// Groups in it.
    pub groups: usize,
}

/// A chamber's recording beside a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InChamber {
    /// The recording's name.
    pub recording: String,
    /// When it was begun.
    pub started: String,
    /// The log's second at which it was begun.
    pub begins_s: f64,
    /// Between which seconds after the air the sensor begins to answer, beside its lag; below 0 it is before it, and a clock is wrong. `None`
    /// where the data do not tell.
    pub answers_after_s: Option<[f64; 2]>,
    /// By which clocks the two were joined, whether the data speak against it, and against either thermometer: a sentence each.
    pub told: Vec<String>,
    /// The air: seconds of the log, degrees C.
    #[serde(skip)]
    pub air: Vec<(f64, f64)>,
    /// The soaks that have groups of the log at their end.
    pub soaks: Vec<Soak>,
}

/// What a table of the soaks says, in a sentence.
pub const SOAKS_TOLD: &str = "Means over the last quarter of each soak: of the chamber's air, of the sensor's own temperature, and of \
     the rate less the fitted curve, in-sample. A residual well above the noise says that the curve does not hold there at \
     rest: the ramp was too fast for the sensor, or the drift has a history.";

/// A row of a table of the soaks: an axis at the end of one.
#[derive(Debug, Clone, PartialEq)]
pub struct SoakRow<'a> {
    /// The soak.
    pub soak: &'a Soak,
    /// The axis.
    pub axis: &'a SoakedAxis,
    /// Its residual, in [`unit`](Self::unit).
    pub residual: f64,
    /// The unit for people.
    pub unit: &'static str,
}

impl InChamber {
    /// The soaks as rows of a table, rates in the unit that people are told them in.
    #[must_use]
    pub fn rows<'a>(&'a self, fit: &LogFit, asked: Option<WrittenRate>) -> Vec<SoakRow<'a>> {
        let row = |soak: &'a Soak, axis: &'a SoakedAxis| {
            let unit = fit.axes.iter().find(|of| of.name == axis.name)?.calibration.rate_unit;
            let scale = fit.scale(unit, asked);
            Some(SoakRow { soak, axis, residual: scale.of_rate(axis.residual), unit: scale.unit() })
        };
        self.soaks.iter().flat_map(|soak| soak.axes.iter().filter_map(move |axis| row(soak, axis))).collect()
    }

    /// Joins a recording to a log's fit: by the time of day that both tell, or by the log's second at which it was begun.
    ///
    /// # Errors
    /// [`JoinError`].
    pub fn join(
        fit: &LogFit,
        name: &str,
        recording: &ChamberRecording,
        begins_s: Option<f64>,
    ) -> Result<Self, JoinError> {
        let [log] = &fit.sources[..] else { return Err(JoinError::Several) };
        if fit.axes.iter().any(|axis| axis.temperature_unit != TemperatureUnit::C) {
            return Err(JoinError::NotCelsius);
        }
        let times = fit.axes.iter().flat_map(|axis| &axis.trace).map(|point| point.time_s);
        let log_s = times.fold(f64::NAN, f64::max);
        if log_s.is_nan() && !fit.axes.is_empty() {
            return Err(JoinError::NoTimes { log: log.name.clone() });
        }
        let (begins_s, why) = match (begins_s, log.started) {
            (Some(begins_s), _) => (begins_s, AS_GIVEN),
            (None, Some(started)) => (seconds(started, recording.info.started.into()), BY_CLOCKS),
            (None, None) => return Err(JoinError::NoTimeOfDay { log: log.name.clone() }),
        };
        let to_s = begins_s + recording.moments.last().map_or(0.0, |moment| moment.t_s);
        if !(begins_s < log_s && to_s > 0.0) {
            return Err(JoinError::Apart { from_s: begins_s, to_s, log_s, why });
        }
        let soaks = recording.moments.chunk_by(|a, b| (a.step, a.phase) == (b.step, b.phase));
        let soaks = soaks.filter(|moments| moments[0].phase == Phase::Soak);
        let soaks: Vec<Soak> = soaks.filter_map(|moments| soak(fit, moments, begins_s)).collect();
        let air: Vec<(f64, f64)> =
            recording.moments.iter().map(|moment| (begins_s + moment.t_s, moment.air_c)).collect();
        let trace = fit.axes.first().map(|axis| &axis.trace[..]).unwrap_or_default();
        let sensor: Vec<(f64, f64)> = trace.iter().map(|point| (point.time_s, point.temperature)).collect();
        let answers_after_s = clocks::answers(&air, &sensor);
        let mut told = vec![told::joined(why == BY_CLOCKS, begins_s, answers_after_s)];
        told.extend(told::colder_than_its_air(&air, &soaks));
        Ok(Self {
            recording: name.to_owned(),
            started: rfc3339(recording.info.started),
            begins_s,
            answers_after_s,
            told,
            air,
            soaks,
        })
    }
}

/// From one time of day to another, below 0 where the second is the earlier.
fn seconds(from: SystemTime, to: SystemTime) -> f64 {
    to.duration_since(from).map_or_else(|error| -error.duration().as_secs_f64(), |time| time.as_secs_f64())
}

/// A soak, if the log has groups at its end.
fn soak(fit: &LogFit, moments: &[ChamberMoment], begins_s: f64) -> Option<Soak> {
    let (from_s, to_s) = (begins_s + moments[0].t_s, begins_s + moments[moments.len() - 1].t_s);
    let end = (to_s - END_OF_SOAK * (to_s - from_s))..=to_s;
    let axes: Vec<SoakedAxis> = fit.axes.iter().filter_map(|axis| soaked(axis, |time| end.contains(&time))).collect();
    let air = moments.iter().filter(|moment| end.contains(&(begins_s + moment.t_s)) && !moment.air_c.is_nan());
    let air_c = mean(air.map(|moment| moment.air_c));
    (!axes.is_empty()).then_some(Soak { from_s, to_s, set_c: moments[0].set_c, air_c, axes })
}

fn soaked(axis: &AxisFit, is_there: impl Fn(f64) -> bool) -> Option<SoakedAxis> {
    let there: Vec<&TracePoint> = axis.trace.iter().filter(|point| is_there(point.time_s)).collect();
    let of = |value: fn(&TracePoint) -> f64| mean(there.iter().map(|point| value(point)));
    (!there.is_empty()).then(|| SoakedAxis {
        name: axis.name.clone(),
        sensor_c: of(|point| point.temperature),
        residual: of(|point| point.residual),
        groups: there.len(),
    })
}

#[cfg(test)]
mod tests;
