//! The unit in which rates are shown.

use zerorate_cal::units::RateUnit;

/// Rates below this are shown in thousandths of the unit, but for counts.
const SMALL: f64 = 0.1;

/// A unit and how many of it make one of a log's.
#[derive(Debug, Clone, Copy)]
pub struct RateScale {
    unit: RateUnit,
    thousandths: bool,
}

impl RateScale {
    /// The unit for rates of this size.
    pub fn of(unit: RateUnit, rates: &[f64]) -> Self {
        let largest = rates.iter().fold(0.0_f64, |largest, rate| largest.max(rate.abs()));
        Self { unit, thousandths: unit != RateUnit::Counts && largest < SMALL }
    }

    /// A rate of the log in this unit.
    pub fn of_rate(self, rate: f64) -> f64 {
        if self.thousandths { 1e3 * rate } else { rate }
    }

    /// The unit's name.
    pub fn unit(self) -> String {
        format!("{}{}", if self.thousandths { "m" } else { "" }, self.unit)
    }
}
