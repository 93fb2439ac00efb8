//! The thermal chamber: its air goes to the set point at a limited rate.

use core::f64::consts::TAU;

use zerorate_core::units::Celsius;

/// What the chamber can do.
#[derive(Debug, Clone, PartialEq)]
pub struct ChamberParameters {
    /// The coldest set point in degrees C. Default -60 (paper, 2.1: the chamber's range).
    pub coldest_c: f64,
    /// The hottest set point in degrees C. Default +150 (paper, 2.1).
    pub hottest_c: f64,
    /// The fastest heating in kelvins a minute. Default 2.5: -40 to +60 C in 40 minutes, so that the paper's hour holds
    /// the ramp and the settling after it (its figure 2 shows both; the rate itself is not printed).
    pub heating_k_per_min: f64,
    /// The fastest cooling in kelvins a minute. Default 2.5, as heating.
    pub cooling_k_per_min: f64,
    /// The amplitude of the regulation's ripple in kelvins. Default 0.1 (chambers promise +-0.1 to +-0.5 K in time,
    /// IEC 60068-3-5).
    pub ripple_k: f64,
    /// The period of that ripple in seconds. Default 180, a compressor's usual cycle (assumed).
    pub ripple_period_s: f64,
    /// The air at the start, in degrees C. Default 25.
    pub start_c: f64,
}

impl Default for ChamberParameters {
    fn default() -> Self {
        Self {
            coldest_c: -60.0,
            hottest_c: 150.0,
            heating_k_per_min: 2.5,
            cooling_k_per_min: 2.5,
            ripple_k: 0.1,
            ripple_period_s: 180.0,
            start_c: 25.0,
        }
    }
}

/// A set point that the chamber refuses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetPointOutside {
    /// What was asked for, in degrees C.
    pub asked_c: f64,
    /// The coldest that can be asked for, in degrees C.
    pub coldest_c: f64,
    /// The hottest that can be asked for, in degrees C.
    pub hottest_c: f64,
}

impl core::fmt::Display for SetPointOutside {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { asked_c, coldest_c, hottest_c } = self;
        write!(formatter, "a set point of {asked_c} C: this chamber goes from {coldest_c} to {hottest_c} C")
    }
}

impl core::error::Error for SetPointOutside {}

/// The chamber's state.
#[derive(Debug, Clone)]
pub(crate) struct Chamber {
    parameters: ChamberParameters,
    set_point_c: f64,
    /// The regulated air without its ripple.
    regulated_c: f64,
    /// Where in its period the ripple is, in seconds.
    ripple_s: f64,
}

impl Chamber {
    pub(crate) fn new(parameters: ChamberParameters) -> Self {
        let start_c = parameters.start_c;
        Self { parameters, set_point_c: start_c, regulated_c: start_c, ripple_s: 0.0 }
    }

    /// Takes a new set point, or refuses one outside the limits (and NaN).
    pub(crate) fn set_point(&mut self, set_point: Celsius) -> Result<(), SetPointOutside> {
        let ChamberParameters { coldest_c, hottest_c, .. } = self.parameters;
        if !(coldest_c..=hottest_c).contains(&set_point.0) {
            return Err(SetPointOutside { asked_c: set_point.0, coldest_c, hottest_c });
        }
        self.set_point_c = set_point.0;
        Ok(())
    }

    pub(crate) fn set_point_c(&self) -> f64 {
        self.set_point_c
    }

    /// The air's temperature, ripple included.
    pub(crate) fn air_c(&self) -> f64 {
        let ChamberParameters { ripple_k, ripple_period_s, .. } = self.parameters;
        self.regulated_c + ripple_k * libm::sin(TAU * self.ripple_s / ripple_period_s)
    }

    pub(crate) fn advance(&mut self, dt_s: f64) {
        let up_k = self.parameters.heating_k_per_min / 60.0 * dt_s;
        let down_k = self.parameters.cooling_k_per_min / 60.0 * dt_s;
        self.regulated_c += (self.set_point_c - self.regulated_c).clamp(-down_k, up_k);
        self.ripple_s = (self.ripple_s + dt_s) % self.parameters.ripple_period_s;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_air_ramps_to_the_set_point_at_the_rate_of_its_direction_and_stays() {
        let parameters = ChamberParameters { cooling_k_per_min: 1.0, ripple_k: 0.0, ..ChamberParameters::default() };
        let mut chamber = Chamber::new(parameters);
        chamber.set_point(Celsius(30.0)).unwrap();
        chamber.advance(60.0);
        assert!((chamber.air_c() - 27.5).abs() < 1e-9);
        chamber.advance(600.0);
        assert!((chamber.air_c() - 30.0).abs() < 1e-9);
        chamber.set_point(Celsius(-40.0)).unwrap();
        chamber.advance(120.0);
        assert!((chamber.air_c() - 28.0).abs() < 1e-9);
    }

    #[test]
    fn the_air_ripples_about_the_set_point() {
        let mut chamber = Chamber::new(ChamberParameters::default());
        let mut extremes = (f64::MAX, f64::MIN);
        for _ in 0..400 {
            chamber.advance(1.0);
            extremes = (extremes.0.min(chamber.air_c()), extremes.1.max(chamber.air_c()));
        }
        assert!((extremes.0 - 24.9).abs() < 1e-3 && (extremes.1 - 25.1).abs() < 1e-3, "{extremes:?}");
    }

    #[test]
    fn a_set_point_outside_the_limits_is_refused_and_changes_nothing() {
        let mut chamber = Chamber::new(ChamberParameters::default());
        for asked_c in [-60.1, 150.1, f64::NAN, f64::INFINITY] {
            let refusal = chamber.set_point(Celsius(asked_c)).unwrap_err();
            assert!(refusal.to_string().contains("from -60 to 150 C"), "{refusal}");
        }
        assert!((chamber.set_point_c() - 25.0).abs() < 1e-12);
        chamber.set_point(Celsius(-60.0)).unwrap();
        chamber.set_point(Celsius(150.0)).unwrap();
    }
}
