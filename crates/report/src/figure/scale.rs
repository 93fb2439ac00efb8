//! The range of an axis, its ticks and their labels.

use crate::number::{fixed, raised};

/// An axis has as many ticks as this at least: with fewer, nobody can read a value between them.
const LEAST_TICKS: f64 = 4.0;

/// No axis has more ticks, whatever its range.
const MOST_TICKS: usize = 20;

/// The part of the range left empty at each end.
const MARGIN: f64 = 0.05;

/// An axis: its range, and its ticks.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scale {
    /// The least and the greatest value drawn.
    pub(super) range: (f64, f64),
    /// Values at the ticks, all within the range, and their labels.
    pub(super) ticks: Vec<(f64, String)>,
    /// Labels are values divided by ten to this power, a multiple of three.
    pub(super) exponent: i32,
}

/// The least and the greatest of the values that are numbers; none without any.
pub fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|value| value.is_finite()).fold(None, |extent, value| {
        let (min, max) = extent.unwrap_or((value, value));
        Some((value.min(min), value.max(max)))
    })
}

/// The range that holds all values that are numbers, with a little room; none without any.
pub fn holding(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let (min, max) = extent(values)?;
    // Equal values still need a span: a thousandth of them, or one if they are zero.
    let room = match (max > min, max.abs() > 0.0) {
        (true, _) => (max - min) * MARGIN,
        (false, true) => max.abs() * 1e-3,
        (false, false) => 1.0,
    };
    Some((min - room, max + room))
}

impl Scale {
    /// A scale over this range, or 0 to 1 without one, of about so many ticks.
    pub(super) fn over(range: Option<(f64, f64)>, wanted: f64) -> Self {
        let (min, max) = range.unwrap_or((0.0, 1.0));
        let mut step = nice_step((max - min) / wanted);
        // Half of 5, 2 or 1 is a round number too. Ends that are one double have no ticks however small the step.
        while (max / step).floor() - (min / step).ceil() + 1.0 < LEAST_TICKS
            && step > f64::EPSILON * max.abs().max(min.abs())
        {
            step /= 2.0;
        }
        Self::by((min, max), step)
    }

    /// A scale of numbers of things, from none to the most of `values`: its ticks are whole numbers.
    pub(super) fn counting(values: impl Iterator<Item = f64>, wanted: f64) -> Self {
        let most = extent(values).map_or(1.0, |(_, most)| most.max(1.0)) * (1.0 + MARGIN);
        Self::by((0.0, most), nice_step(most / wanted).max(1.0))
    }

    /// A scale over exactly this range with a tick at each multiple of `step`.
    fn by((min, max): (f64, f64), step: f64) -> Self {
        let largest = min.abs().max(max.abs());
        // Below a hundredth or from ten million on, zeros would hide the digits.
        let exponent = if (1e-2..1e7).contains(&largest) { 0 } else { thousands(largest) };
        let unit = 10_f64.powi(exponent);
        let decimals = decimals(step / unit);
        let last = (max / step).floor();
        // A range so narrow that its ends are the same double has no ticks at all.
        let numbers = std::iter::successors(Some((min / step).ceil()), |number| Some(number + 1.0));
        let numbers = numbers.take_while(|number| *number <= last).take(MOST_TICKS);
        // Adding 0 turns a negative zero into a plain one.
        let tick = |number: f64| (number * step + 0.0, fixed((number * step + 0.0) / unit, decimals));
        Self { range: (min, max), ticks: numbers.map(tick).collect(), exponent }
    }

    /// A scale of logarithms to base ten that holds all of `values` that are numbers: a tick a decade, and at twice and
    /// five times that where there are few. Labels are what the logarithms are of.
    // Decades are within 400.
    #[allow(clippy::cast_possible_truncation)]
    pub(super) fn decades(values: impl Iterator<Item = f64>) -> Self {
        let range = holding(values).unwrap_or((0.0, 1.0));
        let (first, last) = (range.0.floor().max(-400.0) as i32, range.1.ceil().min(400.0) as i32);
        let at = |factors: &[u32]| -> Vec<(f64, String)> {
            let decade = |decade: i32| factors.iter().map(move |factor| (decade, *factor));
            let ticks = (first..=last).flat_map(decade);
            let ticks =
                ticks.map(|(decade, factor)| (f64::from(decade) + libm::log10(f64::from(factor)), decade, factor));
            let within = ticks.filter(|(at, ..)| (range.0..=range.1).contains(at)).take(MOST_TICKS);
            within.map(|(at, decade, factor)| (at, decade_label(decade, factor))).collect()
        };
        let whole = at(&[1]);
        let ticks = if whole.len() as f64 >= LEAST_TICKS { whole } else { at(&[1, 2, 5]) };
        Self { range, ticks, exponent: 0 }
    }

    /// Where a value is on the axis: 0 at its start, 1 at its end.
    pub(super) fn share(&self, value: f64) -> f64 {
        (value - self.range.0) / (self.range.1 - self.range.0)
    }
}

/// A factor times ten to a power, in full where that is short.
fn decade_label(decade: i32, factor: u32) -> String {
    let value = || f64::from(factor) * 10_f64.powi(decade);
    match (decade, factor) {
        (0..=4, _) => fixed(value(), 0),
        (-1, _) => fixed(value(), 1),
        (-2, _) => fixed(value(), 2),
        (_, 1) => format!("10{}", raised(decade)),
        _ => format!("{factor}·10{}", raised(decade)),
    }
}

/// The power of a thousand below a value, as a power of ten.
// A double's exponent is within 400.
#[allow(clippy::cast_possible_truncation)]
fn thousands(value: f64) -> i32 {
    (libm::log10(value) / 3.0).floor().clamp(-100.0, 100.0) as i32 * 3
}

/// The least of 1, 2, 5 times a power of ten that is not below `least`.
fn nice_step(least: f64) -> f64 {
    let power = libm::pow(10.0, libm::log10(least).floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= least * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * power
}

/// Decimals that a multiple of `step` needs.
// Between 0 and 9.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn decimals(step: f64) -> usize {
    let first = (-libm::log10(step * (1.0 + 1e-9)).floor()).clamp(0.0, 9.0);
    // The half of 5 has a digit more.
    let digit = step * libm::pow(10.0, first);
    let more = if (digit - digit.round()).abs() > 1e-6 { 1.0 } else { 0.0 };
    (first + more) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: &Scale) -> Vec<&str> {
        scale.ticks.iter().map(|(_, label)| label.as_str()).collect()
    }

    #[test]
    fn ticks_are_round_numbers_within_the_range() {
        let scale = Scale::over(holding([8512.0, 11_890.0].into_iter()), 5.0);
        assert_eq!(labels(&scale), ["9000", "10\u{202f}000", "11\u{202f}000", "12\u{202f}000"]);
        assert!(scale.range.0 < 8512.0 && scale.range.1 > 11_890.0);
    }

    #[test]
    fn every_range_has_four_ticks_at_least_and_no_more_than_can_be_written() {
        for wanted in [4.5, 5.0, 7.0, 8.0] {
            for span in (1..2000).map(|part| f64::from(part) * 0.013) {
                for from in [-3.3, 0.0, 17.77, -span / 2.0] {
                    let scale = Scale::over(Some((from, from + span)), wanted);
                    assert!((4..=12).contains(&scale.ticks.len()), "{from} {span}: {:?}", labels(&scale));
                    let distinct: std::collections::BTreeSet<&str> = labels(&scale).into_iter().collect();
                    assert_eq!(distinct.len(), scale.ticks.len(), "{:?}", labels(&scale));
                }
            }
        }
        assert_eq!(labels(&Scale::over(Some((-0.9, 14.0)), 4.5)), ["0.0", "2.5", "5.0", "7.5", "10.0", "12.5"]);
    }

    #[test]
    fn a_scale_through_zero_has_a_zero_without_a_sign() {
        let scale = Scale::over(Some((-0.5, 0.5)), 5.0);
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
        let scale = Scale::over(Some((0.0, 0.004)), 5.0);
        assert_eq!((scale.exponent, labels(&scale)[1]), (-3, "1"));
    }

    #[test]
    fn logarithms_are_labelled_by_what_they_are_of() {
        assert_eq!(labels(&Scale::decades([0.0, 3.5].into_iter())), ["1", "10", "100", "1000"]);
        assert_eq!(labels(&Scale::decades([-4.6, -3.4].into_iter())), ["5·10⁻⁵", "10⁻⁴", "2·10⁻⁴"]);
        assert_eq!(labels(&Scale::decades([-1.7, 0.2].into_iter())), ["0.02", "0.05", "0.1", "0.2", "0.5", "1"]);
    }

    #[test]
    fn nothing_and_a_single_value_still_make_a_scale() {
        assert_eq!(holding([f64::NAN].into_iter()), None);
        assert_eq!(Scale::over(None, 5.0).range, (0.0, 1.0));
        let of_one = |value: f64| Scale::over(holding([value].into_iter()), 5.0);
        assert!(of_one(8200.0).range.0 < 8200.0 && of_one(8200.0).range.1 > 8200.0);
        assert!(!of_one(8200.0).ticks.is_empty() && !of_one(0.0).ticks.is_empty());
        assert!(Scale::over(Some((8200.0, 8200.0)), 5.0).ticks.len() <= MOST_TICKS);
    }
}
