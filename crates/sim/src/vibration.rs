//! A platform that vibrates: a rate to and fro at one frequency, as the circuit's low-pass lets it through.

use core::f64::consts::TAU;

/// A vibration about one axis, on for so long that the low-pass has settled on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vibration {
    /// Its amplitude in deg/s.
    pub rate_dps: f64,
    /// Its frequency in hertz. The gyro passes all of them: a part's own bandwidth is some kilohertz.
    pub hz: f64,
}

impl Vibration {
    /// What is seen of an amplitude of 1 behind a first-order low-pass at an instant.
    pub(crate) fn behind(self, cutoff_hz: f64, at_s: f64) -> f64 {
        let over = self.hz / cutoff_hz;
        let turned = (self.hz * at_s).fract() * TAU - libm::atan(over);
        libm::cos(turned) / libm::hypot(over, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the low-pass's own equation, `y' = w (x - y)`, in steps of a microsecond.
    #[test]
    fn it_is_what_a_low_pass_makes_of_it() {
        let vibration = Vibration { rate_dps: 1.0, hz: 333.0 };
        let (step_s, rate) = (1e-6, TAU * 40.0);
        let mut behind = 0.0;
        for step in 0..100_000 {
            let at_s = (f64::from(step) + 0.5) * step_s;
            behind += rate * step_s * ((TAU * 333.0 * at_s).cos() - behind);
            let expected = vibration.behind(40.0, at_s + 0.5 * step_s);
            assert!(step < 50_000 || (behind - expected).abs() < 1e-4, "{behind} for {expected}");
        }
    }
}
