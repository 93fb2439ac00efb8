//! Numbers for people.

/// What is written where there is no number.
const NONE: &str = "-";
/// Smaller numbers are the rounding of larger ones, and are written as 0.
const LEAST: f64 = 1e-6;

/// A number to three significant digits.
pub fn significant(value: f64) -> String {
    aligned(&[value]).remove(0)
}

/// Numbers of one column, all with as many decimals: the largest has three significant digits at least and the smallest
/// two.
pub fn aligned(values: &[f64]) -> Vec<String> {
    let exponents = || values.iter().filter(|v| v.is_finite() && v.abs() > LEAST).map(|v| exponent(*v));
    let largest = exponents().max().map_or(0, |exponent| 2 - exponent);
    let smallest = exponents().min().map_or(0, |exponent| 1 - exponent);
    let decimals = usize::try_from(largest.max(smallest)).unwrap_or(0);
    let text = |value: &f64| if value.is_finite() { format!("{value:.decimals$}") } else { NONE.to_owned() };
    values.iter().map(text).collect()
}

/// The power of ten of the first of three significant digits.
fn exponent(value: f64) -> i32 {
    let written = format!("{value:.2e}");
    written.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0)
}

/// A count with its thousands set apart.
pub fn thousands(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        // Four digits are read at a glance.
        if place > 0 && digits.len() > 4 && (digits.len() - place).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_has_as_many_decimals_as_its_smallest_number_needs() {
        assert_eq!(aligned(&[20.44, 53.2, 10.7]), ["20.4", "53.2", "10.7"]);
        assert_eq!(aligned(&[4.151, 0.951, 1.4]), ["4.15", "0.95", "1.40"]);
        assert_eq!(aligned(&[0.0, f64::NAN, 8200.0]), ["0", "-", "8200"]);
        assert_eq!(aligned(&[3e-17, 0.0]), ["0", "0"]);
        assert_eq!(significant(0.00123), "0.00123");
        assert_eq!(significant(9.999), "10.0");
    }

    #[test]
    fn long_counts_have_their_thousands_set_apart() {
        assert_eq!([thousands(8379), thousands(1_200_000)], ["8379", "1 200 000"]);
    }
}
