//! Numbers as they are written for people. In a page they are set as in print: a real minus sign, thin spaces, powers of
//! ten raised. On a terminal they are plain, so that they can be searched and copied.

use maud::{Markup, html};
use zerorate_cal::units::decimal;

/// What a page has where there is no number.
const NONE: &str = "\u{2013}";
/// In a column of a terminal, numbers smaller than this part of the largest are its rounding, and have no say in decimals;
/// and so are numbers smaller than this, of whatever column.
const ROUNDING: (f64, f64) = (1e-5, 1e-12);
/// With more decimals than this a column is written in powers of ten.
const MOST_DECIMALS: usize = 6;

/// For a page: a number with so many decimals; an en dash when it is none.
pub(crate) fn fixed(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    let text = decimal(value, decimals);
    set(text.trim_start_matches('-'), text.starts_with('-'))
}

/// How many times smaller something has become; less than a twentieth of a change is told as none, and a loss as one.
pub(crate) fn times_smaller(ratio: f64) -> String {
    match ratio {
        ratio if (1.0 / 1.05..1.05).contains(&ratio) => "the same, within 5 %".to_owned(),
        ratio if ratio < 1.0 => format!("{}, worse", fixed(ratio, 2)),
        ratio => fixed(ratio, 1),
    }
}

/// For a page: the same of a number that may not be known.
pub(crate) fn fixed_or_none(value: Option<f64>, decimals: usize) -> String {
    fixed(value.unwrap_or(f64::NAN), decimals)
}

/// For a page: a number in the fewest digits that give it back, as people write a limit; an en dash when it is none.
pub(crate) fn exact(value: f64) -> String {
    if value.is_finite() { set(&value.abs().to_string(), value < 0.0) } else { NONE.to_owned() }
}

/// For a page: a number with its standard error, where that is known, both with so many decimals; none where nothing scatters.
pub(crate) fn with_error(value: f64, error: Option<f64>, decimals: usize) -> String {
    /// Half of the last decimal rounds to it.
    const HALF: f64 = 0.5;
    let last = libm::pow(10.0, -(decimals as f64));
    let error = error.filter(|error| *error > 0.0 || error.is_nan()).map(|error| {
        let (below, error) = if error < HALF * last { ("<\u{a0}", last) } else { ("", error) };
        format!("\u{a0}±\u{a0}{below}{}", fixed(error, decimals))
    });
    fixed(value, decimals) + &error.unwrap_or_default()
}

/// For a page: a whole number.
pub(crate) fn whole(value: u64) -> String {
    set(&value.to_string(), false)
}

/// For a page and a terminal: so many of what is counted, as `1 unit`, `2 units`.
#[must_use]
pub fn counted(count: usize, noun: &str) -> String {
    format!("{} {noun}{}", whole(count as u64), if count == 1 { "" } else { "s" })
}

/// For a terminal: a whole number.
#[must_use]
pub fn thousands(count: u64) -> String {
    grouped(&count.to_string(), ' ')
}

/// For a terminal: numbers of one column, all with as many decimals: the largest has three significant digits at least
/// and the smallest two. Numbers far below one are powers of ten. What is no number is a hyphen.
#[must_use]
pub fn aligned(values: &[f64]) -> Vec<String> {
    let most = values.iter().filter(|value| value.is_finite()).fold(0.0_f64, |most, value| most.max(value.abs()));
    let least = ROUNDING.1.max(ROUNDING.0 * most);
    let exponents = || values.iter().filter(|value| value.abs() > least).filter_map(|value| exponent(*value, 3));
    let (largest, smallest) = (exponents().max(), exponents().min());
    let decimals = largest.map_or(0, |it| decimals(it, 3)).max(smallest.map_or(0, |it| decimals(it, 2)));
    let text = |value: &f64| match value {
        value if !value.is_finite() => "-".to_owned(),
        value if decimals > MOST_DECIMALS && value.abs() > least => format!("{value:.2e}"),
        _ if decimals > MOST_DECIMALS => "0".to_owned(),
        value => decimal(*value, decimals),
    };
    values.iter().map(text).collect()
}

/// For a terminal: a number to three significant digits.
#[must_use]
pub fn three_digits(value: f64) -> String {
    aligned(&[value]).remove(0)
}

/// Digits with a sign and thousands set apart.
fn set(digits: &str, negative: bool) -> String {
    let (whole, fraction) = digits.split_at(digits.find('.').unwrap_or(digits.len()));
    format!("{}{}{fraction}", if negative { "\u{2212}" } else { "" }, grouped(whole, '\u{202f}'))
}

/// Whole digits with thousands set apart, from five on: four are read at a glance.
fn grouped(digits: &str, space: char) -> String {
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && digits.len() > 4 && (digits.len() - place).is_multiple_of(3) {
            text.push(space);
        }
        text.push(digit);
    }
    text
}

/// The power of ten of the first of so many digits, once rounded; none for zero and what is no number.
fn exponent(value: f64, digits: usize) -> Option<i32> {
    let text = format!("{:.*e}", digits - 1, value);
    let (mantissa, exponent) = text.split_once('e')?;
    mantissa.bytes().any(|byte| (b'1'..=b'9').contains(&byte)).then(|| exponent.parse().ok())?
}

/// Decimals with which a number whose first digit is at this power of ten shows so many digits.
fn decimals(exponent: i32, digits: usize) -> usize {
    usize::try_from(digits as i64 - 1 - i64::from(exponent)).unwrap_or(0)
}

/// For a page: a number to so many significant digits, as a power of ten where it is far from one.
pub(crate) fn significant(value: f64, digits: usize) -> Markup {
    match exponent(value, digits) {
        None => html! { (fixed(value, 0)) },
        Some(exponent) if (-3..7).contains(&exponent) => html! { (fixed(value, decimals(exponent, digits))) },
        Some(exponent) => html! {
            (fixed(value / 10_f64.powi(exponent), digits - 1)) "\u{a0}×\u{a0}10" sup { (fixed(f64::from(exponent), 0)) }
        },
    }
}

/// The same as plain text, for places without markup.
pub(crate) fn significant_text(value: f64, digits: usize) -> String {
    match exponent(value, digits) {
        Some(exponent) if !(-4..7).contains(&exponent) => format!("{:.*e}", digits - 1, value).replace('-', "\u{2212}"),
        Some(exponent) => fixed(value, decimals(exponent, digits)),
        None => fixed(value, 0),
    }
}

/// A whole number in raised figures, for places without markup.
pub(crate) fn raised(number: i32) -> String {
    let figures = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digit = |c: char| c.to_digit(10).map_or('⁻', |digit| figures[digit as usize]);
    number.to_string().chars().map(digit).collect()
}

/// Decimals with which a column of a page whose smallest value is this shows three digits of it.
pub(crate) fn decimals_for(smallest: f64) -> usize {
    exponent(smallest, 3).map_or(3, |exponent| decimals(exponent, 3).min(9))
}

/// For a page: a polynomial with raw coefficients, highest power first, as `0.894782 T² − ...`; digits are significant ones.
pub(crate) fn polynomial(coefficients: &[f64], variable: &str, digits: usize) -> Markup {
    html! {
        @for (power, coefficient) in coefficients.iter().enumerate().rev() {
            @let first = power + 1 == coefficients.len();
            @match (first, *coefficient < 0.0) {
                (true, true) => "\u{2212}",
                (true, false) => "",
                (false, true) => " \u{2212} ",
                (false, false) => " + ",
            }
            span.nobr {
                (significant(coefficient.abs(), digits))
                @if power > 0 { "\u{a0}" i { (variable) } }
                @if power > 1 { sup { (power) } }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_gain_is_told_as_the_same_and_a_loss_as_one() {
        let same = "the same, within 5 %";
        let told = [1.0, 1.04, 0.97, 0.4, 1.5, 12.34].map(times_smaller);
        assert_eq!(told, [same, same, same, "0.40, worse", "1.5", "12.3"]);
    }

    #[test]
    fn decimals_thousands_and_minus_signs_are_set_as_in_print() {
        assert_eq!(fixed(13_435.7, 1), "13\u{202f}435.7");
        assert_eq!(fixed(8200.0, 0), "8200");
        assert_eq!(fixed(-0.274_587, 3), "\u{2212}0.275");
        assert_eq!(fixed(-0.0001, 2), "0.00");
        assert_eq!(fixed(f64::NAN, 2), "\u{2013}");
        assert_eq!(whole(1_200_000), "1\u{202f}200\u{202f}000");
    }

    #[test]
    fn on_a_terminal_a_column_has_as_many_decimals_as_its_smallest_number_needs() {
        assert_eq!(aligned(&[1.5, -1e-9]), ["1.50", "0.00"]);
        assert_eq!(aligned(&[20.44, 53.2, 10.7]), ["20.4", "53.2", "10.7"]);
        assert_eq!(aligned(&[4.151, 0.951, 1.4]), ["4.15", "0.95", "1.40"]);
        assert_eq!(aligned(&[0.0, f64::NAN, 8200.0]), ["0", "-", "8200"]);
        assert_eq!(aligned(&[3e-17, 0.0]), ["0", "0"]);
        assert_eq!(aligned(&[4.67e-7, 3e-17, 2.1e-8]), ["4.67e-7", "0", "2.10e-8"]);
        assert_eq!([0.00123, 9.999, -0.5].map(three_digits), ["0.00123", "10.0", "-0.500"]);
        assert_eq!([thousands(8379), thousands(1_200_000)], ["8379", "1 200 000"]);
    }

    #[test]
    fn limits_are_written_as_they_were_given() {
        assert_eq!(
            [5.0, 20.0, 0.5, 1500.0, -12_345.25].map(exact),
            ["5", "20", "0.5", "1500", "\u{2212}12\u{202f}345.25"]
        );
        assert_eq!((counted(1, "unit"), counted(0, "unit")), ("1 unit".to_owned(), "0 units".to_owned()));
    }

    #[test]
    fn small_numbers_are_written_as_powers_of_ten() {
        let text = significant(-0.375_298e-4, 6).into_string();
        assert_eq!(text, "\u{2212}3.75298\u{a0}×\u{a0}10<sup>\u{2212}5</sup>");
        assert_eq!(significant(13_435.7, 6).into_string(), "13\u{202f}435.7");
        assert_eq!(significant(0.0, 3).into_string(), "0");
        // Rounding may carry into the next power.
        assert_eq!(significant(9.999_99, 3).into_string(), "10.0");
    }

    #[test]
    fn the_smallest_of_a_column_has_three_digits_and_its_error_as_many_decimals() {
        assert_eq!(with_error(0.234, Some(0.02), 3), "0.234\u{a0}±\u{a0}0.020");
        assert_eq!(with_error(0.234, Some(3e-4), 3), "0.234\u{a0}±\u{a0}<\u{a0}0.001");
        assert_eq!(with_error(0.234, Some(0.0), 3), "0.234");
        assert_eq!(with_error(0.234, None, 2), "0.23");
        assert_eq!((decimals_for(0.234), decimals_for(24.1), decimals_for(f64::NAN)), (3, 1, 3));
    }

    #[test]
    fn a_polynomial_is_written_highest_power_first_with_its_signs() {
        let text = polynomial(&[13_435.7, -0.894_782, 0.375_298e-4], "T", 6).into_string();
        let plain = text.replace("<span class=\"nobr\">", "").replace("</span>", "");
        assert_eq!(
            plain,
            "3.75298\u{a0}×\u{a0}10<sup>\u{2212}5</sup>\u{a0}<i>T</i><sup>2</sup> \u{2212} 0.894782\u{a0}<i>T</i> + 13\u{202f}435.7"
        );
    }
}
