//! What a unit is judged on: counts and extremes, as any engine that adds up can give them.

use std::collections::BTreeSet;

use zerorate_fit::folds::{FOLDS, fold_of_row};

use super::RampMeans;

/// The groups of a fold of a ramp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FoldSurvey {
    /// Groups.
    pub groups: u64,
    /// The least and the greatest mean temperature, counts.
    pub temperature: (f64, f64),
    /// The least and the greatest mean reading, counts.
    pub reading: (f64, f64),
}

impl FoldSurvey {
    /// Without groups.
    pub const EMPTY: Self = Self {
        groups: 0,
        temperature: (f64::INFINITY, f64::NEG_INFINITY),
        reading: (f64::INFINITY, f64::NEG_INFINITY),
    };

    /// Takes in a group: its mean temperature and reading, counts.
    pub fn push(&mut self, temperature: f64, reading: f64) {
        self.groups += 1;
        self.temperature = (self.temperature.0.min(temperature), self.temperature.1.max(temperature));
        self.reading = (self.reading.0.min(reading), self.reading.1.max(reading));
    }
}

/// What the ramps of one axis have to offer.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisSurvey {
    /// The first and the last group's number.
    pub span: (u64, u64),
    /// Groups whose number another has as well.
    pub repeated: u64,
    /// The folds of that span, in order.
    pub folds: [FoldSurvey; FOLDS],
    /// Groups at an end of the converter.
    pub saturated: u64,
    /// The lowest and the highest tap, where there is a group.
    pub taps: Option<(u16, u16)>,
}

impl AxisSurvey {
    /// The survey of some groups.
    #[must_use]
    pub fn of(means: &RampMeans) -> Self {
        let numbers: BTreeSet<u32> = means.groups.iter().copied().collect();
        let number = |group: Option<&u32>| group.copied().map_or(0, u64::from);
        let span = (number(numbers.first()), number(numbers.last()));
        let repeated = (means.groups.len() - numbers.len()) as u64;
        let folds = [FoldSurvey::EMPTY; FOLDS];
        let mut survey = Self { span, repeated, folds, saturated: means.saturated, taps: means.taps };
        for ((group, temperature), reading) in means.groups.iter().zip(&means.temperatures).zip(&means.readings) {
            survey.folds[fold_of(u64::from(*group), span)].push(*temperature, *reading);
        }
        survey
    }

    /// All groups.
    #[must_use]
    pub fn groups(&self) -> u64 {
        self.folds.iter().map(|fold| fold.groups).sum()
    }

    /// The least and the greatest mean temperature, counts.
    #[must_use]
    pub fn temperature(&self) -> (f64, f64) {
        self.folds.iter().fold(FoldSurvey::EMPTY.temperature, |(min, max), fold| {
            (min.min(fold.temperature.0), max.max(fold.temperature.1))
        })
    }
}

/// The fold of a span of groups that a group lies in, 0 to 7.
#[must_use]
pub fn fold_of(group: u64, (first, last): (u64, u64)) -> usize {
    fold_of_row(group.saturating_sub(first), last.saturating_sub(first) + 1)
}
