//! From models in f64 to the numbers that a device runs. The host does it; a device does no floating point.
//!
//! What is rounded here is held against what it was rounded from: a drift at every code of its range, a table of edges at
//! both sides of every edge. A device knows the integers alone, and checks those against each other.

use heapless::Vec;

use super::law::StaticLaw;
use super::low_pass::LowPass;
use crate::compensate::axis_law::AxisLaw;
use crate::compensate::edges::EdgeTable;
use crate::compensate::fixed::FixedDrift;
use crate::compensate::numbers::{
    CODE_BITS, CurveNumbers, DriftNumbers, HistoryNumbers, LawNumbers, LowPassNumbers, MemoryNumbers,
    PolynomialNumbers, TableNumbers, TermNumbers, TrimNumbers, WEIGHT_BITS,
};
use crate::compensate::q16::{Q16, to_fixed};
use crate::compensate::refused::{LawRefused, Unrepresentable};
use crate::drift::{Drift, History, Memory, Polynomial, Shape, Table, Term, ValidRange, substitute};
use crate::trim::Trim;
use crate::units::{Counts, TemperatureCode, TemperatureScale};

/// One in Q32.
const Q32: f64 = 4_294_967_296.0;

/// The integers give the drift to within so many counts.
const ACCURACY_COUNTS: f64 = 0.5;

impl AxisLaw {
    /// The device's form of a law, from the model. `edges` is the table that belongs to it, `None` where the law has none
    /// and the wiper is to stay (mode digital); it is checked against the law, in f64 and in integers.
    ///
    /// # Errors
    /// [`LawRefused`], when the numbers do not fit or the table is wrong.
    pub fn new(law: &StaticLaw, edges: Option<&EdgeTable>, low_pass: LowPass) -> Result<Self, LawRefused> {
        Self::from_numbers(&LawNumbers::new(law, edges, low_pass)?)
    }
}

impl LawNumbers {
    /// A law as a record stores it. `edges` is its table, checked against the law; `None` where the law has none and the
    /// wiper is to stay (mode digital).
    ///
    /// # Errors
    /// [`LawRefused`], when the numbers do not fit or the table is wrong.
    pub fn new(law: &StaticLaw, edges: Option<&EdgeTable>, low_pass: LowPass) -> Result<Self, LawRefused> {
        let centre = law.trim.line.centre();
        let drift = DriftNumbers::new(&from_centre(&law.drift, centre), law.temperature_scale)?;
        if let Some(edges) = edges {
            edges.check(law).map_err(LawRefused::Edges)?;
        }
        let numbers = || {
            Some(Self {
                drift,
                trim: TrimNumbers::new(&law.trim)?,
                dead_band: to_fixed(law.dead_band, 16)?,
                low_pass: low_pass.numbers(),
                edges: edges.cloned(),
                history: None,
            })
        };
        numbers().ok_or(LawRefused::Unrepresentable(Unrepresentable::TooLarge))
    }
}

impl DriftNumbers {
    /// A drift as a record stores it.
    ///
    /// # Errors
    /// [`Unrepresentable`], when its numbers do not fit, or are off by more than half a count.
    pub fn new(drift: &Drift, scale: TemperatureScale) -> Result<Self, Unrepresentable> {
        let (first, last) = calibrated_codes(drift.valid, scale).ok_or(Unrepresentable::TooNarrow)?;
        let curve = match &drift.shape {
            Shape::Polynomial(polynomial) => {
                CurveNumbers::Polynomial(rounded_polynomial(polynomial, scale, first, last)?)
            }
            Shape::Table(table) => CurveNumbers::Table(rounded_table(table, scale, first)?),
        };
        let numbers = Self { first, last, curve };
        let fixed = FixedDrift::from_numbers(&numbers).ok_or(Unrepresentable::TooLarge)?;
        let is_close = |code: TemperatureCode| {
            let (exact, _) = drift.evaluate(scale.temperature(code));
            libm::fabs(fixed.evaluate(code).to_counts() - exact) <= ACCURACY_COUNTS
        };
        // Beyond its codes a drift is held at the end of its range, which may lie between two of them.
        let with_beyond = first.saturating_sub(1)..=last.saturating_add(1);
        let close = with_beyond.map(TemperatureCode).all(is_close);
        close.then_some(numbers).ok_or(Unrepresentable::TooCoarse)
    }
}

/// A drift counted from the reading aimed at.
fn from_centre(drift: &Drift, centre: Counts) -> Drift {
    Drift { shape: drift.shape.lowered(centre.0), valid: drift.valid }
}

/// The codes whose temperatures lie in a valid range, ends rounded to the nearest; `None` if there are fewer than two.
fn calibrated_codes(valid: ValidRange, scale: TemperatureScale) -> Option<(u16, u16)> {
    let (first, last) = (scale.code(valid.min())?.0, scale.code(valid.max())?.0);
    (first < last).then_some((first, last))
}

fn rounded_polynomial(
    polynomial: &Polynomial,
    scale: TemperatureScale,
    first: u16,
    last: u16,
) -> Result<PolynomialNumbers, Unrepresentable> {
    let codes = u32::from(last - first) + 1;
    #[allow(clippy::cast_possible_truncation)] // at most 2^15
    let middle = first + (codes / 2) as u16;
    let span = f64::from(codes.next_power_of_two());
    // x = offset + factor u
    let x = polynomial.scale();
    let offset = x.x(scale.temperature(TemperatureCode(middle)));
    let factor = scale.step * span / x.half_span();
    let in_u = substitute(polynomial.coefficients(), offset, factor);
    let magnitude: f64 = in_u.iter().map(|c| libm::fabs(*c)).sum();
    // Rounded, they may be half a step each larger; the device's form leaves no room beyond 2^30.
    let most = f64::from((1_u32 << 30) - 4);
    let fraction_bits = (6..=16_u8).rev().find(|&bits| magnitude * f64::from(1_u32 << bits) < most);
    let fraction_bits = fraction_bits.ok_or(Unrepresentable::TooLarge)?;
    let coefficients: Option<_> = in_u.iter().map(|&c| to_fixed(c, u32::from(fraction_bits))).collect();
    Ok(PolynomialNumbers { fraction_bits, coefficients: coefficients.ok_or(Unrepresentable::TooLarge)? })
}

fn rounded_table(table: &Table, scale: TemperatureScale, first: u16) -> Result<TableNumbers, Unrepresentable> {
    let knots: Option<Vec<i32, _>> = table.knots().iter().map(|&knot| to_fixed(knot, 16)).collect();
    let [coldest, hottest] = [-1.0, 1.0].map(|x| table.scale().temperature(x));
    let pieces_per_unit =
        f64::from(u16::try_from(table.knots().len() - 1).map_err(|_| Unrepresentable::TooLarge)?) / (hottest - coldest);
    // A piece is more than a code.
    let pieces_per_code = pieces_per_unit * scale.step;
    if !(0.0..1.0).contains(&pieces_per_code) {
        return Err(Unrepresentable::TooNarrow);
    }
    let start = (scale.temperature(TemperatureCode(first)) - coldest) * pieces_per_unit;
    // Above the last knot by more pieces than a table has: as good as nearer by. Below the first every code counts, and a
    // piece is more than one of 65 536.
    let start = start.clamp(-65_536.0, 64.0);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // bounded above
    Ok(TableNumbers {
        start: libm::round(start * Q32) as i64,
        pieces_per_code: libm::round(pieces_per_code * Q32) as u32,
        knots: knots.ok_or(Unrepresentable::TooLarge)?,
    })
}

impl TrimNumbers {
    /// A trim model as a record stores it; `None` when an effect does not fit.
    pub(in crate::compensate) fn new(trim: &Trim) -> Option<Self> {
        let per_tap = trim.line.counts_per_tap().0;
        let (first, effects, intercept) = match &trim.measured {
            None => (trim.line.middle(), Vec::new(), trim.line.intercept_taps() * per_tap),
            Some(swept) => {
                let fixed = swept.effects().iter().map(|effect| Q16::from_counts(effect.0).map(|q| q.0));
                (swept.first(), fixed.collect::<Option<_>>()?, 0.0)
            }
        };
        Some(Self { first, effects, per_tap: to_fixed(per_tap, 16)?, intercept: to_fixed(intercept, 16)? })
    }
}

impl HistoryNumbers {
    /// A history beside its static drift as a record stores it. `centre` is the reading aimed at, `group_period_s` the time
    /// from group to group, in seconds.
    ///
    /// # Errors
    /// [`Unrepresentable`], when its numbers do not fit.
    pub fn new(
        history: &History,
        drift: &Drift,
        centre: Counts,
        scale: TemperatureScale,
        group_period_s: f64,
    ) -> Result<Self, Unrepresentable> {
        let curve = from_centre(&Drift { shape: history.curve().clone(), valid: drift.valid }, centre);
        let terms: Option<_> = history.terms().iter().map(|term| rounded_term(term, scale, group_period_s)).collect();
        Ok(Self { curve: DriftNumbers::new(&curve, scale)?.curve, terms: terms.ok_or(Unrepresentable::TooLarge)? })
    }
}

fn rounded_term(term: &Term, scale: TemperatureScale, group_period_s: f64) -> Option<TermNumbers> {
    let memory = match term.memory {
        Memory::Play { half_width } => {
            let half_width = to_fixed(half_width / scale.step, CODE_BITS)?;
            MemoryNumbers::Play { half_width: (half_width > 0).then_some(half_width)? }
        }
        Memory::Lag { time_constant_s } => {
            let x = group_period_s / time_constant_s;
            MemoryNumbers::Lag { kept: q32(libm::exp(-x))?, part: q32(x).filter(|&part| part > 0)? }
        }
    };
    let share = to_fixed(term.share.clamp(0.0, 1.0), 16)?.unsigned_abs();
    let weight = to_fixed(term.weight * scale.step, WEIGHT_BITS)?;
    Some(TermNumbers { memory, weight, behind: to_fixed(term.behind, WEIGHT_BITS)?, share })
}

impl LowPass {
    /// As a record stores it.
    pub(super) fn numbers(self) -> LowPassNumbers {
        LowPassNumbers {
            missing_at_first: part_q32(self.missing_at_first),
            missing_per_sample: part_q32(self.missing_per_sample),
        }
    }
}

/// A part, 0 to just below 1, in Q32.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // clamped to 32 bits
fn part_q32(part: f64) -> u32 {
    libm::round(part * Q32).clamp(0.0, f64::from(u32::MAX)) as u32
}

/// A number of 0 or more in Q32; `None` where it does not fit 62 bits.
fn q32(value: f64) -> Option<u64> {
    let scaled = libm::round(value * Q32);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // within range, and whole
    (0.0..4.6e18).contains(&scaled).then_some(scaled as u64)
}
