//! Why a law is refused: by the host that composes it, or by the device that would run it.

use super::interval::MAX_INTERVALS;
use crate::group::CODES_PER_COUNT;
use crate::units::TemperatureCode;

/// Why a law cannot be run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LawRefused {
    /// Its numbers do not fit the fixed-point form.
    Unrepresentable(Unrepresentable),
    /// Its table of edges is not to be believed.
    Edges(EdgeError),
    /// Its stored numbers make no law.
    Senseless(Part),
}

/// A part of a law's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The drift: no range, no curve, or sums that do not fit.
    Drift,
    /// The trim: effects that do not rise, or taps that the part does not have.
    Trim,
    /// The dead band: below zero, or more than a tap.
    DeadBand,
    /// The history: its curve, or a term that remembers nothing.
    History,
}

impl core::fmt::Display for LawRefused {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Unrepresentable(reason) => reason.fmt(f),
            Self::Edges(reason) => reason.fmt(f),
            Self::Senseless(part) => write!(f, "the stored numbers of the {part} make no law: compose it again"),
        }
    }
}

impl core::fmt::Display for Part {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Drift => "drift",
            Self::Trim => "trim",
            Self::DeadBand => "dead band",
            Self::History => "history",
        })
    }
}

impl core::error::Error for LawRefused {}

impl From<Unrepresentable> for LawRefused {
    fn from(reason: Unrepresentable) -> Self {
        Self::Unrepresentable(reason)
    }
}

/// A drift whose numbers do not fit the fixed-point form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unrepresentable {
    /// The readings, or the coefficients between them, are beyond the fixed-point range.
    TooLarge,
    /// The calibrated range is narrower than the table's pieces can be told apart in.
    TooNarrow,
    /// The integers would be off by more than half a count somewhere in the calibrated range.
    TooCoarse,
}

impl core::fmt::Display for Unrepresentable {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::TooLarge => {
                "the drift model's numbers are beyond the device's fixed-point range: refit with a lower order"
            }
            Self::TooNarrow => {
                "the calibrated range is too narrow for the table: refit over a wider span or with fewer pieces"
            }
            Self::TooCoarse => {
                "the device's integers are off the drift model by more than half a count: refit with a lower order"
            }
        })
    }
}

impl core::error::Error for Unrepresentable {}

/// Why a law cannot be a table of edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EdgeError {
    /// At this code the law asks for a position (in taps) that the part does not have.
    OutOfTaps {
        /// The temperature code.
        code: TemperatureCode,
        /// The position asked for, taps; the part has 0 to 1023.
        position: f64,
    },
    /// The drift crosses more taps than the table holds.
    TooManyIntervals {
        /// The code at which the table was full.
        code: TemperatureCode,
    },
    /// The stored table does not say what the stored law says at this code.
    Disagrees {
        /// The temperature code.
        code: TemperatureCode,
    },
    /// The stored table is not in order: empty, not starting at code 0, not ascending, or holding less than itself.
    Malformed {
        /// The interval that is wrong.
        index: usize,
    },
}

impl core::fmt::Display for EdgeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::OutOfTaps { code, position } => write!(
                f,
                "at {} counts of temperature the law asks for tap {position:.1}; the part has 0 to 1023: the drift is larger than the trim can take",
                code.0 / CODES_PER_COUNT
            ),
            Self::TooManyIntervals { code } => write!(
                f,
                "the drift crosses more than {MAX_INTERVALS} taps (the table was full at {} counts of temperature): use mode digital, or a coarser trim",
                code.0 / CODES_PER_COUNT
            ),
            Self::Disagrees { code } => {
                write!(f, "the table of edges and the law disagree at temperature code {}", code.0)
            }
            Self::Malformed { index } => {
                write!(f, "the table of edges is out of order at interval {index}")
            }
        }
    }
}

impl core::error::Error for EdgeError {}
