//! What a unit is judged on: counts and extremes, as any engine that adds up can give them.

use super::RampMeans;
use crate::choose::STRETCHES;

/// The groups of an eighth of a ramp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StretchSurvey {
    /// Groups.
    pub groups: u64,
    /// The least and the greatest mean temperature, counts.
    pub temperature: (f64, f64),
    /// The least and the greatest mean reading, counts.
    pub reading: (f64, f64),
}

impl StretchSurvey {
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
    /// The eighths of that span, in order.
    pub stretches: [StretchSurvey; STRETCHES],
    /// Groups at an end of the converter.
    pub saturated: u64,
    /// The lowest and the highest tap, where there is a group.
    pub taps: Option<(u16, u16)>,
}

impl AxisSurvey {
    /// The survey of some groups.
    #[must_use]
    pub fn of(means: &RampMeans) -> Self {
        let number = |group: Option<&u32>| group.copied().map_or(0, u64::from);
        let span = (number(means.groups.first()), number(means.groups.last()));
        let stretches = [StretchSurvey::EMPTY; STRETCHES];
        let mut survey = Self { span, stretches, saturated: means.saturated, taps: means.taps };
        for ((group, temperature), reading) in means.groups.iter().zip(&means.temperatures).zip(&means.readings) {
            survey.stretches[stretch_of(u64::from(*group), span)].push(*temperature, *reading);
        }
        survey
    }

    /// All groups.
    #[must_use]
    pub fn groups(&self) -> u64 {
        self.stretches.iter().map(|stretch| stretch.groups).sum()
    }

    /// The least and the greatest mean temperature, counts.
    #[must_use]
    pub fn temperature(&self) -> (f64, f64) {
        self.stretches.iter().fold(StretchSurvey::EMPTY.temperature, |(min, max), stretch| {
            (min.min(stretch.temperature.0), max.max(stretch.temperature.1))
        })
    }
}

/// The eighth of a span of groups that a group lies in, 0 to 7.
#[must_use]
// The quotient is below 8.
#[allow(clippy::cast_possible_truncation)]
pub fn stretch_of(group: u64, (first, last): (u64, u64)) -> usize {
    let stretches = STRETCHES as u64;
    let length = last.saturating_sub(first) + 1;
    (group.saturating_sub(first) * stretches / length).min(stretches - 1) as usize
}

/// What the residuals of one axis add up to, counts to the powers named.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ResidualSurvey {
    /// How many.
    pub count: u64,
    /// The sum of squares.
    pub squares: f64,
    /// The sum of fourth powers.
    pub fourths: f64,
    /// The largest, without sign.
    pub largest: f64,
}

impl ResidualSurvey {
    /// Takes in a residual.
    pub fn push(&mut self, residual: f64) {
        self.count += 1;
        self.squares += residual.powi(2);
        self.fourths += residual.powi(4);
        self.largest = self.largest.max(residual.abs());
    }

    /// Root mean square.
    #[must_use]
    pub fn rms(&self) -> f64 {
        (self.squares / self.count as f64).sqrt()
    }

    /// The mean fourth power over the squared mean square: 3 for noise, less for a curve that does not fit, n/m where m
    /// of n residuals dwarf the others.
    #[must_use]
    pub fn kurtosis(&self) -> f64 {
        self.fourths * self.count as f64 / self.squares.powi(2)
    }
}
