//! Polynomials of order 1 to 5 in the centred, scaled variable.

use heapless::Vec;

use super::scale::Scale;

/// The highest order. ArduPilot's users ask for 5; beyond it a curve follows noise at its ends.
pub const MAX_ORDER: usize = 5;

/// `zro = c0 + c1 x + ... + ck x^k` with `x = (T - centre) / half_span`.
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial {
    scale: Scale,
    coefficients: Vec<f64, { MAX_ORDER + 1 }>,
}

impl Polynomial {
    /// A polynomial by its coefficients in the scaled variable, constant first, in the reading's unit.
    /// `None` unless there are 2 to 6 and all are finite.
    #[must_use]
    pub fn new(scale: Scale, coefficients: &[f64]) -> Option<Self> {
        if coefficients.len() < 2 || !coefficients.iter().all(|c| c.is_finite()) {
            return None;
        }
        Some(Self { scale, coefficients: Vec::from_slice(coefficients).ok()? })
    }

    /// A polynomial from coefficients in the temperature itself, constant first, as papers print them.
    #[must_use]
    pub fn from_raw_coefficients(scale: Scale, raw: &[f64]) -> Option<Self> {
        let scaled = substitute(raw, scale.centre(), scale.half_span());
        Self::new(scale, &scaled)
    }

    pub(super) fn lowered(&self, by: f64) -> Self {
        let mut lowered = self.clone();
        lowered.coefficients[0] -= by;
        lowered
    }

    /// The centred variable that the coefficients belong to.
    #[must_use]
    pub const fn scale(&self) -> Scale {
        self.scale
    }

    /// The coefficients in the scaled variable, constant first, all in the reading's unit.
    #[must_use]
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// 1 to 5.
    #[must_use]
    pub fn order(&self) -> usize {
        self.coefficients.len() - 1
    }

    /// The coefficients in the temperature itself, constant first: reading, reading per unit of T, ...
    #[must_use]
    pub fn raw_coefficients(&self) -> Vec<f64, { MAX_ORDER + 1 }> {
        substitute(&self.coefficients, -self.scale.centre() / self.scale.half_span(), 1.0 / self.scale.half_span())
    }

    /// The reading at a temperature, by Horner's rule.
    #[must_use]
    pub fn evaluate(&self, temperature: f64) -> f64 {
        horner(&self.coefficients, self.scale.x(temperature))
    }

    /// The temperatures strictly between `min` and `max` at which the curve turns round, coldest first.
    #[must_use]
    pub fn turning_points(&self, min: f64, max: f64) -> Vec<f64, MAX_ORDER> {
        let slope = derivative(&self.coefficients);
        sign_changes(&slope, self.scale.x(min), self.scale.x(max)).iter().map(|&x| self.scale.temperature(x)).collect()
    }
}

type Coefficients = Vec<f64, { MAX_ORDER + 1 }>;

fn horner(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

fn derivative(coefficients: &[f64]) -> Coefficients {
    let mut power = 0.0;
    coefficients
        .iter()
        .skip(1)
        .map(|c| {
            power += 1.0;
            c * power
        })
        .collect()
}

/// The coefficients in `y` of the polynomial when `x = offset + factor * y`: Horner's rule on polynomials.
pub(crate) fn substitute(coefficients: &[f64], offset: f64, factor: f64) -> Coefficients {
    let mut result: Coefficients = Vec::new();
    for &c in coefficients.iter().rev() {
        // result = result * (offset + factor y) + c
        let mut carried = 0.0;
        for slot in &mut result {
            let grown = *slot * offset + carried;
            carried = *slot * factor;
            *slot = grown;
        }
        // A polynomial of n coefficients never grows past n: the first pass pushes c alone.
        let _ = result.push(carried);
        result[0] += c;
    }
    result
}

/// Where a polynomial changes sign between `a` and `b`, in ascending order.
///
/// The sign changes of each derivative bracket those of the one before it, so the search starts at the highest,
/// whose sign is constant, and works down; every bracket holds at most one.
fn sign_changes(coefficients: &[f64], a: f64, b: f64) -> Vec<f64, MAX_ORDER> {
    let mut derivatives: Vec<Coefficients, { MAX_ORDER + 1 }> = Vec::new();
    let mut next: Coefficients = coefficients.iter().copied().collect();
    while !next.is_empty() {
        let below = derivative(&next);
        let _ = derivatives.push(next);
        next = below;
    }
    let mut found: Vec<f64, MAX_ORDER> = Vec::new();
    for polynomial in derivatives.iter().rev() {
        let mut brackets: Vec<f64, { MAX_ORDER + 2 }> = Vec::new();
        let _ = brackets.push(a);
        let _ = brackets.extend_from_slice(&found);
        let _ = brackets.push(b);
        found = brackets.windows(2).filter_map(|bracket| sign_change(polynomial, bracket[0], bracket[1])).collect();
    }
    found
}

/// The point between `a` and `b` where a polynomial, monotone between them, changes sign: by bisection to the last bit.
fn sign_change(coefficients: &[f64], mut a: f64, mut b: f64) -> Option<f64> {
    let (at_a, at_b) = (horner(coefficients, a), horner(coefficients, b));
    if at_a * at_b >= 0.0 {
        return None;
    }
    loop {
        let middle = f64::midpoint(a, b);
        if middle <= a || middle >= b {
            return Some(middle);
        }
        if horner(coefficients, middle) * at_a > 0.0 { a = middle } else { b = middle }
    }
}
