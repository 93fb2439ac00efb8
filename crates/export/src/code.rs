//! What source code is written from: each axis as the templates hold it, in floating point and in integers.

use zerorate_core::drift::{Memory, Shape};

use super::ExportError;
use zerorate_cal::calibration::{AxisCalibration, Calibration};

/// The step by which the integers' history runs, milliseconds.
pub(super) const STEP_MS: u32 = 1000;

/// Temperatures of the integers are in this part of a degree (or of a count).
const TEMPERATURE_ONE: f64 = 65_536.0;

/// 1 of what is behind, in integers.
const BEHIND_ONE: f64 = 1_048_576.0;

/// Integers are kept below this, so that products with 1 in the scaled variable (2^30) fit in 63 bits with room for sums.
const LARGEST: f64 = 536_870_912.0; // 2^29

/// The furthest that a clamped temperature may be from a curve's centre, in its half spans.
const FURTHEST: f64 = 4.0;

/// A curve.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Curve {
    pub is_table: bool,
    pub centre: f64,
    pub half_span: f64,
    pub values: Vec<f64>,
}

/// A term of a history.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Term {
    pub is_play: bool,
    pub size: f64,
    pub weight: f64,
    pub behind: f64,
    pub share: f64,
}

/// An axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    pub name: String,
    pub unit: String,
    pub model: String,
    pub least: f64,
    pub most: f64,
    pub fixed: Curve,
    pub known: Curve,
    pub terms: Vec<Term>,
}

/// A curve in integers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct IntCurve {
    pub is_table: bool,
    pub centre: i64,
    pub inverse: i64,
    pub values: Vec<i64>,
}

/// A term in integers.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct IntTerm {
    pub is_play: bool,
    pub size: i64,
    pub kept: i64,
    pub follows: i64,
    pub weight: i64,
    pub behind: i64,
    pub share: i64,
}

/// An axis in integers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct IntAxis {
    /// What 1 of its biases is, in the axis's unit: a power of ten.
    pub unit: f64,
    pub least: i64,
    pub most: i64,
    pub fixed: IntCurve,
    pub known: IntCurve,
    pub weight_bits: u32,
    pub terms: Vec<IntTerm>,
}

impl Curve {
    fn of(shape: &Shape) -> Self {
        match shape {
            Shape::Polynomial(polynomial) => Self {
                is_table: false,
                centre: polynomial.scale().centre(),
                half_span: polynomial.scale().half_span(),
                values: polynomial.coefficients().to_vec(),
            },
            Shape::Table(table) => Self {
                is_table: true,
                centre: table.scale().centre(),
                half_span: table.scale().half_span(),
                values: table.knots().to_vec(),
            },
        }
    }

    /// The largest number that an evaluation meets.
    fn largest(&self) -> f64 {
        let sizes = self.values.iter().map(|value| value.abs());
        if self.is_table { sizes.fold(0.0, f64::max) } else { sizes.sum() }
    }

    fn integers(&self, unit: f64) -> IntCurve {
        IntCurve {
            is_table: self.is_table,
            centre: whole(self.centre * TEMPERATURE_ONE),
            inverse: whole(2_f64.powi(44) / self.half_span),
            values: self.values.iter().map(|value| whole(value / unit)).collect(),
        }
    }
}

impl Term {
    fn of(term: &zerorate_core::drift::Term) -> Self {
        let (is_play, size) = match term.memory {
            Memory::Play { half_width } => (true, half_width),
            Memory::Lag { time_constant_s } => (false, time_constant_s),
        };
        Self { is_play, size, weight: term.weight, behind: term.behind, share: term.share }
    }
}

/// The nearest whole number; the callers have seen to it that it is no larger than fits.
#[allow(clippy::cast_possible_truncation)]
fn whole(value: f64) -> i64 {
    value.round() as i64
}

/// The axes of a calibration.
pub(super) fn axes(calibration: &Calibration) -> Vec<Axis> {
    calibration.axes.iter().map(|(name, axis)| Axis::of(name, axis)).collect()
}

impl Axis {
    fn of(name: &str, axis: &AxisCalibration) -> Self {
        let fixed = Curve::of(&axis.drift().shape);
        let (known, terms) = match &axis.fit.model.history {
            None => (fixed.clone(), Vec::new()),
            Some(history) => (Curve::of(history.curve()), history.terms().iter().map(Term::of).collect()),
        };
        Self {
            name: name.to_owned(),
            unit: axis.rate_unit.to_string(),
            model: axis.fit.chosen_model(),
            least: axis.drift().valid.min(),
            most: axis.drift().valid.max(),
            fixed,
            known,
            terms,
        }
    }

    /// The axis in integers.
    pub(super) fn integers(&self) -> Result<IntAxis, ExportError> {
        let refused = |why: String| ExportError::TooLarge { axis: self.name.clone(), why };
        let ends = [self.least, self.most];
        if let Some(end) = ends.into_iter().find(|end| end.abs() >= 32_767.0) {
            return Err(refused(format!("a temperature of {end} has no room")));
        }
        for curve in [&self.fixed, &self.known] {
            if ends.iter().any(|end| (end - curve.centre).abs() > FURTHEST * curve.half_span) {
                return Err(refused("its valid range goes far beyond what was fitted".to_owned()));
            }
        }
        let span = self.most - self.least;
        let history: f64 = self.terms.iter().map(|term| term.weight.abs() * span).sum();
        let largest = self.fixed.largest().max(self.known.largest() + history).max(f64::MIN_POSITIVE);
        // The finest power of ten in which all fits.
        let unit = libm::pow(10.0, libm::log10(largest * FURTHEST / LARGEST).ceil());
        if !(unit.is_finite() && unit > 0.0) {
            return Err(refused(format!("its largest number is {largest}")));
        }
        if let Some(term) = self.terms.iter().find(|term| term.behind.abs() * BEHIND_ONE > LARGEST) {
            return Err(refused(format!("a memory that is {} behind has no room", term.behind)));
        }
        let (weight_bits, terms) = self.integer_terms(unit, span);
        Ok(IntAxis {
            unit,
            // Inwards, so that clamping never leaves the range.
            least: ceiling(self.least),
            most: floor(self.most),
            fixed: self.fixed.integers(unit),
            known: self.known.integers(unit),
            weight_bits,
            terms,
        })
    }

    fn integer_terms(&self, unit: f64, span: f64) -> (u32, Vec<IntTerm>) {
        let heaviest = self.terms.iter().map(|term| (term.weight / unit).abs()).fold(0.0, f64::max);
        // A weight fits in 31 bits, and its product with a memory, in 2^-20 of a degree, in 62.
        let fits = |bits: u32| {
            let weight = heaviest * f64::from(1_u32 << bits);
            weight < LARGEST && weight * span * 2_f64.powi(20) < 2_f64.powi(61)
        };
        let weight_bits = (0..=16).rev().find(|bits| fits(*bits)).unwrap_or(0);
        let step_s = f64::from(STEP_MS) / 1000.0;
        let terms = self.terms.iter().map(|term| {
            let common = IntTerm {
                is_play: term.is_play,
                weight: whole(term.weight / unit * f64::from(1_u32 << weight_bits)),
                behind: whole(term.behind * BEHIND_ONE),
                share: whole(term.share * 2_f64.powi(30)),
                ..IntTerm::default()
            };
            if term.is_play {
                return IntTerm { size: whole(term.size * 2_f64.powi(20)), ..common };
            }
            let x = step_s / term.size;
            IntTerm {
                kept: whole(libm::exp(-x) * 2_f64.powi(24)),
                follows: whole(-libm::expm1(-x) / x * 2_f64.powi(24)),
                ..common
            }
        });
        (weight_bits, terms.collect())
    }
}

#[allow(clippy::cast_possible_truncation)]
fn ceiling(temperature: f64) -> i64 {
    (temperature * TEMPERATURE_ONE).ceil() as i64
}

#[allow(clippy::cast_possible_truncation)]
fn floor(temperature: f64) -> i64 {
    (temperature * TEMPERATURE_ONE).floor() as i64
}

/// The most values of a curve, and the most terms, at least 1: an array has no length of 0.
pub(super) fn sizes(axes: &[Axis]) -> (usize, usize) {
    let values = axes.iter().map(|axis| axis.fixed.values.len().max(axis.known.values.len())).max();
    let terms = axes.iter().map(|axis| axis.terms.len()).max();
    (values.unwrap_or(1).max(1), terms.unwrap_or(1).max(1))
}

/// A number as C reads it, the shortest that reads back to the same double.
pub(super) fn number(value: f64) -> String {
    format!("{value:e}")
}

/// A name as an identifier in capitals: `GYRO0_X`.
pub(super) fn identifier(name: &str) -> String {
    let plain: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_uppercase() } else { '_' }).collect();
    format!("AXIS_{plain}")
}

/// A name as it may stand between quotes.
pub(super) fn quoted(name: &str) -> String {
    let plain: String =
        name.chars().map(|c| if c.is_ascii_graphic() && c != '"' && c != '\\' || c == ' ' { c } else { '_' }).collect();
    format!("\"{plain}\"")
}

/// What a file of code says of its axes, a line each.
pub(super) fn remarks(axes: &[Axis]) -> Vec<String> {
    let of = |axis: &Axis| {
        format!(
            "{}: {}, in {}, from {} to {}; outside, the temperature is held at the end",
            super::one_line(&axis.name),
            axis.model,
            axis.unit,
            axis.least,
            axis.most
        )
    };
    axes.iter().map(of).collect()
}
