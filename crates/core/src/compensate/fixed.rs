//! The drift in integers alone.
//!
//! A polynomial is written in `u = (code - middle) / 2^b`, where `2^b` is at least the calibrated range of codes, so that
//! `|u| <= 1/2` and `u`, a multiple of 2^-16, is held by 16 bits. Horner's step is then one instruction of a Cortex-M4: 32
//! bits times 16, the upper 32 of the product, and the next coefficient added.

use super::codes::Codes;
use super::numbers::{CurveNumbers, DriftNumbers, PolynomialNumbers, TableNumbers};
use super::q16::Q16;
use crate::drift::{MAX_KNOTS, MAX_ORDER};
use crate::units::TemperatureCode;

/// Zero-rate output over temperature code in integers, checked: no step of it can wrap.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FixedDrift {
    /// The first and the last code of the calibrated range.
    range: (u16, u16),
    /// The codes that the form counts; on either side of them it is level.
    counted: (u16, u16),
    /// The same, where sums are in Q16 as they are; else none.
    quick: Codes,
    /// From a polynomial's fractional bits to Q16: a power of two.
    to_q16: i32,
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
    /// `u` at the first code of the range, Q32, and from code to code, Q16.
    first_u: u32,
    u_per_code: u32,
    /// Highest order first, as Horner takes them; zeros before a lower order's, so that there is no loop to count.
    varying: [i32; MAX_ORDER],
    constant: i32,
}

/// Straight pieces in integers.
#[derive(Debug, Clone, PartialEq, Eq)]
struct FixedTable {
    /// Where the code that is counted from lies, in pieces from one piece before the first knot, Q32.
    start: u64,
    /// Pieces a code, in Q32.
    pieces_per_code: u32,
    /// First a level one, so that no place lies below all of them; then one from each knot on, from the last on level. A
    /// power of two of them, so that no bound is looked at.
    pieces: [Piece; PIECES],
}

/// More than a table has with a level piece at either end.
const PIECES: usize = (MAX_KNOTS + 1).next_power_of_two();

/// A straight piece: below the reading at its beginning, Q16; above twice the rise to its end, Q16, for a high-word multiply
/// by half the way. In one number they are fetched at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Piece(i64);

impl Piece {
    fn new(knot: i32, twice_rise: i32) -> Self {
        Self(i64::from(twice_rise) << 32 | i64::from(knot.cast_unsigned()))
    }

    #[allow(clippy::cast_possible_truncation)] // the lower half
    const fn knot(self) -> i32 {
        self.0 as i32
    }

    #[allow(clippy::cast_possible_truncation)] // the upper half
    const fn twice_rise(self) -> i32 {
        (self.0 >> 32) as i32
    }
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
        let (form, counted, to_q16) = match curve {
            CurveNumbers::Polynomial(numbers) => {
                let (polynomial, to_q16) = FixedPolynomial::new(numbers, span)?;
                (Form::Polynomial(polynomial), (first, last), to_q16)
            }
            CurveNumbers::Table(numbers) => {
                let (table, counted) = FixedTable::new(numbers, first, last)?;
                (Form::Table(table), counted, 1)
            }
        };
        let quick = if to_q16 == 1 { Codes::between(counted.0, counted.1) } else { Codes::NONE };
        Some(Self { range: (first, last), counted, quick, to_q16, form })
    }

    /// The first and last code of the calibrated range.
    #[must_use]
    pub const fn range(&self) -> (TemperatureCode, TemperatureCode) {
        (TemperatureCode(self.range.0), TemperatureCode(self.range.1))
    }

    /// The zero-rate output at the middle tap, held at the nearer end outside the calibrated range.
    #[must_use]
    pub fn evaluate(&self, code: TemperatureCode) -> Q16 {
        let (first, last) = self.counted;
        let places = u32::from(code.0.clamp(first, last) - first) << 16;
        Q16(self.sum(places).wrapping_mul(self.to_q16))
    }

    /// The same with no call, less the [`constant`](Self::constant); `None` where it takes more than that.
    #[inline(always)]
    pub(super) fn quickly(&self, code: TemperatureCode) -> Option<i32> {
        let places = self.quick.place(code)?;
        Some(match &self.form {
            Form::Polynomial(polynomial) => polynomial.varying(places),
            Form::Table(table) => table.sum(places),
        })
    }

    /// What [`quickly`](Self::quickly) leaves to be added.
    pub(super) const fn constant(&self) -> i32 {
        match &self.form {
            Form::Polynomial(polynomial) => polynomial.constant,
            Form::Table(_) => 0,
        }
    }

    /// Has [`quickly`](Self::quickly) give nothing.
    pub(super) const fn never_quickly(&mut self) {
        self.quick = Codes::NONE;
    }

    /// The reading in the form's own steps, so many codes (in the upper half) from the first that is counted.
    fn sum(&self, places: u32) -> i32 {
        match &self.form {
            Form::Polynomial(polynomial) => polynomial.varying(places).wrapping_add(polynomial.constant),
            Form::Table(table) => table.sum(places),
        }
    }
}

impl FixedPolynomial {
    /// The polynomial, and by what its sums are to be multiplied.
    fn new(numbers: &PolynomialNumbers, span: u16) -> Option<(Self, i32)> {
        let given = &numbers.coefficients;
        let bits = u32::from(numbers.fraction_bits);
        // Every partial sum of Horner's rule stays below the sum of the magnitudes.
        let magnitude: u64 = given.iter().map(|c| u64::from(c.unsigned_abs())).sum();
        if given.len() < 2 || !(6..=16).contains(&bits) || magnitude >= 1 << 30 {
            return None;
        }
        let (&constant, others) = given.split_first()?;
        let mut varying = [0; MAX_ORDER];
        for (slot, &c) in varying.iter_mut().rev().zip(others) {
            *slot = c;
        }
        let codes = u32::from(span) + 1;
        let u_per_code = (1 << 16) / codes.next_power_of_two();
        let first_u = ((codes / 2) << 16).wrapping_neg().wrapping_mul(u_per_code);
        let polynomial = Self { first_u, u_per_code, varying, constant };
        // In Q16 it must fit as well, at every code.
        let to_q16 = 1 << (16 - bits);
        let fits = |places: u16| {
            let sum = polynomial.varying(u32::from(places) << 16).wrapping_add(constant);
            sum.checked_mul(to_q16).is_some()
        };
        (0..=span).all(fits).then_some((polynomial, to_q16))
    }

    /// The reading at so many codes (in the upper half) after the range's first, in the coefficients' own steps, less the
    /// constant.
    #[inline(always)]
    fn varying(&self, places: u32) -> i32 {
        // -1/2 to 1/2 over the range, a multiple of 2^-16: what wraps on the way comes back.
        #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)]
        let u = (places.wrapping_mul(self.u_per_code).wrapping_add(self.first_u) as i32 >> 16) as i16;
        let [c5, c4, c3, c2, c1] = self.varying;
        let step = |sum: i32, c: i32| multiply_q16(sum, u).wrapping_add(c);
        multiply_q16(step(step(step(step(c5, c4), c3), c2), c1), u)
    }
}

impl FixedTable {
    /// One piece, Q32.
    const PIECE: i64 = 1 << 32;
    /// A piece is more than a code, so the range begins fewer pieces before the first knot than there are codes; and as far
    /// behind the last one as anything need be.
    const STARTS: core::ops::RangeInclusive<i64> = -65_536 * Self::PIECE..=64 * Self::PIECE;

    /// The table, and the first and last code that it counts. Those of the range that lie more than a piece before the
    /// first knot or behind the last are passed over: it is as level there as within that piece.
    fn new(numbers: &TableNumbers, first: u16, last: u16) -> Option<(Self, (u16, u16))> {
        let (knots, step) = (&numbers.knots, i64::from(numbers.pieces_per_code));
        if knots.len() < 2 || step == 0 || !Self::STARTS.contains(&numbers.start) {
            return None;
        }
        let mut pieces = [Piece::new(*knots.last()?, 0); PIECES];
        pieces[0] = Piece::new(*knots.first()?, 0);
        for (piece, pair) in pieces[1..].iter_mut().zip(knots.windows(2)) {
            *piece = Piece::new(pair[0], pair[1].checked_sub(pair[0])?.checked_mul(2)?);
        }
        // The first code at or behind a place in pieces, from the level one on; held within the range.
        let code_at = |place: i64| {
            let codes = (place - Self::PIECE - numbers.start).max(0).unsigned_abs().div_ceil(step.unsigned_abs());
            first + u16::try_from(codes).unwrap_or(u16::MAX).min(last - first)
        };
        let counted = (code_at(0), code_at(i64::try_from(knots.len()).ok()? * Self::PIECE));
        let start = numbers.start + Self::PIECE + i64::from(counted.0 - first) * step;
        // Where a range begins behind all knots, any place in the level piece is as good.
        let furthest = i64::try_from(PIECES - 1).ok()? * Self::PIECE;
        let start = u64::try_from(start.clamp(0, furthest)).ok()?;
        Some((Self { start, pieces_per_code: numbers.pieces_per_code, pieces }, counted))
    }

    /// The reading so many codes (in the upper half) from the one that is counted from.
    #[inline(always)]
    fn sum(&self, places: u32) -> i32 {
        let position = u64::from(places >> 16) * u64::from(self.pieces_per_code) + self.start;
        #[allow(clippy::cast_possible_truncation)] // below PIECES
        let piece = self.pieces[(position >> 32) as usize % PIECES];
        #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)] // the fraction, halved to fit a sign
        let half_way = (position as u32 >> 1) as i32;
        // Between two knots: what wraps on the way comes back.
        multiply_high(piece.twice_rise(), half_way).wrapping_add(piece.knot())
    }
}

/// `a * b / 2^16`, rounded down. One instruction on a Cortex-M4, the addition after it included.
#[allow(clippy::cast_possible_truncation)] // the product of 32 and 16 bits shifted by 16 has 32
fn multiply_q16(a: i32, b: i16) -> i32 {
    ((i64::from(a) * i64::from(b)) >> 16) as i32
}

/// The high word of a product: `a * b / 2^32`, rounded down. One instruction on a Cortex-M4.
#[allow(clippy::cast_possible_truncation)] // the product of two i32 shifted by 32 is an i32
fn multiply_high(a: i32, b: i32) -> i32 {
    ((i64::from(a) * i64::from(b)) >> 32) as i32
}
