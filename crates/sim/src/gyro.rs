//! One analogue gyro: rate out as a voltage, with a null that moves with the die's temperature.

use zerorate_core::units::Axis;

use crate::noise::{Flicker, Walk};
use crate::random::{Source, Stream};

/// The temperature at which tempcos are zero, in degrees C.
pub(crate) const ROOM_C: f64 = 25.0;

/// The gyro's constants. The part is of the ADXRS620's kind (Analog Devices: null 2.5 V, 6 mV/(deg/s), a temperature
/// output).
#[derive(Debug, Clone, PartialEq)]
pub struct GyroParameters {
    /// The null voltage of a settled die: volts per kelvin to the powers 0 to 3, over the die's temperature less 25 C.
    pub null_v: [f64; 4],
    /// The scale factor at 25 C in volts per deg/s. Default 6e-3 (data sheet).
    pub scale_v_per_dps: f64,
    /// The scale factor's relative change per kelvin. Default 3e-4 (data sheet: +-3 % over the range, typical).
    pub scale_tempco_per_k: f64,
    /// White noise in deg/s per root hertz. Default 0.015 (assumed, a good part of its class; the ADXRS620's sheet says
    /// 0.05).
    pub white_dps_per_root_hz: f64,
    /// Bias instability in deg/s: the floor of the Allan deviation over 0.664. Default 0.003 (assumed, 11 deg/h).
    pub flicker_dps: f64,
    /// Rate random walk in deg/s per root second. Default 3e-5: 0.0018 deg/s, 0.07 count, over an hour (assumed).
    pub rate_walk_dps_per_root_s: f64,
    /// Standard deviation of the offset drawn anew at each power-up, in deg/s. Default 0.026: one count on the paper's
    /// board (assumed).
    pub turn_on_dps: f64,
    /// The null's shift in deg/s per kelvin by which the package is warmer than the die: the package stresses the die.
    /// Paper's plant 0.05, typical units +-0.05 drawn (assumed).
    pub gradient_dps_per_k: f64,
}

impl GyroParameters {
    /// The part with the given null voltage and everything else at its default.
    #[must_use]
    pub fn with_null(null_v: [f64; 4]) -> Self {
        Self {
            null_v,
            scale_v_per_dps: 6e-3,
            scale_tempco_per_k: 3e-4,
            white_dps_per_root_hz: 0.015,
            flicker_dps: 0.003,
            rate_walk_dps_per_root_s: 3e-5,
            turn_on_dps: 0.026,
            gradient_dps_per_k: 0.05,
        }
    }
}

/// The gyro's state.
#[derive(Debug, Clone)]
pub(crate) struct Gyro {
    parameters: GyroParameters,
    /// The rate at which the platform turns, in deg/s.
    pub(crate) rate_dps: f64,
    turn_on_dps: f64,
    turn_on: Stream,
    flicker: Flicker,
    walk: Walk,
}

impl Gyro {
    pub(crate) fn new(parameters: GyroParameters, seed: u64, axis: Axis) -> Self {
        let stream = |source| Stream::of_axis(seed, source, axis);
        let mut gyro = Self {
            rate_dps: 0.0,
            turn_on_dps: 0.0,
            turn_on: stream(Source::TurnOn),
            flicker: Flicker::new(parameters.flicker_dps, stream(Source::Flicker)),
            walk: Walk::new(parameters.rate_walk_dps_per_root_s, stream(Source::RateWalk)),
            parameters,
        };
        gyro.power_up();
        gyro
    }

    /// Draws the turn-on offset of a new power-up.
    pub(crate) fn power_up(&mut self) {
        self.turn_on_dps = self.parameters.turn_on_dps * self.turn_on.normal();
    }

    /// Moves the slow noise on.
    pub(crate) fn advance(&mut self, dt_s: f64) {
        self.flicker.advance(dt_s);
        self.walk.advance(dt_s);
    }

    /// Volts per deg/s at a die temperature.
    pub(crate) fn scale_v_per_dps(&self, die_c: f64) -> f64 {
        self.parameters.scale_v_per_dps * (1.0 + self.parameters.scale_tempco_per_k * (die_c - ROOM_C))
    }

    /// The output in volts at rest, without noise: the null, the gradient's stress and this power-up's offset.
    pub(crate) fn at_rest_v(&self, package_c: f64, die_c: f64) -> f64 {
        let offset_dps = self.turn_on_dps + self.parameters.gradient_dps_per_k * (package_c - die_c);
        self.null_v(die_c) + self.scale_v_per_dps(die_c) * offset_dps
    }

    fn null_v(&self, die_c: f64) -> f64 {
        let x = die_c - ROOM_C;
        self.parameters.null_v.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
    }

    /// What the platform's turning adds to the output, in volts.
    pub(crate) fn rotation_v(&self, die_c: f64) -> f64 {
        self.scale_v_per_dps(die_c) * self.rate_dps
    }

    /// What the slow noise adds to the output at present, in volts.
    pub(crate) fn slow_noise_v(&self, die_c: f64) -> f64 {
        self.scale_v_per_dps(die_c) * (self.flicker.value() + self.walk.value())
    }

    /// The white noise's density in volts per root hertz.
    pub(crate) fn white_v_per_root_hz(&self) -> f64 {
        self.parameters.scale_v_per_dps * self.parameters.white_dps_per_root_hz
    }
}
