//! Whether the noise of the temperature would make the wiper chatter at the edges of the law.

use std::fmt;

use zerorate_core::drift::{Drift, ValidRange};
use zerorate_core::trim::TrimLine;

/// How many times the noise a dead band must be for the wiper to rest. The wiper comes back over a switching
/// temperature only when the noise overcomes the band twice over: 10 sigma.
pub const QUIET_SIGMAS: f64 = 5.0;

/// Pieces over which the slope is taken: secants of a drift of order 5 come within 0.2 % of its steepest tangent.
const PIECES: u32 = 4096;

/// A dead band that the noise overcomes. Each chatter is a step of a tap in the reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChatterWarning {
    /// The dead band, taps.
    pub dead_band: f64,
    /// The noise of the group temperature as it moves the law, taps rms.
    pub noise_taps: f64,
}

impl ChatterWarning {
    /// The least dead band that would be quiet, taps.
    #[must_use]
    pub fn quiet_dead_band(&self) -> f64 {
        QUIET_SIGMAS * self.noise_taps
    }
}

impl fmt::Display for ChatterWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the temperature's noise moves the law by {:.4} taps rms where it is steepest, and the dead band is {} taps: the wiper may chatter at a switching temperature; use a dead band of {:.3} taps or more, or longer groups",
            self.noise_taps,
            self.dead_band,
            // Rounded up: the advice is to be enough.
            (1e3 * self.quiet_dead_band()).ceil() / 1e3
        )
    }
}

/// The law's steepest slope over its valid range, taps per unit of temperature: `|a|` times the largest `|dV/dT|`.
#[must_use]
pub fn steepest_slope_taps(drift: &Drift, line: &TrimLine) -> f64 {
    steepest_slope(drift, drift.valid) * line.slope_taps_per_count().abs()
}

/// A drift's steepest slope over a range, per unit of temperature, without sign.
#[must_use]
pub fn steepest_slope(drift: &Drift, over: ValidRange) -> f64 {
    let step = (over.max() - over.min()) / f64::from(PIECES);
    let at = |piece: u32| drift.evaluate(over.min() + step * f64::from(piece)).0;
    (0..PIECES).map(|piece| (at(piece + 1) - at(piece)).abs()).fold(0.0, f64::max) / step
}

/// Warns when a dead band (taps) is less than [`QUIET_SIGMAS`] times the noise of the group temperature
/// (`noise_rms`, in the temperature's unit) at the law's steepest slope (`slope_taps`, taps per unit of temperature).
#[must_use]
pub fn chatter_warning(noise_rms: f64, slope_taps: f64, dead_band: f64) -> Option<ChatterWarning> {
    let warning = ChatterWarning { dead_band, noise_taps: noise_rms * slope_taps };
    (dead_band < warning.quiet_dead_band()).then_some(warning)
}
