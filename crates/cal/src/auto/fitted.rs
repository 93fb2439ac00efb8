//! From a solution over columns to the model that is deployed.

use zerorate_core::drift::{Drift, History, HistoryState, Polynomial, Shape, Table, Term, evaluate_dynamic};

use super::Series;
use super::candidates::Spec;
use super::features::{Features, powers_of_legendre};
use crate::calibration::TimeDrift;
use crate::choose::Model;

/// A model that was fitted, as it is deployed, and the recording's drift in time beside it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fitted {
    /// The static curve; with a history, the one for when that is not known.
    pub drift: Drift,
    pub history: Option<History>,
    pub time_drift: Option<TimeDrift>,
}

/// The curve of some coefficients over the columns of its model, `mean` added.
pub(super) fn curve(features: &Features, model: Model, beta: &[f64], mean: f64) -> Option<Shape> {
    if let Model::Table(_) = model {
        let knots: Vec<f64> = beta.iter().map(|knot| knot + mean).collect();
        return Table::new(features.scale, &knots).map(Shape::Table);
    }
    let mut powers = powers_of_legendre(beta);
    powers[0] += mean;
    Polynomial::new(features.scale, &powers).map(Shape::Polynomial)
}

/// The history of a solution; `None` where all its weights are nothing.
pub(super) fn history(features: &Features, spec: &Spec, beta: &[f64], mean: f64) -> Option<History> {
    let weights = &beta[spec.curve()..spec.curve() + spec.memories.len()];
    // The size of a term's effect: its weight times what `m - T` comes to, the columns being of the order of one.
    let total: f64 = weights.iter().map(|weight| weight.abs()).sum();
    let terms: Vec<Term> = spec
        .memories
        .iter()
        .zip(weights)
        .map(|(&place, weight)| {
            let memory = features.memories[place];
            Term { memory, weight: weight / features.amplitude(memory), share: weight.abs() / total }
        })
        .collect();
    History::new(curve(features, spec.model, &beta[..spec.curve()], mean)?, &terms)
}

/// The drift in time of a solution.
pub(super) fn time_drift(features: &Features, spec: &Spec, beta: &[f64]) -> Option<TimeDrift> {
    let (first, last) = features.time.filter(|_| spec.terms.time)?;
    Some(TimeDrift { per_second: 2.0 * beta.last()? / (last - first), origin_s: f64::midpoint(first, last) })
}

impl Fitted {
    /// Predictions of all groups of the recording that the model was fitted to, with its drift in time: its history is
    /// believed from the start, for the fit took that start as it is taken here.
    pub(super) fn in_recording(&self, series: &Series<'_>) -> Vec<f64> {
        let mut state = HistoryState::default();
        let mut before = f64::NAN;
        (series.time_s.iter().zip(series.temperature).enumerate())
            .map(|(group, (&time, &temperature))| {
                if series.begins(group) {
                    state = HistoryState::default();
                }
                let own = match &self.history {
                    Some(history) if temperature.is_finite() => {
                        history.advance(&self.drift, &mut state, temperature, time - before);
                        history.evaluate_as_known(&state)
                    }
                    _ => self.drift.evaluate(temperature).0,
                };
                before = time;
                own + self.time_drift.map_or(0.0, |drift| drift.at(time))
            })
            .collect()
    }

    /// Predictions of some successive groups as deployed: the history starts at the first of them.
    pub(super) fn deployed(&self, series: &Series<'_>, groups: std::ops::Range<usize>) -> Vec<f64> {
        let mut state = HistoryState::default();
        let mut before = f64::NAN;
        groups
            .map(|group| {
                let (time, temperature) = (series.time_s[group], series.temperature[group]);
                if series.begins(group) {
                    state = HistoryState::default();
                }
                if let Some(history) = &self.history {
                    history.advance(&self.drift, &mut state, temperature, time - before);
                }
                before = time;
                evaluate_dynamic(&self.drift, self.history.as_ref(), &state, temperature).0
            })
            .collect()
    }
}
