//! The one way in which a drift model predicts: for a corrected log, a verification, a fit's own residuals, a bench.

use serde::{Deserialize, Serialize};
use zerorate_core::drift::{Coverage, Drift, History, HistoryState, Knowledge, Memory, evaluate_dynamic};

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

/// A slow drift in time of a recording: it adds `per_second (t - origin_s)`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TimeDrift {
    /// Rate units per second.
    pub per_second: f64,
    /// The time at which it adds nothing, seconds from the recording's first row.
    pub origin_s: f64,
}

impl TimeDrift {
    /// What it adds at a time in seconds from the recording's first row, rate units.
    #[must_use]
    pub fn at(&self, time_s: f64) -> f64 {
        self.per_second * (time_s - self.origin_s)
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
    /// Nothing of the temperatures before: a device that is switched on. The history starts with the first row, and leans
    /// on the curve until it is known; a drift in time is left out.
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
    before_s: f64,
}

impl<'a> Predictor<'a> {
    /// Before the first row.
    #[must_use]
    pub fn new(model: &'a DriftModel, start: Start) -> Self {
        Self { model, start, state: HistoryState::default(), before_s: f64::NAN }
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
        }
        let (bias, coverage, knowledge) = evaluate_dynamic(drift, history.as_ref(), &self.state, temperature);
        if self.start == Start::Unknown {
            return Prediction { bias, coverage, knowledge };
        }
        let known = match history {
            Some(history) if !temperature.is_nan() => history.evaluate_as_known(&self.state),
            _ => bias,
        };
        let bias = known + time_drift.map_or(0.0, |drift| drift.at(time_s));
        Prediction { bias, coverage, knowledge: Knowledge::Known }
    }
}
