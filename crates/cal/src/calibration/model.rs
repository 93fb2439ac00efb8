//! What a calibration holds beside the static curve: history, drift in time, prediction band, the static cubic.

use serde::{Deserialize, Serialize};
use zerorate_core::drift::{Drift, History, Memory, Term};

use super::form::DriftForm;
use crate::log_fit::Spread;

/// A slow drift in time of the recording, which is no part of what is deployed: it adds `per_second (t - origin_s)`.
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

/// A point of the prediction band.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BandPoint {
    /// In the calibration's temperature unit.
    pub temperature: f64,
    /// 95 of 100 group means at this temperature are expected within this of the prediction, rate units.
    pub half_width: f64,
}

/// The best static cubic: what an autopilot that knows no more than a cubic can hold. Of the same conditioned data and by
/// the same robust loss as the model chosen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "StaticCubicForm", into = "StaticCubicForm")]
pub struct StaticCubic {
    /// A polynomial of order 3 (of a lower order where the data do not settle three), and its valid range.
    pub drift: Drift,
    /// Residual of the fit of everything.
    pub in_sample: Spread,
    /// Residual of contiguous stretches, each predicted by the fit of the others; `None` where they do not settle it.
    pub held_out: Option<Spread>,
}

/// How well the model chosen predicts data that played no part in choosing or fitting it: contiguous stretches, for
/// each of which the choice was made anew from the others. Root mean squares over groups, rate units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// How many stretches.
    pub stretches: u64,
    /// Within the recording: with its drift in time.
    pub in_recording: Option<f64>,
    /// As deployed, the history known from the recording's start: no drift in time; the mean of the stretch's first
    /// groups (about 30 s) is taken off, as a zero at boot does.
    pub deployed_warm: Option<f64>,
    /// The same, the history starting from nothing at the stretch's first group.
    pub deployed_cold: Option<f64>,
    /// The static cubic within the recording.
    pub cubic_in_recording: Option<f64>,
    /// The static cubic as deployed; it has no history, so warm and cold are one.
    pub cubic_deployed: Option<f64>,
}

#[derive(Clone, Serialize, Deserialize)]
pub(super) struct StaticCubicForm {
    drift: DriftForm,
    in_sample: Spread,
    held_out: Option<Spread>,
}

impl From<StaticCubic> for StaticCubicForm {
    fn from(cubic: StaticCubic) -> Self {
        Self { drift: DriftForm::from(&cubic.drift), in_sample: cubic.in_sample, held_out: cubic.held_out }
    }
}

impl TryFrom<StaticCubicForm> for StaticCubic {
    type Error = String;
    fn try_from(form: StaticCubicForm) -> Result<Self, String> {
        Ok(Self { drift: form.drift.checked()?, in_sample: form.in_sample, held_out: form.held_out })
    }
}

/// A history as it stands in the file.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct HistoryForm {
    /// The static part once the history is known, with the axis's valid range.
    curve: DriftForm,
    terms: Vec<TermForm>,
}

/// One term: `weight (m - T)`.
#[derive(Clone, Serialize, Deserialize)]
struct TermForm {
    #[serde(flatten)]
    memory: MemoryForm,
    /// Rate units per unit of temperature.
    weight: f64,
    /// How much of the history rests on it; all terms together 1.
    share: f64,
}

#[derive(Clone, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
enum MemoryForm {
    /// Temperature units.
    Play { half_width: f64 },
    /// Seconds.
    Lag { time_constant_s: f64 },
}

impl HistoryForm {
    pub(super) fn of(history: &History, drift: &Drift) -> Self {
        let curve = Drift { shape: history.curve().clone(), valid: drift.valid };
        let term = |term: &Term| TermForm {
            memory: match term.memory {
                Memory::Play { half_width } => MemoryForm::Play { half_width },
                Memory::Lag { time_constant_s } => MemoryForm::Lag { time_constant_s },
            },
            weight: term.weight,
            share: term.share,
        };
        Self { curve: DriftForm::from(&curve), terms: history.terms().iter().map(term).collect() }
    }

    pub(super) fn checked(&self) -> Result<History, String> {
        let term = |form: &TermForm| Term {
            memory: match form.memory {
                MemoryForm::Play { half_width } => Memory::Play { half_width },
                MemoryForm::Lag { time_constant_s } => Memory::Lag { time_constant_s },
            },
            weight: form.weight,
            share: form.share,
        };
        let terms: Vec<Term> = self.terms.iter().map(term).collect();
        History::new(self.curve.checked()?.shape, &terms).ok_or_else(|| {
            "a history has 1 to 6 terms, each with a half_width or time_constant_s above zero and a finite weight, and \
             shares that add up to 1"
                .to_owned()
        })
    }
}
