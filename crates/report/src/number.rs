//! Numbers as they are written for people: a real minus sign, thin spaces, powers of ten raised.

use maud::{Markup, html};

/// A number with so many decimals; an en dash when it is none.
pub(super) fn fixed(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return "\u{2013}".to_owned();
    }
    set(&format!("{:.decimals$}", value.abs()), value < 0.0)
}

/// A number in the fewest digits that give it back, as people write a limit; an en dash when it is none.
pub(super) fn exact(value: f64) -> String {
    if value.is_finite() { set(&value.abs().to_string(), value < 0.0) } else { "\u{2013}".to_owned() }
}

/// So many of what is counted, as `1 unit`, `2 units`.
pub(super) fn counted(count: usize, noun: &str) -> String {
    format!("{} {noun}{}", whole(count as u64), if count == 1 { "" } else { "s" })
}

/// Digits with a sign and thousands set apart.
fn set(digits: &str, negative: bool) -> String {
    let (whole, fraction) = digits.split_once('.').map_or((digits, None), |(a, b)| (a, Some(b)));
    let mut text = String::new();
    if negative && digits.bytes().any(|digit| (b'1'..=b'9').contains(&digit)) {
        text.push('\u{2212}');
    }
    // Four digits are read at a glance; from five on, thousands are set apart.
    for (place, digit) in whole.chars().enumerate() {
        if place > 0 && whole.len() > 4 && (whole.len() - place) % 3 == 0 {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    if let Some(fraction) = fraction {
        text.push('.');
        text.push_str(fraction);
    }
    text
}

/// A whole number.
pub(super) fn whole(value: u64) -> String {
    fixed(value as f64, 0)
}

/// A number to so many significant digits, as a power of ten where it is far from one.
pub(super) fn significant(value: f64, digits: usize) -> Markup {
    let decimal = |exponent: i32| {
        let decimals = usize::try_from(digits as i64 - 1 - i64::from(exponent)).unwrap_or(0);
        fixed(value, decimals)
    };
    match exponent_of(value, digits) {
        None => html! { (fixed(value, 0)) },
        Some(exponent) if (-3..7).contains(&exponent) => html! { (decimal(exponent)) },
        Some(exponent) => {
            let mantissa = fixed(value / 10_f64.powi(exponent), digits - 1);
            html! { (mantissa) "\u{a0}×\u{a0}10" sup { (fixed(f64::from(exponent), 0)) } }
        }
    }
}

/// The same as plain text, for places without markup.
pub(super) fn significant_text(value: f64, digits: usize) -> String {
    match exponent_of(value, digits) {
        Some(exponent) if !(-4..7).contains(&exponent) => format!("{:.*e}", digits - 1, value).replace('-', "\u{2212}"),
        Some(exponent) => fixed(value, usize::try_from(digits as i64 - 1 - i64::from(exponent)).unwrap_or(0)),
        None => fixed(value, 0),
    }
}

/// The power of ten of the first digit once rounded; none for zero and what is no number.
fn exponent_of(value: f64, digits: usize) -> Option<i32> {
    if !value.is_finite() {
        return None;
    }
    let text = format!("{:.*e}", digits.max(1) - 1, value);
    let (mantissa, exponent) = text.split_once('e')?;
    if mantissa.bytes().all(|byte| matches!(byte, b'0' | b'.' | b'-')) {
        return None;
    }
    exponent.parse().ok()
}

/// The power of a thousand in which values up to `largest` are best written, and the unit with it: tables of small rates
/// are read more easily in 10⁻³ rad/s than with a power of ten in each cell.
// A double's exponent is within 400.
#[allow(clippy::cast_possible_truncation)]
pub(super) fn thousandfold(largest: f64, unit: &str) -> (f64, String) {
    if !largest.is_finite() || largest <= 0.0 || (0.1..1e6).contains(&largest) {
        return (1.0, unit.to_owned());
    }
    let exponent = ((largest.log10() + 1.0) / 3.0).floor() as i32 * 3;
    (10_f64.powi(exponent), format!("10{} {unit}", raised(exponent)))
}

/// A whole number in raised figures, for places without markup.
pub(super) fn raised(number: i32) -> String {
    let figures = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digit = |c: char| c.to_digit(10).map_or('⁻', |digit| figures[digit as usize]);
    number.to_string().chars().map(digit).collect()
}

/// Decimals with which a column whose smallest value is this shows three digits of it.
// Between 0 and 9.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub(super) fn decimals_for(smallest: f64) -> usize {
    if smallest.is_finite() && smallest > 0.0 { (2.0 - smallest.log10().floor()).clamp(0.0, 9.0) as usize } else { 3 }
}

/// A polynomial with raw coefficients, highest power first, as `0.894782 T² − ...`; digits are significant ones.
pub(super) fn polynomial(coefficients: &[f64], variable: &str, digits: usize) -> Markup {
    let mut terms: Vec<(usize, f64)> = coefficients.iter().copied().enumerate().collect();
    terms.reverse();
    html! {
        @for (place, (power, coefficient)) in terms.into_iter().enumerate() {
            @if place == 0 {
                @if coefficient < 0.0 { "\u{2212}" }
            } @else {
                @if coefficient < 0.0 { " \u{2212} " } @else { " + " }
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
    fn decimals_thousands_and_minus_signs_are_set_as_in_print() {
        assert_eq!(fixed(13_435.7, 1), "13\u{202f}435.7");
        assert_eq!(fixed(8200.0, 0), "8200");
        assert_eq!(fixed(-0.274_587, 3), "\u{2212}0.275");
        assert_eq!(fixed(-0.0001, 2), "0.00");
        assert_eq!(fixed(f64::NAN, 2), "\u{2013}");
        assert_eq!(whole(1_200_000), "1\u{202f}200\u{202f}000");
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
    fn a_table_of_small_rates_shares_one_power_of_a_thousand() {
        assert_eq!(thousandfold(4.1e-3, "rad/s"), (1e-3, "10⁻³ rad/s".to_owned()));
        assert_eq!(thousandfold(0.9, "deg/s"), (1.0, "deg/s".to_owned()));
        assert_eq!(thousandfold(0.02, "rad/s").1, "10⁻³ rad/s");
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
