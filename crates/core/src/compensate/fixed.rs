//! The drift in integers alone.
//!
//! A polynomial is written in `u = (code - middle) / 2^b`, where `2^b` is at least the calibrated range of codes, so that
//! `|u| <= 1/2` and `u` in Q32 is a subtraction and a shift. Horner's step is then one high-word multiply and one add.

use super::numbers::{CurveNumbers, DriftNumbers, PolynomialNumbers, TableNumbers};
use super::q16::Q16;
use crate::drift::{MAX_KNOTS, MAX_ORDER};
use crate::units::TemperatureCode;

/// Zero-rate output over temperature code in integers, checked: no step of it can wrap.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FixedDrift {
    /// The first and the last code of the calibrated range.
    range: (u16, u16),
    /// The code that the form counts from, and how many codes on from there it goes.
    first: u16,
    span: u16,
    form: Form,
}

#[allow(clippy::large_enum_variant)] // no heap here to box the table in
#[derive(Debug, Clone, PartialEq, Eq)]
enum Form {
    Polynomial(FixedPolynomial),
    Table(FixedTable),
}

/// Horner's rule in integers.
#[derive(Debug, Clone, PartialEq, Eq)]
struct FixedPolynomial {
    /// `u` at the first code of the range, and from code to code, Q32.
    first_u: i32,
    u_per_code: i32,
    /// From the coefficients' fractional bits to Q16: a power of two.
    to_q16: i32,
    /// Highest order first, as Horner takes them; zeros before a lower order's, so that there is no loop to count.
    coefficients: [i32; MAX_ORDER + 1],
}

/// Straight pieces in integers.
#[derive(Debug, Clone, PartialEq, Eq)]
struct FixedTable {
    /// Where the code that is counted from lies, in pieces from one piece before the first knot, Q32.
    start: u64,
    /// Pieces a code, in Q32.
    pieces_per_code: u32,
    /// First a level one, so that no place lies below all of them; then one from each knot on, from the last on level.
    pieces: [Piece; MAX_KNOTS + 1],
}

/// A straight piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Piece {
    /// The reading at its beginning, Q16.
    knot: i32,
    /// Twice the rise to its end, Q16, for a high-word multiply by half the way.
    twice_rise: i32,
}

impl FixedDrift {
    /// A drift by its numbers; `None` where they make no curve, or one whose sums would wrap.
    #[must_use]
    pub fn from_numbers(numbers: &DriftNumbers) -> Option<Self> {
        Self::over(numbers.first, numbers.last, &numbers.curve)
    }

    /// The same, of a curve over a range of codes.
    pub(super) fn over(first: u16, last: u16, curve: &CurveNumbers) -> Option<Self> {
        let span = last.checked_sub(first).filter(|&span| span > 0)?;
        let (form, passed) = match curve {
            CurveNumbers::Polynomial(numbers) => (Form::Polynomial(FixedPolynomial::new(numbers, span)?), 0),
            CurveNumbers::Table(numbers) => {
                let (table, passed) = FixedTable::new(numbers, span)?;
                (Form::Table(table), passed)
            }
        };
        Some(Self { range: (first, last), first: first + passed, span: span - passed, form })
    }

    /// The first and last code of the calibrated range.
    #[must_use]
    pub const fn range(&self) -> (TemperatureCode, TemperatureCode) {
        (TemperatureCode(self.range.0), TemperatureCode(self.range.1))
    }

    /// The zero-rate output at the middle tap, held at the nearer end outside the calibrated range.
    #[must_use]
    pub fn evaluate(&self, code: TemperatureCode) -> Q16 {
        self.evaluate_here(code)
    }

    /// The same, with no call.
    #[inline(always)]
    pub(super) fn evaluate_here(&self, code: TemperatureCode) -> Q16 {
        match &self.form {
            Form::Polynomial(polynomial) => polynomial.evaluate(self.places(code)),
            Form::Table(table) => table.evaluate(self.places(code)),
        }
    }

    /// Codes from the first that is counted from, held within the range.
    #[inline]
    fn places(&self, code: TemperatureCode) -> u16 {
        code.0.saturating_sub(self.first).min(self.span)
    }
}

impl FixedPolynomial {
    fn new(numbers: &PolynomialNumbers, span: u16) -> Option<Self> {
        let given = &numbers.coefficients;
        let bits = u32::from(numbers.fraction_bits);
        // Every partial sum of Horner's rule stays below the sum of the magnitudes.
        let magnitude: u64 = given.iter().map(|c| u64::from(c.unsigned_abs())).sum();
        if given.len() < 2 || !(6..=16).contains(&bits) || magnitude >= 1 << 30 {
            return None;
        }
        let mut coefficients = [0; MAX_ORDER + 1];
        for (slot, &c) in coefficients.iter_mut().rev().zip(given) {
            *slot = c;
        }
        let codes = u32::from(span) + 1;
        #[allow(clippy::cast_possible_wrap)] // one bit of 32, taken modulo 2^32
        let u_per_code = (1_u32 << (32 - codes.next_power_of_two().trailing_zeros())) as i32;
        #[allow(clippy::cast_possible_wrap)] // at most 2^15
        let first_u = ((codes / 2) as i32).wrapping_neg().wrapping_mul(u_per_code);
        let polynomial = Self { first_u, u_per_code, to_q16: 1 << (16 - bits), coefficients };
        // In Q16 it must fit as well, at every code.
        let fits = |places: u16| polynomial.sum(places).checked_mul(polynomial.to_q16).is_some();
        (0..=span).all(fits).then_some(polynomial)
    }

    /// The reading at so many codes after the range's first.
    #[inline(always)]
    fn evaluate(&self, places: u16) -> Q16 {
        Q16(self.sum(places).wrapping_mul(self.to_q16))
    }

    /// The same, in the coefficients' own steps.
    #[inline(always)]
    fn sum(&self, places: u16) -> i32 {
        // -1/2 to 1/2 over the range: what wraps on the way comes back.
        let u = i32::from(places).wrapping_mul(self.u_per_code).wrapping_add(self.first_u);
        let [c5, c4, c3, c2, c1, c0] = self.coefficients;
        let step = |sum: i32, c: i32| multiply_high(sum, u).wrapping_add(c);
        step(step(step(step(step(c5, c4), c3), c2), c1), c0)
    }
}

impl FixedTable {
    /// One piece, Q32.
    const PIECE: i64 = 1 << 32;
    /// A piece is more than a code, so the range begins fewer pieces before the first knot than there are codes; and as far
    /// behind the last one as anything need be.
    const STARTS: core::ops::RangeInclusive<i64> = -65_536 * Self::PIECE..=64 * Self::PIECE;

    /// The table, and how many codes of the range are passed over, because they lie more than a piece before the first
    /// knot: it is as level there as within that piece.
    fn new(numbers: &TableNumbers, span: u16) -> Option<(Self, u16)> {
        let (knots, step) = (&numbers.knots, i64::from(numbers.pieces_per_code));
        if knots.len() < 2 || step == 0 || !Self::STARTS.contains(&numbers.start) {
            return None;
        }
        let (first, last) = (*knots.first()?, *knots.last()?);
        let mut pieces = [Piece { knot: last, twice_rise: 0 }; MAX_KNOTS + 1];
        pieces[0].knot = first;
        for (piece, pair) in pieces[1..].iter_mut().zip(knots.windows(2)) {
            *piece = Piece { knot: pair[0], twice_rise: pair[1].checked_sub(pair[0])?.checked_mul(2)? };
        }
        let from_level = numbers.start + Self::PIECE;
        let passed = from_level.min(0).unsigned_abs().div_ceil(step.unsigned_abs()).min(u64::from(span));
        let start = u64::try_from(from_level + i64::try_from(passed).ok()? * step).unwrap_or(0);
        let table = Self { start, pieces_per_code: numbers.pieces_per_code, pieces };
        Some((table, u16::try_from(passed).ok()?))
    }

    /// The reading so many codes from the one that is counted from.
    #[inline(always)]
    fn evaluate(&self, places: u16) -> Q16 {
        // At most 2^48 from a start below 2^39.
        let position = u64::from(places) * u64::from(self.pieces_per_code) + self.start;
        #[allow(clippy::cast_possible_truncation)] // 0 to 2^17
        let whole = (position >> 32) as usize;
        // Always there: so no bound is looked at.
        let Piece { knot, twice_rise } = self.pieces[whole.min(MAX_KNOTS)];
        #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)] // the fraction, halved to fit a sign
        let half_way = (position as u32 >> 1) as i32;
        // Between two knots: what wraps on the way comes back.
        Q16(multiply_high(twice_rise, half_way).wrapping_add(knot))
    }
}

/// The high word of a product: `a * b / 2^32`, rounded down. One instruction on a Cortex-M4.
#[allow(clippy::cast_possible_truncation)] // the product of two i32 shifted by 32 is an i32
fn multiply_high(a: i32, b: i32) -> i32 {
    ((i64::from(a) * i64::from(b)) >> 32) as i32
}
