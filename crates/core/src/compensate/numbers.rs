//! A law as a record stores it: integers alone, as the host has rounded them and the device is to run them.
//!
//! These are raw: every value of every field can be read from a record. [`AxisLaw`](super::AxisLaw) is what is left of
//! them once they are checked.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use super::edges::EdgeTable;
use crate::drift::{MAX_HISTORY_TERMS, MAX_KNOTS, MAX_ORDER};
use crate::trim::MAX_TAP_OFFSETS;
use crate::units::Taps;

/// Fractional bits of a memory in codes.
pub(super) const CODE_BITS: u32 = 14;
/// Fractional bits of a weight in counts per code: up to 127 counts a code, in steps that make 0.004 count over all codes.
pub(super) const WEIGHT_BITS: u32 = 24;

/// The law of one axis.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct LawNumbers {
    /// Zero-rate output at the middle tap over temperature code, from the reading aimed at: `V - V0`. So the middle of a
    /// converter of 16 bits is as near as that of one of 14.
    pub drift: DriftNumbers,
    /// What the taps do.
    pub trim: TrimNumbers,
    /// Dead band, Q16 taps.
    pub dead_band: i32,
    /// The circuit's low-pass.
    pub low_pass: LowPassNumbers,
    /// The law solved for its edges; `None` where it has none and only the digital mode can run.
    pub edges: Option<EdgeTable>,
    /// What the drift remembers of its temperatures; `None` where it is a function of temperature alone.
    pub history: Option<HistoryNumbers>,
}

/// A curve and the codes that it was calibrated over; outside them it is held at the nearer end.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DriftNumbers {
    /// The first code of the calibrated range.
    pub first: u16,
    /// The last, above the first.
    pub last: u16,
    /// The curve between them.
    pub curve: CurveNumbers,
}

/// The shape of a curve.
#[allow(clippy::large_enum_variant)] // no heap here to box the table in
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum CurveNumbers {
    /// Order 1 to 5.
    Polynomial(PolynomialNumbers),
    /// Straight pieces of one length.
    Table(TableNumbers),
}

/// `sum of c_k u^k` with `u = (code - middle) / 2^b`: `2^b` the smallest power of two that holds the range, the middle
/// rounded up, so that `-1/2 <= u < 1/2`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PolynomialNumbers {
    /// Fractional bits of the coefficients, 6 to 16.
    pub fraction_bits: u8,
    /// Constant first, counts.
    pub coefficients: Vec<i32, { MAX_ORDER + 1 }>,
}

/// Readings at evenly spaced temperatures.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TableNumbers {
    /// Where the first code of the range lies, in pieces from the first knot, Q32.
    pub start: i64,
    /// Pieces a code, Q32.
    pub pieces_per_code: u32,
    /// 2 to 33 readings, coldest first, Q16 counts.
    pub knots: Vec<i32, MAX_KNOTS>,
}

/// What each tap adds to the reading at the middle tap.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct TrimNumbers {
    /// The first tap measured; without a measurement the middle tap.
    pub first: Taps,
    /// The effects from the first tap on, rising, Q16 counts; empty without a measurement.
    pub effects: Vec<i32, MAX_TAP_OFFSETS>,
    /// On from either end of what was measured, Q16 counts a tap, above zero.
    pub per_tap: i32,
    /// The intercept of a line: what is wanted of the taps beside `V0 - V`, Q16 counts. Nothing where they were measured.
    pub intercept: i32,
}

/// The circuit's low-pass at the board's sampling, parts of a step, Q32.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct LowPassNumbers {
    /// Still missing at the first sample after the wiper was written.
    pub missing_at_first: u32,
    /// Still missing one sample later.
    pub missing_per_sample: u32,
}

impl LowPassNumbers {
    /// No low-pass: a step is there at once.
    pub const NONE: Self = Self { missing_at_first: 0, missing_per_sample: 0 };
}

/// A history: its own curve over the drift's range, and its terms.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct HistoryNumbers {
    /// The static part once the history is known.
    pub curve: CurveNumbers,
    /// What moves the code that it is taken at, and is added to it.
    pub terms: Vec<TermNumbers, MAX_HISTORY_TERMS>,
}

/// One term: `weight (m - T)`, and the curve taken at `T + behind (m - T)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct TermNumbers {
    /// What m is.
    pub memory: MemoryNumbers,
    /// Counts a code, with 24 fractional bits.
    pub weight: i32,
    /// Codes a code, with 24 fractional bits.
    pub behind: i32,
    /// How much of the history rests on this term, Q16, at most 1.
    pub share: u32,
}

/// What a term remembers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum MemoryNumbers {
    /// A play.
    Play {
        /// Codes, Q14, above zero.
        half_width: i32,
    },
    /// A lag of time constant tau, for the group period p.
    Lag {
        /// `exp(-p / tau)`, Q32, at most 1.
        kept: u64,
        /// `p / tau`, Q32, above zero.
        part: u64,
    },
}
