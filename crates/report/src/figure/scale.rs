//! The range of an axis, its ticks and their labels.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// No axis has more ticks, whatever its range.
const MOST_TICKS: usize = 20;

/// The part of the range left empty at each end.
const MARGIN: f64 = 0.05;

/// An axis: its range, where its ticks are, and how they are written.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scale {
    /// The least and the greatest value drawn.
    pub(super) range: (f64, f64),
    /// Values at the ticks, all within the range.
    pub(super) ticks: Vec<f64>,
    /// Labels are values divided by ten to this power, a multiple of three.
    pub(super) exponent: i32,
    decimals: usize,
    /// Values are logarithms to base ten, and labels what they are of.
    logarithms: bool,
}

impl Scale {
    /// A scale of about so many ticks on which all of `values` that are numbers have room; without any it spans 0 to 1.
    pub(super) fn holding(values: impl Iterator<Item = f64>, ticks: f64) -> Self {
        let finite = values.filter(|value| value.is_finite());
        let (min, max) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        if min > max {
            return Self::over((0.0, 1.0), ticks);
        }
        let span = max - min;
        // Equal values still need a span: a thousandth of them, or one if they are zero.
        let room = match (span > 0.0, max.abs() > 0.0) {
            (true, _) => span * MARGIN,
            (false, true) => max.abs() * 1e-3,
            (false, false) => 1.0,
        };
        Self::over((min - room, max + room), ticks)
    }

    /// A scale over exactly this range, of about so many ticks.
    pub(super) fn over((min, max): (f64, f64), wanted: f64) -> Self {
        Self::by((min, max), nice_step((max - min) / wanted))
    }

    /// A scale of numbers of things, from none to the most of `values`: its ticks are whole numbers.
    pub(super) fn counting(values: impl Iterator<Item = f64>, wanted: f64) -> Self {
        let most = values.filter(|value| value.is_finite()).fold(1.0, f64::max) * (1.0 + MARGIN);
        Self::by((0.0, most), nice_step(most / wanted).max(1.0))
    }

    /// A scale over exactly this range with a tick at each multiple of `step`.
    fn by((min, max): (f64, f64), step: f64) -> Self {
        let first = (min / step).ceil();
        let last = (max / step).floor();
        let mut ticks = Vec::new();
        let mut number = first;
        // A range so narrow that its ends are the same double has no ticks at all.
        while number <= last && ticks.len() < MOST_TICKS {
            // Adding 0 turns a negative zero into a plain one.
            ticks.push(number * step + 0.0);
            number += 1.0;
        }
        let largest = min.abs().max(max.abs());
        // Below a hundredth or from ten million on, zeros would hide the digits.
        let exponent = if (1e-2..1e7).contains(&largest) { 0 } else { thousands(largest) };
        let decimals = decimals(step / 10_f64.powi(exponent));
        Self { range: (min, max), ticks, exponent, decimals, logarithms: false }
    }

    /// A scale of logarithms to base ten that holds all of `values` that are numbers: a tick a decade, and at twice and
    /// five times that where there are few.
    // Decades are within 400.
    #[allow(clippy::cast_possible_truncation)]
    pub(super) fn decades(values: impl Iterator<Item = f64>) -> Self {
        let range = Self::holding(values, 1.0).range;
        let within = |tick: &f64| (range.0..=range.1).contains(tick);
        let (first, last) = (range.0.floor().max(-400.0) as i32, range.1.ceil().min(400.0) as i32);
        let at = |factors: &[f64]| -> Vec<f64> {
            let decade = |decade: i32| factors.iter().map(move |factor| f64::from(decade) + factor.log10());
            (first..=last).flat_map(decade).filter(within).take(MOST_TICKS).collect()
        };
        let whole = at(&[1.0]);
        let ticks = if whole.len() > 2 { whole } else { at(&[1.0, 2.0, 5.0]) };
        Self { range, ticks, exponent: 0, decimals: 0, logarithms: true }
    }

    /// Where a value is on the axis: 0 at its start, 1 at its end.
    pub(super) fn share(&self, value: f64) -> f64 {
        (value - self.range.0) / (self.range.1 - self.range.0)
    }

    /// The label of a tick.
    // Decades are within 400, and factors are 1, 2 or 5.
    #[allow(clippy::cast_possible_truncation)]
    pub(super) fn label(&self, tick: f64) -> String {
        if self.logarithms {
            let decade = (tick + 1e-9).floor();
            let factor = 10_f64.powf(tick - decade).round();
            return match (decade as i32, factor > 1.5) {
                (0..=4, _) => super::super::number::fixed(factor * 10_f64.powf(decade), 0),
                (-2..=-1, _) => {
                    super::super::number::fixed(factor * 10_f64.powf(decade), usize::from(decade < -1.5) + 1)
                }
                (decade, true) => format!("{factor:.0}·10{}", super::super::number::raised(decade)),
                (decade, false) => format!("10{}", super::super::number::raised(decade)),
            };
        }
        super::super::number::fixed(tick / 10_f64.powi(self.exponent), self.decimals)
    }
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    // Within the drawing, which is a few thousand units wide; what lies outside is held at a distance that still fits.
    #[allow(clippy::cast_possible_truncation)]
    fn map(&self, value: &f64, (start, end): (i32, i32)) -> i32 {
        let share = self.share(*value).clamp(-2.0, 3.0);
        start + (f64::from(end - start) * share).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        // No finer lines between those at the ticks.
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.range.0..self.range.1
    }
}

impl ValueFormatter<f64> for Scale {
    fn format_ext(&self, tick: &f64) -> String {
        self.label(*tick)
    }
}

/// The power of a thousand below a value, as a power of ten.
// A double's exponent is within 400.
#[allow(clippy::cast_possible_truncation)]
fn thousands(value: f64) -> i32 {
    (value.log10() / 3.0).floor().clamp(-100.0, 100.0) as i32 * 3
}

/// The least of 1, 2, 5 times a power of ten that is not below `least`.
fn nice_step(least: f64) -> f64 {
    let power = 10_f64.powf(least.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= least * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * power
}

/// Decimals that a multiple of `step` needs.
// Between 0 and 9.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn decimals(step: f64) -> usize {
    (-(step * (1.0 + 1e-9)).log10().floor()).clamp(0.0, 9.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: &Scale) -> Vec<String> {
        scale.ticks.iter().map(|tick| scale.label(*tick)).collect()
    }

    #[test]
    fn ticks_are_round_numbers_within_the_range() {
        let scale = Scale::holding([8512.0, 11_890.0].into_iter(), 5.0);
        assert_eq!(labels(&scale), ["9000", "10\u{202f}000", "11\u{202f}000", "12\u{202f}000"]);
        assert!(scale.range.0 < 8512.0 && scale.range.1 > 11_890.0);
    }

    #[test]
    fn a_scale_through_zero_has_a_zero_without_a_sign() {
        let scale = Scale::over((-0.5, 0.5), 5.0);
        assert_eq!(labels(&scale), ["\u{2212}0.4", "\u{2212}0.2", "0.0", "0.2", "0.4"]);
    }

    #[test]
    fn things_are_counted_in_whole_numbers() {
        assert_eq!(labels(&Scale::counting([0.0, 2.0].into_iter(), 8.0)), ["0", "1", "2"]);
        assert_eq!(labels(&Scale::counting([0.0, 30.0].into_iter(), 8.0)), ["0", "5", "10", "15", "20", "25", "30"]);
        assert_eq!(labels(&Scale::counting(std::iter::empty(), 8.0)), ["0", "1"]);
    }

    #[test]
    fn small_values_are_written_by_a_power_of_a_thousand() {
        let scale = Scale::over((0.0, 0.004), 5.0);
        assert_eq!((scale.exponent, labels(&scale)[1].as_str()), (-3, "1"));
    }

    #[test]
    fn logarithms_are_labelled_by_what_they_are_of() {
        let scale = Scale::decades([0.0, 3.5].into_iter());
        assert_eq!(labels(&scale), ["1", "10", "100", "1000"]);
        let few = Scale::decades([-4.6, -3.4].into_iter());
        assert_eq!(labels(&few), ["5·10⁻⁵", "10⁻⁴", "2·10⁻⁴"]);
        assert_eq!(labels(&Scale::decades([-1.7, 0.2].into_iter())), ["0.02", "0.05", "0.1", "0.2", "0.5", "1"]);
    }

    #[test]
    fn nothing_and_a_single_value_still_make_a_scale() {
        assert_eq!(Scale::holding([f64::NAN].into_iter(), 5.0).range, (0.0, 1.0));
        let one = Scale::holding([8200.0].into_iter(), 5.0);
        assert!(one.range.0 < 8200.0 && one.range.1 > 8200.0 && !one.ticks.is_empty());
        assert!(!Scale::holding([0.0].into_iter(), 5.0).ticks.is_empty());
        assert!(Scale::over((8200.0, 8200.0), 5.0).ticks.len() <= MOST_TICKS);
    }
}
