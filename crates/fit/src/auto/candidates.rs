//! The models that are compared.

use std::fmt;

use zerorate_core::drift::{MAX_ORDER, Memory};

use super::features::Features;
use super::gram::Penalised;
use crate::model::Model;

/// Strengths of the shrinkage, shares of the data's own weight, a factor of ten apart: at the lowest it does nothing on 400
/// groups but settle what they leave open; at the highest a term needs ten times its own weight of evidence.
const SHRINKAGES: [f64; 6] = [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1];

/// Strengths of a table's smoothing; its knots are drawn to a straight line, not to zero.
const SMOOTHINGS: [f64; 3] = [1e-4, 1e-2, 1.0];

/// The shrinkage on what is not shrunk: rounding's size.
const NONE: f64 = 1e-12;

/// What a model has beside its curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Terms {
    /// How many plays.
    plays: usize,
    /// How many lags.
    lags: usize,
    /// A slow drift in time.
    pub time: bool,
}

/// A model to be fitted: its columns and how they are drawn to zero.
///
/// One strength is for all that is not the static curve, history and time alike, in columns of the order of one: what is
/// shrunk alike is the size of their effects.
#[derive(Debug, Clone)]
pub(super) struct Spec {
    pub model: Model,
    pub terms: Terms,
    pub shrinkage: f64,
    /// The columns of [`Features`]: the curve's, the memories', time.
    pub columns: Vec<usize>,
    pub shrinkages: Vec<f64>,
    /// Which memories, by their places.
    pub memories: Vec<usize>,
    pub smooth: f64,
}

impl Spec {
    pub(super) fn new(features: &Features, model: Model, memories: &[usize], time: bool, shrinkage: f64) -> Self {
        let curve: Vec<usize> = match model {
            Model::Table(intervals) => (0..=intervals).map(Features::knot).collect(),
            Model::Poly(order) => (0..=order).map(Features::power).collect(),
            Model::Auto => (0..=MAX_ORDER).map(Features::power).collect(),
        };
        let terms = Terms {
            plays: memories.iter().filter(|&&m| matches!(features.memories[m], Memory::Play { .. })).count(),
            lags: memories.iter().filter(|&&m| matches!(features.memories[m], Memory::Lag { .. })).count(),
            time,
        };
        let shrunk = memories.len() + usize::from(time);
        let shrinkages = std::iter::repeat_n(NONE, curve.len()).chain(std::iter::repeat_n(shrinkage, shrunk)).collect();
        let columns = curve.into_iter().chain(memories.iter().map(|&place| features.memory(place)));
        let columns = columns.chain(time.then(|| features.time_column())).collect();
        Self { model, terms, shrinkage, columns, shrinkages, memories: memories.to_vec(), smooth: 0.0 }
    }

    /// The number of coefficients that a polynomial of the curve's freedom has, and of the terms: what "simpler" means.
    pub(super) fn size(&self) -> usize {
        self.columns.len()
    }

    /// The number of the curve's columns.
    pub(super) fn curve(&self) -> usize {
        self.columns.len() - self.memories.len() - usize::from(self.terms.time)
    }

    pub(super) fn penalised(&self) -> Penalised<'_> {
        let knots = if matches!(self.model, Model::Table(_)) { self.curve() } else { 0 };
        Penalised { columns: &self.columns, shrinkage: &self.shrinkages, knots, smooth: self.smooth }
    }

    /// Whether it is the static curve of an order and nothing else.
    pub(super) fn is_static(&self, order: usize) -> bool {
        self.model == Model::Poly(order) && self.memories.is_empty() && !self.terms.time
    }
}

impl fmt::Display for Spec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.model)?;
        let Terms { plays, lags, time } = self.terms;
        for (count, what) in [(plays, "play"), (lags, "lag")] {
            match count {
                0 => {}
                1 => write!(f, " + {what}")?,
                _ => write!(f, " + {count} {what}s")?,
            }
        }
        if time { f.write_str(" + time") } else { Ok(()) }
    }
}

/// What may be chosen among.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Among {
    /// Of `auto`: polynomials of order 1 to 5 and a smoothed table; each alone, with all plays, with all lags, with both;
    /// each with and without a drift in time.
    All,
    /// One curve alone.
    Curve(Model),
    /// One curve with a drift in time, whose strength is what is chosen.
    CurveInTime(Model),
}

/// All candidates, simplest first.
pub(super) fn candidates(features: &Features, among: Among) -> Vec<Spec> {
    match among {
        Among::All => all(features),
        Among::Curve(model) => {
            let mut spec = Spec::new(features, model, &[], false, 0.0);
            // A knot without data near it lies on the line through its neighbours; one with data is moved by nothing.
            spec.smooth = 1e-9;
            vec![spec]
        }
        Among::CurveInTime(model) => {
            let with = |&shrinkage: &f64| Spec::new(features, model, &[], true, shrinkage);
            SHRINKAGES.iter().rev().map(with).collect()
        }
    }
}

fn all(features: &Features) -> Vec<Spec> {
    let plays: Vec<usize> = places(features, |memory| matches!(memory, Memory::Play { .. }));
    let lags: Vec<usize> = places(features, |memory| matches!(memory, Memory::Lag { .. }));
    let both: Vec<usize> = plays.iter().chain(&lags).copied().collect();
    let mut sets = vec![Vec::new()];
    sets.extend([plays.clone(), lags.clone()].into_iter().filter(|set| !set.is_empty()));
    if !plays.is_empty() && !lags.is_empty() {
        sets.push(both);
    }
    let times: &[bool] = if features.time.is_some() { &[false, true] } else { &[false] };
    let mut specs = Vec::new();
    for set in &sets {
        for &time in times {
            let shrinkages: &[f64] = if set.is_empty() && !time { &[0.0] } else { &SHRINKAGES };
            for &shrinkage in shrinkages {
                specs
                    .extend((1..=MAX_ORDER).map(|order| Spec::new(features, Model::Poly(order), set, time, shrinkage)));
            }
            for smooth in SMOOTHINGS {
                let shrinkage = if set.is_empty() && !time { 0.0 } else { TABLE_SHRINKAGE };
                let table = Spec::new(features, Model::Table(features.intervals), set, time, shrinkage);
                specs.push(Spec { smooth, ..table });
            }
        }
    }
    // The larger shrinkage is the simpler of two of one size.
    specs.sort_by(|a, b| {
        a.size().cmp(&b.size()).then(b.shrinkage.total_cmp(&a.shrinkage)).then(b.smooth.total_cmp(&a.smooth))
    });
    specs
}

/// The shrinkage of the terms beside a table, whose smoothing is what is chosen: the middle one.
const TABLE_SHRINKAGE: f64 = 1e-3;

fn places(features: &Features, wanted: impl Fn(Memory) -> bool) -> Vec<usize> {
    (0..features.memories.len()).filter(|&place| wanted(features.memories[place])).collect()
}
