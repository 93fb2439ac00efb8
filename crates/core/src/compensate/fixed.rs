//! The drift in integers alone.
//!
//! The host's polynomial in `x = (T - centre) / half_span` is written once more in
//! `u = (code - middle) / 2^shift`, where `2^shift` is at least the calibrated range of codes, so that `|u| <= 1/2`
//! and `u` in Q32 is a subtraction and a shift. Horner's step is then one high-word multiply and one add.

use heapless::Vec;

use crate::drift::{Drift, MAX_KNOTS, MAX_ORDER, Polynomial, Shape, Table, ValidRange};
use crate::units::{TemperatureCode, TemperatureScale};

/// A number of counts in steps of 1/65536.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Q16(pub i32);

impl Q16 {
    /// The nearest step to a number of counts; `None` at or beyond +-32768 counts, and for NaN.
    #[must_use]
    pub fn from_counts(counts: f64) -> Option<Self> {
        to_fixed(counts, 16).map(Self)
    }

    /// As counts.
    #[must_use]
    pub fn to_counts(self) -> f64 {
        f64::from(self.0) / 65_536.0
    }
}

/// A drift whose numbers do not fit the fixed-point form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unrepresentable {
    /// The readings, or the coefficients between them, are beyond the fixed-point range.
    TooLarge,
    /// The calibrated range is narrower than the table's pieces can be told apart in.
    TooNarrow,
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
        })
    }
}

impl core::error::Error for Unrepresentable {}

/// Zero-rate output over temperature code in integers: within half a count of the f64 model at every code.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FixedDrift {
    first: u16,
    /// Codes from the first to the last of the range.
    span: u16,
    form: Form,
}

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
    /// Where the first code of the range lies, in pieces from the first knot, Q32.
    start: i64,
    /// Pieces a code, in Q32.
    pieces_per_code: u32,
    /// Readings in Q16.
    knots: Vec<i32, MAX_KNOTS>,
}

impl FixedDrift {
    /// The fixed-point form of a drift model.
    ///
    /// # Errors
    /// [`Unrepresentable`] when its numbers do not fit.
    pub fn new(drift: &Drift, scale: TemperatureScale) -> Result<Self, Unrepresentable> {
        let (first, last) = calibrated_codes(drift.valid, scale).ok_or(Unrepresentable::TooNarrow)?;
        let form = match &drift.shape {
            Shape::Polynomial(polynomial) => polynomial_form(polynomial, scale, first, last)?,
            Shape::Table(table) => table_form(table, scale, first)?,
        };
        Ok(Self { first, span: last - first, form })
    }

    /// The first and last code of the calibrated range.
    #[must_use]
    pub const fn range(&self) -> (TemperatureCode, TemperatureCode) {
        (TemperatureCode(self.first), TemperatureCode(self.first + self.span))
    }

    /// The zero-rate output at the middle tap, held at the nearer end outside the calibrated range.
    #[must_use]
    pub fn evaluate(&self, code: TemperatureCode) -> Q16 {
        self.evaluate_here(code)
    }

    /// The same, where the form is a polynomial.
    #[inline]
    pub(super) fn polynomial(&self, code: TemperatureCode) -> Option<Q16> {
        match &self.form {
            Form::Polynomial(polynomial) => Some(polynomial.evaluate(self.places(code))),
            Form::Table(_) => None,
        }
    }

    /// The same, with no call.
    #[inline(always)]
    pub(super) fn evaluate_here(&self, code: TemperatureCode) -> Q16 {
        match &self.form {
            Form::Polynomial(polynomial) => polynomial.evaluate(self.places(code)),
            Form::Table(table) => table.evaluate(self.places(code)),
        }
    }

    /// Codes from the first of the range, held within it.
    #[inline]
    fn places(&self, code: TemperatureCode) -> u16 {
        code.0.saturating_sub(self.first).min(self.span)
    }
}

impl FixedPolynomial {
    /// The reading at so many codes after the range's first.
    #[inline(always)]
    fn evaluate(&self, from_first: u16) -> Q16 {
        // -1/2 to 1/2 over the range: what wraps on the way comes back.
        let u = i32::from(from_first).wrapping_mul(self.u_per_code).wrapping_add(self.first_u);
        let [c5, c4, c3, c2, c1, c0] = self.coefficients;
        let step = |sum: i32, c: i32| multiply_high(sum, u).wrapping_add(c);
        Q16(step(step(step(step(step(c5, c4), c3), c2), c1), c0).wrapping_mul(self.to_q16))
    }
}

impl FixedTable {
    /// The reading so many codes from the first of the range.
    #[inline(always)]
    fn evaluate(&self, places: u16) -> Q16 {
        // At most 2^48 from a start that `table_form` holds below 2^38.
        #[allow(clippy::cast_sign_loss)] // never below zero
        let position = (i64::from(places) * i64::from(self.pieces_per_code) + self.start).max(0) as u64;
        #[allow(clippy::cast_possible_truncation)] // below the number of knots, and the fraction
        let (piece, within) = ((position >> 32) as usize, position as u32);
        match (self.knots.get(piece), self.knots.get(piece + 1)) {
            (Some(&here), Some(&next)) => {
                // Two neighbours differ by less than 2^31 (see `table_form`), so the rise so far does as well.
                let rise = i64::from(next.wrapping_sub(here)) * i64::from(within);
                #[allow(clippy::cast_possible_truncation)]
                Q16(here.wrapping_add((rise >> 32) as i32))
            }
            _ => Q16(self.knots.last().copied().unwrap_or(0)),
        }
    }
}

/// The codes whose temperatures lie in a valid range, ends rounded to the nearest; `None` if there are fewer than two.
fn calibrated_codes(valid: ValidRange, scale: TemperatureScale) -> Option<(u16, u16)> {
    let (first, last) = (scale.code(valid.min())?.0, scale.code(valid.max())?.0);
    (first < last).then_some((first, last))
}

fn polynomial_form(
    polynomial: &Polynomial,
    scale: TemperatureScale,
    first: u16,
    last: u16,
) -> Result<Form, Unrepresentable> {
    // The smallest power of two that holds the range, and its middle rounded up: -1/2 <= u < 1/2.
    let codes = u32::from(last - first) + 1;
    let bits = codes.next_power_of_two().trailing_zeros();
    #[allow(clippy::cast_possible_truncation)] // at most 2^15
    let middle = first + (codes / 2) as u16;
    let span = f64::from(1_u32 << bits);
    // x = offset + factor u
    let x = polynomial.scale();
    let offset = x.x(scale.temperature(TemperatureCode(middle)));
    let factor = scale.step * span / x.half_span();
    let in_u = crate::drift::substitute(polynomial.coefficients(), offset, factor);
    // Every partial sum of Horner's rule stays below the sum of the magnitudes.
    let magnitude: f64 = in_u.iter().map(|c| libm::fabs(*c)).sum();
    let fraction_bits = (0..=16).rev().find(|&bits| magnitude * f64::from(1_u32 << bits) < f64::from(1_u32 << 30));
    let fraction_bits = fraction_bits.filter(|&bits| bits >= 6).ok_or(Unrepresentable::TooLarge)?;
    // The sum shifted back to Q16 must fit as well.
    let fits = |reading: f64| libm::fabs(reading) < 32_767.0;
    let at = |code: u16| polynomial.evaluate(scale.temperature(TemperatureCode(code)));
    if !(fits(at(first)) && fits(at(last)) && fits(at(middle))) {
        return Err(Unrepresentable::TooLarge);
    }
    let mut coefficients = [0; MAX_ORDER + 1];
    for (slot, &c) in coefficients.iter_mut().rev().zip(&in_u) {
        *slot = to_fixed(c, fraction_bits).ok_or(Unrepresentable::TooLarge)?;
    }
    let shift = 32 - bits;
    #[allow(clippy::cast_possible_wrap)] // one bit of 32, taken modulo 2^32
    let u_per_code = (1_u32 << shift) as i32;
    let first_u = (i32::from(first) - i32::from(middle)).wrapping_mul(u_per_code);
    Ok(Form::Polynomial(FixedPolynomial { first_u, u_per_code, to_q16: 1 << (16 - fraction_bits), coefficients }))
}

/// One in Q32.
const Q32: f64 = 4_294_967_296.0;

fn table_form(table: &Table, scale: TemperatureScale, first: u16) -> Result<Form, Unrepresentable> {
    let knots: Option<Vec<i32, MAX_KNOTS>> = table.knots().iter().map(|&knot| to_fixed(knot, 16)).collect();
    let knots = knots.filter(|knots| knots.windows(2).all(|pair| pair[1].checked_sub(pair[0]).is_some()));
    let [coldest, hottest] = [-1.0, 1.0].map(|x| table.scale().temperature(x));
    let pieces_per_unit =
        f64::from(u16::try_from(table.knots().len() - 1).map_err(|_| Unrepresentable::TooLarge)?) / (hottest - coldest);
    // A piece is more than a code.
    let pieces_per_code = pieces_per_unit * scale.step;
    if !(0.0..1.0).contains(&pieces_per_code) {
        return Err(Unrepresentable::TooNarrow);
    }
    let start = (scale.temperature(TemperatureCode(first)) - coldest) * pieces_per_unit;
    // Below the first knot by more pieces than a table has, or above the last: as good as nearer by.
    let start = start.clamp(-64.0, 64.0);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // bounded above
    Ok(Form::Table(FixedTable {
        start: libm::round(start * Q32) as i64,
        pieces_per_code: libm::round(pieces_per_code * Q32) as u32,
        knots: knots.ok_or(Unrepresentable::TooLarge)?,
    }))
}

/// The high word of a product: `a * b / 2^32`, rounded down. One instruction on a Cortex-M4.
#[allow(clippy::cast_possible_truncation)] // the product of two i32 shifted by 32 is an i32
fn multiply_high(a: i32, b: i32) -> i32 {
    ((i64::from(a) * i64::from(b)) >> 32) as i32
}

/// The nearest fixed-point number with so many fractional bits; `None` when it does not fit.
pub(super) fn to_fixed(value: f64, fraction_bits: u32) -> Option<i32> {
    let scaled = libm::round(value * f64::from(1_u32 << fraction_bits));
    if !(f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&scaled) {
        return None;
    }
    #[allow(clippy::cast_possible_truncation)]
    Some(scaled as i32)
}
