//! The one way in which a rate gets its unit for people: on a screen, in a page's tables and figures, and in sentences.

use super::{RateUnit, WrittenRate};

/// Rates below this are shown in thousandths of the unit, but for counts.
const SMALL: f64 = 0.1;

/// Powers of ten from which and up to which a number in a sentence is written without them.
const LEAST_PLAIN: i32 = -3;
const MOST_PLAIN: i32 = 5;

/// A unit for people, and how many of it make one of a calibration's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RateScale {
    name: &'static str,
    factor: f64,
}

impl RateScale {
    /// The unit for rates of this size: the one that was asked for, where rates can be told in it; else the calibration's own,
    /// or a thousandth of it. An acceleration is told in its own.
    #[must_use]
    pub fn of(unit: RateUnit, rates: &[f64], asked: Option<WrittenRate>) -> Self {
        if let Some((asked, one)) = asked.and_then(|asked| Some((asked, asked.in_unit(unit)?))) {
            return Self { name: asked.name(), factor: 1.0 / one };
        }
        let largest = rates.iter().fold(0.0_f64, |largest, rate| largest.max(rate.abs()));
        let thousandth = match unit {
            RateUnit::Dps => "mdps",
            RateUnit::RadPerS => "mrad/s",
            RateUnit::MetresPerS2 => "mm/s^2",
            RateUnit::Counts => "",
        };
        if !thousandth.is_empty() && largest < SMALL {
            return Self { name: thousandth, factor: 1e3 };
        }
        Self::own(unit)
    }

    /// The unit itself, as beside numbers that are in it.
    #[must_use]
    pub fn own(unit: RateUnit) -> Self {
        Self { name: unit.name(), factor: 1.0 }
    }

    /// The same for rates that are in another unit than the calibration's; `None` where they cannot be converted.
    #[must_use]
    pub fn of_rates_in(self, other: RateUnit, own: RateUnit) -> Option<Self> {
        other.in_unit(own).map(|one| Self { factor: self.factor * one, ..self })
    }

    /// A rate of the calibration in this unit.
    #[must_use]
    pub fn of_rate(self, rate: f64) -> f64 {
        self.factor * rate
    }

    /// A rate as it stands in a sentence, without its unit: four significant digits, so that two that are told apart differ.
    #[must_use]
    pub fn number(self, rate: f64) -> String {
        let rate = self.of_rate(rate);
        let written = format!("{rate:.3e}");
        match written.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok()) {
            Some(exponent @ LEAST_PLAIN..=MOST_PLAIN) => decimal(rate, usize::try_from(3 - exponent).unwrap_or(0)),
            _ => written,
        }
    }

    /// The same with its unit.
    #[must_use]
    pub fn told(self, rate: f64) -> String {
        format!("{} {}", self.number(rate), self.name)
    }

    /// A rate with its standard error and its unit: both to two digits of the error; without one where nothing scatters.
    #[must_use]
    pub fn with_error(self, rate: f64, error: f64) -> String {
        if error.abs() <= 0.0 {
            return self.told(rate);
        }
        let (rate, error) = (self.of_rate(rate), self.of_rate(error).abs());
        let written = format!("{error:.1e}");
        let exponent = written.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok());
        // Without an error that is a number, as many as a rate has alone.
        let places = exponent.map_or(3, |exponent| usize::try_from(1 - exponent).unwrap_or(0).min(12));
        format!("{} \u{b1} {error:.places$} {}", decimal(rate, places), self.name)
    }

    /// The unit's name.
    #[must_use]
    pub fn unit(self) -> &'static str {
        self.name
    }
}

/// Where temperatures go from and to, in tenths.
#[must_use]
pub fn from_to(least: f64, most: f64) -> String {
    format!("{} to {}", decimal(least, 1), decimal(most, 1))
}

/// A number with so many decimals; what is zero by then has no sign.
#[must_use]
pub fn decimal(number: f64, decimals: usize) -> String {
    let text = format!("{number:.decimals$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.bytes().all(|letter| b"0.".contains(&letter)) => zero.to_owned(),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_earths_rate_is_told_in_the_unit_that_was_asked_for() {
        // 15.041067 deg/h (IERS: 7.292115e-5 rad/s).
        for (asked, shown) in [
            (WrittenRate::DegPerHour, 15.041_067),
            (WrittenRate::MilliDps, 4.178_074),
            (WrittenRate::Dps, 4.178_074e-3),
            (WrittenRate::MilliRadPerS, 0.072_921_15),
        ] {
            let scale = RateScale::of(RateUnit::RadPerS, &[1.0], Some(asked));
            assert!((scale.of_rate(7.292_115e-5) / shown - 1.0).abs() < 1e-6, "{scale:?}");
            assert_eq!(scale.unit(), asked.to_string());
        }
    }

    #[test]
    fn the_earths_rate_in_rad_s_is_told_as_a_calibration_in_dps_tells_it() {
        let told =
            |asked| RateScale::of(RateUnit::Dps, &[1.0], asked).of_rates_in(RateUnit::RadPerS, RateUnit::Dps).unwrap();
        assert_eq!(told(Some(WrittenRate::DegPerHour)).told(7.292_115e-5), "15.04 deg/h");
        assert_eq!(told(None).told(7.292_115e-5), "0.004178 dps");
        let acceleration = RateScale::own(RateUnit::MetresPerS2);
        assert_eq!(acceleration.of_rates_in(RateUnit::RadPerS, RateUnit::MetresPerS2), None);
    }

    #[test]
    fn without_one_small_rates_are_in_thousandths_and_counts_never_are() {
        let of = |unit, size: f64| RateScale::of(unit, &[0.0, -size], None);
        assert_eq!((of(RateUnit::RadPerS, 0.004).unit(), of(RateUnit::RadPerS, 0.004).of_rate(0.004)), ("mrad/s", 4.0));
        assert_eq!([of(RateUnit::Dps, 3.0).unit(), of(RateUnit::Counts, 0.01).unit()], ["dps", "counts"]);
    }

    #[test]
    fn a_sentence_has_four_digits_of_a_rate() {
        let told = |unit, rate| RateScale::of(unit, &[rate], None).told(rate);
        assert_eq!(told(RateUnit::RadPerS, -6.2137e-4), "-0.6214 mrad/s");
        assert_eq!(told(RateUnit::RadPerS, 9.9996e-4), "1.000 mrad/s");
        assert_eq!(told(RateUnit::Dps, 12.3449), "12.34 dps");
        assert_eq!(told(RateUnit::Counts, 40_123.4), "40123 counts");
        assert_eq!(told(RateUnit::RadPerS, 2.5e-9), "2.500e-6 mrad/s");
        assert_eq!(told(RateUnit::Counts, f64::NAN), "NaN counts");
        assert_eq!(told(RateUnit::Counts, -0.0), "0.000 counts");
    }

    #[test]
    fn a_rate_is_told_to_two_digits_of_its_error() {
        let told = |rate, error| RateScale::own(RateUnit::Dps).with_error(rate, error);
        assert_eq!(told(-0.200_34, 0.004_96), "-0.2003 \u{b1} 0.0050 dps");
        assert_eq!(told(12.346, 1.51), "12.3 \u{b1} 1.5 dps");
        assert_eq!(told(1234.6, 151.0), "1235 \u{b1} 151 dps");
        assert_eq!(told(-0.200_34, 0.0), "-0.2003 dps");
        assert_eq!(told(1.0, f64::NAN), "1.000 \u{b1} NaN dps");
        assert_eq!(told(-0.000_4, 0.012), "0.000 \u{b1} 0.012 dps");
    }

    #[test]
    fn an_acceleration_is_in_no_unit_of_rates() {
        let scale = RateScale::of(RateUnit::MetresPerS2, &[0.02], Some(WrittenRate::Dps));
        assert_eq!((scale.unit(), scale.of_rate(0.02)), ("mm/s^2", 20.0));
    }
}
