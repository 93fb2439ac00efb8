//! The thermal path of one gyro: chamber air -> package -> die.
//!
//! Each step is a first-order lag. The temperature sensor reads the package and the zero-rate output follows the die:
//! the difference of the two while the temperature moves is where hysteresis comes from.

/// The thermal path's constants.
#[derive(Debug, Clone, PartialEq)]
pub struct ThermalParameters {
    /// The package's time constant behind the chamber's air, in seconds. Default 150 (assumed: a small board in moving
    /// air).
    pub package_time_constant_s: f64,
    /// The die's time constant behind the package, in seconds. Paper's plant 2, a ceramic package (assumed: the
    /// paper's heating and cooling cannot be told apart); typical units 2 to 15.
    pub die_time_constant_s: f64,
    /// How much warmer than the air a powered package settles, in kelvins. Paper's plant 0.5, so that its readings at
    /// -40 and +60 C stay within a soak's tolerance of 8500 and 11 900 counts; typical units 0.5 to 2.
    pub self_heating_k: f64,
}

impl Default for ThermalParameters {
    fn default() -> Self {
        Self { package_time_constant_s: 150.0, die_time_constant_s: 2.0, self_heating_k: 0.5 }
    }
}

/// A body that follows its surroundings with a first-order lag.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lag {
    /// The body's temperature in degrees C.
    pub(crate) temperature_c: f64,
}

impl Lag {
    /// Moves on by `dt_s` while the surroundings go on a straight line from `from_c` to `to_c`. This is the exact
    /// solution of `tau dT/dt = surroundings - T` for such a line, so the step may be longer than the time constant.
    pub(crate) fn follow(&mut self, from_c: f64, to_c: f64, time_constant_s: f64, dt_s: f64) {
        if dt_s <= 0.0 {
            return;
        }
        let behind_c = (to_c - from_c) / dt_s * time_constant_s;
        let fades = if time_constant_s > 0.0 { libm::exp(-dt_s / time_constant_s) } else { 0.0 };
        self.temperature_c = to_c - behind_c + (self.temperature_c - from_c + behind_c) * fades;
    }
}

/// Package and die of one gyro.
#[derive(Debug, Clone)]
pub(crate) struct ThermalPath {
    parameters: ThermalParameters,
    package: Lag,
    die: Lag,
}

impl ThermalPath {
    /// A path that has settled, powered, in air of the given temperature.
    pub(crate) fn settled(parameters: ThermalParameters, air_c: f64) -> Self {
        let body = Lag { temperature_c: air_c + parameters.self_heating_k };
        Self { parameters, package: body, die: body }
    }

    pub(crate) fn package_c(&self) -> f64 {
        self.package.temperature_c
    }

    pub(crate) fn die_c(&self) -> f64 {
        self.die.temperature_c
    }

    /// Moves on by `dt_s` while the air goes from `from_c` to `to_c`.
    pub(crate) fn advance(&mut self, from_c: f64, to_c: f64, dt_s: f64) {
        let ThermalParameters { package_time_constant_s, die_time_constant_s, self_heating_k } = self.parameters;
        let package_before_c = self.package_c();
        self.package.follow(from_c + self_heating_k, to_c + self_heating_k, package_time_constant_s, dt_s);
        self.die.follow(package_before_c, self.package_c(), die_time_constant_s, dt_s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Heats from 0 C at 0.05 K/s for 1500 s in steps of `dt_s`; gives the package and how far the die is behind it.
    fn heated(die_time_constant_s: f64, dt_s: f64) -> (f64, f64) {
        let parameters = ThermalParameters { die_time_constant_s, self_heating_k: 0.0, ..ThermalParameters::default() };
        let mut path = ThermalPath::settled(parameters, 0.0);
        let mut time_s = 0.0;
        while time_s < 1500.0 - dt_s / 2.0 {
            path.advance(0.05 * time_s, 0.05 * (time_s + dt_s), dt_s);
            time_s += dt_s;
        }
        (path.package_c(), path.package_c() - path.die_c())
    }

    #[test]
    fn on_a_ramp_each_body_is_its_time_constant_times_the_slope_behind() {
        let (package_c, behind_k) = heated(4.0, 0.1);
        assert!((75.0 - package_c - 150.0 * 0.05).abs() < 0.01, "{package_c}");
        assert!((behind_k - 4.0 * 0.05).abs() < 0.001, "{behind_k}");
    }

    #[test]
    fn a_die_without_lag_is_at_the_package() {
        assert!(heated(0.0, 0.1).1.abs() < 1e-12);
    }

    #[test]
    fn the_step_does_not_matter() {
        let (fine, coarse) = (heated(4.0, 0.1), heated(4.0, 1.0));
        assert!((fine.0 - coarse.0).abs() < 0.01 && (fine.1 - coarse.1).abs() < 0.001, "{fine:?} {coarse:?}");
    }

    #[test]
    fn a_powered_package_settles_above_the_air() {
        let path = ThermalPath::settled(ThermalParameters::default(), -40.0);
        assert!((path.package_c() + 39.5).abs() < 1e-12);
    }
}
