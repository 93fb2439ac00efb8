//! The one way in which a drift model predicts: for a corrected log, a verification, a fit's own residuals, a bench.

use std::fmt;

use serde::{Deserialize, Serialize};
use zerorate_core::drift::{Coverage, Drift, History, HistoryState, Knowledge, Memory, evaluate_dynamic};

use crate::model::Model;

/// A model of the drift.
#[derive(Debug, Clone, PartialEq)]
pub struct DriftModel {
    /// Zero-rate output over temperature, with its range. With a history, the curve for when that is not known.
    pub drift: Drift,
    /// What the drift remembers of its temperatures; `None` where it is a function of temperature alone.
    pub history: Option<History>,
    /// The drift in time of the recording that the model was fitted to; no part of what is deployed.
    pub time_drift: Option<TimeDrift>,
}

/// A recording's own drift in time: it adds `per_second (t - origin_s)`, and what follows switching on. At its origin, the
/// middle of a log, it adds nothing: the curve's level is that of the middle, which a next run has too if it drifts alike.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TimeDrift {
    /// Rate units per second.
    pub per_second: f64,
    /// The time at which it adds nothing, seconds from the recording's first row; of several logs from each one's.
    pub origin_s: f64,
    /// What dies away after each log's start; none in most.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub start_up: Vec<StartUp>,
    /// From when on after a log's start that was seen, seconds: before, it is taken for what it was then.
    #[serde(default)]
    pub seen_from_s: f64,
}

/// A part of a rate that dies away after switching on: `rate exp(-t / time_constant_s)`, t from the log's start, less what it
/// is at the origin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StartUp {
    /// At the log's start, rate units.
    pub rate: f64,
    /// Seconds.
    pub time_constant_s: f64,
}

impl TimeDrift {
    /// A straight one.
    #[must_use]
    pub fn straight(per_second: f64, origin_s: f64) -> Self {
        Self { per_second, origin_s, start_up: Vec::new(), seen_from_s: 0.0 }
    }

    /// What it adds at a time in seconds from the recording's first row, `since_start_s` after the log's start: rate units.
    #[must_use]
    pub fn at(&self, time_s: f64, since_start_s: f64) -> f64 {
        let left = |since_s: f64, part: &StartUp| part.rate * libm::exp(-since_s / part.time_constant_s);
        let since_s = since_start_s.max(self.seen_from_s);
        let dying = |part: &StartUp| left(since_s, part) - left(self.origin_s, part);
        self.per_second * (time_s - self.origin_s) + self.start_up.iter().map(dying).sum::<f64>()
    }
}

impl fmt::Display for DriftModel {
    /// The model with the terms beside its curve: `poly:3`, or `table:32 + 3 plays + start-up`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let curve = self.history.as_ref().map_or(&self.drift.shape, History::curve);
        write!(f, "{}", Model::of_shape(curve))?;
        let memories = || self.history.iter().flat_map(|history| history.terms()).map(|term| term.memory);
        let plays = memories().filter(|memory| matches!(memory, Memory::Play { .. })).count();
        for (count, what) in [(plays, "play"), (memories().count() - plays, "lag")] {
            match count {
                0 => {}
                1 => write!(f, " + {what}")?,
                _ => write!(f, " + {count} {what}s")?,
            }
        }
        let Some(TimeDrift { per_second, start_up, .. }) = &self.time_drift else { return Ok(()) };
        if *per_second != 0.0 {
            f.write_str(" + time")?;
        }
        if start_up.is_empty() { Ok(()) } else { f.write_str(" + start-up") }
    }
}

impl DriftModel {
    /// A curve alone.
    #[must_use]
    pub fn of_curve(drift: Drift) -> Self {
        Self { drift, history: None, time_drift: None }
    }

    /// What a device would take off at each of some times, seconds, and temperatures, had it been switched on with the
    /// first: rate units.
    #[must_use]
    pub fn biases(&self, rows: impl IntoIterator<Item = (f64, f64)>) -> Vec<f64> {
        let mut predictor = Predictor::new(self, Start::Unknown);
        rows.into_iter().map(|(time_s, temperature)| predictor.predict(time_s, temperature).bias).collect()
    }

    /// Whether predictions need the time of each row.
    #[must_use]
    pub fn needs_time(&self, start: Start) -> bool {
        let lags = |history: &History| history.terms().iter().any(|term| matches!(term.memory, Memory::Lag { .. }));
        self.history.as_ref().is_some_and(lags) || (start == Start::OwnRecording && self.time_drift.is_some())
    }
}

/// What is known where predictions begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// Nothing of the temperatures before: a device that is switched on. The history starts with the first row, and is
    /// uncertain until enough was seen; a drift in time is left out.
    Unknown,
    /// It is the very recording that the model was fitted to: the history is believed from its start, for the fit took
    /// that start as it is taken here, and its drift in time is added.
    OwnRecording,
}

/// What a model says of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// Rate units; NaN without a temperature.
    pub bias: f64,
    /// Where the temperature lies against the curve's range.
    pub coverage: Coverage,
    /// Whether the history that it rests on was seen.
    pub knowledge: Knowledge,
}

/// A model at work, row after row.
#[derive(Debug, Clone)]
pub struct Predictor<'a> {
    model: &'a DriftModel,
    start: Start,
    state: HistoryState,
    began_s: f64,
    before_s: f64,
}

impl<'a> Predictor<'a> {
    /// Before the first row.
    #[must_use]
    pub fn new(model: &'a DriftModel, start: Start) -> Self {
        Self { model, start, state: HistoryState::default(), began_s: f64::NAN, before_s: f64::NAN }
    }

    /// The prediction of the next row. A row without a time (NaN) leaves its step to the next one; one without a
    /// temperature is waited through.
    pub fn predict(&mut self, time_s: f64, temperature: f64) -> Prediction {
        let DriftModel { drift, history, time_drift } = self.model;
        if let Some(history) = history {
            history.advance(drift, &mut self.state, temperature, time_s - self.before_s);
        }
        if time_s.is_finite() {
            self.before_s = time_s;
            self.began_s = if self.began_s.is_nan() { time_s } else { self.began_s };
        }
        let (bias, coverage, knowledge) = evaluate_dynamic(drift, history.as_ref(), &self.state, temperature);
        if self.start == Start::Unknown {
            return Prediction { bias, coverage, knowledge };
        }
        let bias = bias + time_drift.as_ref().map_or(0.0, |drift| drift.at(time_s, time_s - self.began_s));
        Prediction { bias, coverage, knowledge: Knowledge::Known }
    }
}
