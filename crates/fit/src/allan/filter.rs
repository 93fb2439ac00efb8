//! Where a gyro's own low-pass filter ends: below that the curve is the filter's, and no noise is to be read off it.
//!
//! A sum of powers of the averaging time bends upwards only. A curve that falls more steeply as the averaging time grows is
//! therefore of another making at its short end: samples that are filtered resemble their neighbours, and differ by less
//! than the noise at longer times says.

use super::AllanPoint;

/// What white noise of the rate has.
const WHITE: f64 = -0.5;

/// Standard errors of a slope by which it may be off, and of two by which they differ beyond chance.
const MAY_BE_OFF: f64 = 2.0;
const DIFFER: f64 = 3.0;

/// The slope of the curve over an octave, in logarithms.
#[derive(Clone, Copy)]
struct Slope {
    value: f64,
    error: f64,
}

impl Slope {
    /// From a point to the first that has twice its averaging time.
    fn from(points: &[AllanPoint], first: usize) -> Option<Self> {
        let a = points[first];
        let b = points[first..].iter().find(|b| b.tau_s >= 2.0 * a.tau_s * (1.0 - 1e-9))?;
        let octave = libm::log(b.tau_s / a.tau_s);
        // A variance of so many degrees of freedom has a relative variance of two over them, its root a quarter of that.
        let error = (0.5 / a.degrees_of_freedom + 0.5 / b.degrees_of_freedom).sqrt() / octave;
        Some(Self { value: libm::log(b.deviation / a.deviation) / octave, error })
    }

    fn may_be_white(self) -> bool {
        self.value - MAY_BE_OFF * self.error <= WHITE
    }

    fn is_above(self, other: Self) -> bool {
        self.value - other.value > DIFFER * self.error.hypot(other.error)
    }
}

/// The first point that is no longer a filter's; 0 where there is none.
pub(super) fn end(points: &[AllanPoint]) -> usize {
    let slopes: Vec<Slope> = (0..points.len()).map_while(|first| Slope::from(points, first)).collect();
    let first = slopes.iter().position(|slope| slope.may_be_white());
    first.filter(|first| slopes[..*first].iter().any(|before| before.is_above(slopes[*first]))).unwrap_or(0)
}
