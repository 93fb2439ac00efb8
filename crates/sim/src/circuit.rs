//! The zero-adjust circuit of one axis (paper, fig. 1): the potentiometer's voltage less the rate signal, amplified,
//! set on a centre, low-passed.

use core::f64::consts::PI;

use crate::gyro::ROOM_C;

/// The circuit's constants.
///
/// `out = centre + gain (wiper - rate) + offset`, clipped to the rails, then a first-order low-pass. The amplifier takes
/// the wiper less the rate, so the reading falls as the rate's voltage rises and rises with the tap, as the paper's
/// slopes say.
#[derive(Debug, Clone, PartialEq)]
pub struct CircuitParameters {
    /// Volts out per volt of difference, at 25 C. Default for X 31.26 counts a tap, for Y 31.64 (paper, eq. 3 and 5),
    /// see [`Self::gain_of`].
    pub gain: f64,
    /// The gain's relative change per kelvin. Default 10e-6 (assumed: two thin-film resistors of one network).
    pub gain_tempco_per_k: f64,
    /// What the adder adds, in volts. Default 2.05: a reading of 8200 counts (paper, 2.3). Each board's is adjusted with
    /// the wiper at N0, so the potentiometer's own error at that tap is in it.
    pub centre_v: f64,
    /// A constant error at the output in volts. Default 0 (it is in the paper's equations already).
    pub offset_v: f64,
    /// The error's change in volts per kelvin of the board. Default 2e-6 (assumed: a precision amplifier's 1 uV/K, times
    /// the gain).
    pub offset_tempco_v_per_k: f64,
    /// The lowest voltage the amplifier reaches. Default 0.02 (a rail-to-rail part on 5 V).
    pub low_rail_v: f64,
    /// The highest voltage the amplifier reaches. Default 4.98; the A/D's reference, 4.096 V, is met before it.
    pub high_rail_v: f64,
    /// The low-pass's corner in hertz. Default 40 (the paper gives none; well below its 333.3 samples a second).
    pub cutoff_hz: f64,
    /// Noise behind the low-pass in volts rms, white from scan to scan. Default 125e-6: half a count (assumed), enough to
    /// dither the converter when nothing else does.
    pub noise_v: f64,
}

impl CircuitParameters {
    /// The circuit with the given gain and everything else at its default.
    #[must_use]
    pub fn with_gain(gain: f64) -> Self {
        Self {
            gain,
            gain_tempco_per_k: 10e-6,
            centre_v: 2.05,
            offset_v: 0.0,
            offset_tempco_v_per_k: 2e-6,
            low_rail_v: 0.02,
            high_rail_v: 4.98,
            cutoff_hz: 40.0,
            noise_v: 125e-6,
        }
    }

    /// The gain that makes one of 1023 steps of a 5 V potentiometer move a 250 uV converter by so many counts.
    #[must_use]
    pub fn gain_of(counts_per_tap: f64) -> f64 {
        counts_per_tap * 250e-6 / (5.0 / 1023.0)
    }

    /// The amplifier's output in volts, before the low-pass.
    pub(crate) fn output_v(&self, wiper_v: f64, rate_v: f64, board_c: f64) -> f64 {
        let above_room_k = board_c - ROOM_C;
        let gain = self.gain * (1.0 + self.gain_tempco_per_k * above_room_k);
        let offset_v = self.offset_v + self.offset_tempco_v_per_k * above_room_k;
        (self.centre_v + gain * (wiper_v - rate_v) + offset_v).clamp(self.low_rail_v, self.high_rail_v)
    }

    /// How much of a difference is left in the low-pass after `dt_s`.
    pub(crate) fn left_after(&self, dt_s: f64) -> f64 {
        libm::exp(-dt_s * 2.0 * PI * self.cutoff_hz)
    }

    /// The bandwidth in hertz of a rectangular filter that lets as much white noise through: pi/2 of the corner.
    pub(crate) fn noise_bandwidth_hz(&self) -> f64 {
        PI / 2.0 * self.cutoff_hz
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_output_rises_with_the_wiper_falls_with_the_rate_and_stops_at_the_rails() {
        let circuit = CircuitParameters::with_gain(CircuitParameters::gain_of(31.26));
        let at = |wiper_v, rate_v| circuit.output_v(wiper_v, rate_v, ROOM_C);
        assert!((at(2.5, 2.5) - 2.05).abs() < 1e-12);
        let tap_v = 5.0 / 1023.0;
        assert!(((at(2.5 + tap_v, 2.5) - 2.05) / 250e-6 - 31.26).abs() < 1e-9);
        assert!((at(2.5, 2.5 + tap_v) - 2.05) < 0.0);
        assert!((at(5.0, 2.5) - 4.98).abs() < 1e-12 && (at(0.0, 2.5) - 0.02).abs() < 1e-12);
    }
}
