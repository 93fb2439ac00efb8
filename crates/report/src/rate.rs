//! The one way in which a rate gets its unit for people: on a screen, in a page's tables and in its figures.

use zerorate_cal::log_fit::LogFit;
use zerorate_cal::units::{RateUnit, WrittenRate};

/// Rates below this are shown in thousandths of the unit, but for counts.
const SMALL: f64 = 0.1;

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
        Self { name: unit.name(), factor: 1.0 }
    }

    /// The unit for what a log's fit tells of its axes in this unit: that of their drifts.
    #[must_use]
    pub fn of_fit(fit: &LogFit, unit: RateUnit, asked: Option<WrittenRate>) -> Self {
        let axes = fit.axes.iter().filter(|axis| axis.calibration.rate_unit == unit);
        let drifts: Vec<f64> = axes.map(|axis| axis.calibration.measured_drift().peak_to_peak()).collect();
        Self::of(unit, &drifts, asked)
    }

    /// A rate of the calibration in this unit.
    #[must_use]
    pub fn of_rate(self, rate: f64) -> f64 {
        self.factor * rate
    }

    /// The unit's name.
    #[must_use]
    pub fn unit(self) -> &'static str {
        self.name
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
    fn without_one_small_rates_are_in_thousandths_and_counts_never_are() {
        let of = |unit, size: f64| RateScale::of(unit, &[0.0, -size], None);
        assert_eq!((of(RateUnit::RadPerS, 0.004).unit(), of(RateUnit::RadPerS, 0.004).of_rate(0.004)), ("mrad/s", 4.0));
        assert_eq!([of(RateUnit::Dps, 3.0).unit(), of(RateUnit::Counts, 0.01).unit()], ["dps", "counts"]);
    }

    #[test]
    fn an_acceleration_is_in_no_unit_of_rates() {
        let scale = RateScale::of(RateUnit::MetresPerS2, &[0.02], Some(WrittenRate::Dps));
        assert_eq!((scale.unit(), scale.of_rate(0.02)), ("mm/s^2", 20.0));
    }
}
