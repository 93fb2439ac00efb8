//! The static law in f64, as the paper writes it: drift, then trim, then the nearest tap.

use crate::drift::{Coverage, Drift};
use crate::trim::Trim;
use crate::units::{Counts, Taps, TemperatureCode, TemperatureScale};

/// The static law of one axis: `N = N0 + a (V(T) - V0) + b` (eq. 6), held to whole taps with a dead band. Where the
/// effect of every tap was measured, it takes the place of the line: the tap is the one that brings `V(T)` nearest `V0`.
///
/// This is the reading that the integer law is compared with; the device does not run it in its loop.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticLaw {
    /// Zero-rate output at the middle tap over temperature, counts.
    pub drift: Drift,
    /// The trim part's model.
    pub trim: Trim,
    /// Dead band, taps: the wiper moves when the position is more than half a tap and this away from it.
    pub dead_band: f64,
    /// What a temperature code stands for.
    pub temperature_scale: TemperatureScale,
}

impl StaticLaw {
    /// The wiper position at a temperature code, a real number of taps. Outside the calibrated range the temperature
    /// is held at the nearer end.
    #[must_use]
    pub fn position(&self, code: TemperatureCode) -> f64 {
        self.trim.position(self.drift(code).0)
    }

    /// The zero-rate output at the middle tap at a temperature code, and where the code lies against the calibrated
    /// range.
    #[must_use]
    pub fn drift(&self, code: TemperatureCode) -> (Counts, Coverage) {
        let (zro, coverage) = self.drift.evaluate(self.temperature_scale.temperature(code));
        (Counts(zro), coverage)
    }

    /// The nearest tap at a temperature code; `None` where the part has no such tap.
    #[must_use]
    pub fn tap(&self, code: TemperatureCode) -> Option<Taps> {
        let nearest = libm::round(self.position(code));
        if !(0.0..=f64::from(Taps::LAST.get())).contains(&nearest) {
            return None;
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        // 0 to 1023, a whole number
        Taps::new(nearest as u16)
    }

    /// Whether the wiper, at `tap`, should move at a temperature code: the position is further than half a tap and
    /// the dead band away.
    #[must_use]
    pub fn leaves(&self, tap: Taps, code: TemperatureCode) -> bool {
        libm::fabs(self.position(code) - f64::from(tap.get())) > 0.5 + self.dead_band
    }

    /// The tap after a group at a temperature code, from the tap before it.
    #[must_use]
    pub fn next(&self, tap: Taps, code: TemperatureCode) -> Taps {
        if self.leaves(tap, code) { self.tap(code).unwrap_or(tap) } else { tap }
    }
}
