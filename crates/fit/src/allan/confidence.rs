//! How far an Allan deviation can be trusted: equivalent degrees of freedom, and the chi-squared interval that they give.

use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// The confidence of every interval here.
pub const LEVEL: f64 = 0.95;

/// A power law of the rate's spectrum, with the slope that it gives the Allan deviation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Noise {
    /// Slope -1: quantization; white noise of the angle.
    Quantization,
    /// Slope -1/2: white noise of the rate, which makes the angle walk.
    AngleRandomWalk,
    /// Slope 0: flicker of the rate.
    BiasInstability,
    /// Slope +1/2: a walk of the rate.
    RateRandomWalk,
    /// Whatever it is, through the gyro's own low-pass filter: samples resemble their neighbours.
    Filtered,
}

/// Equivalent degrees of freedom of the overlapping Allan variance (NIST SP 1065, 5.4.1, table 5, after Howe, Allan and
/// Barnes, 1981). There `N` is the number of phase points, which is two averaging factors more than there are differences;
/// with gaps it is that of a record without gaps that has as many. At least 1: for the longest averages the approximations
/// fall below what a single difference has.
pub(super) fn degrees_of_freedom(noise: Noise, differences: u64, m: usize) -> f64 {
    let m = m as f64;
    let n = differences as f64 + 2.0 * m;
    let degrees = match noise {
        Noise::Quantization => (n + 1.0) * (n - 2.0 * m) / (2.0 * (n - m)),
        Noise::AngleRandomWalk => {
            (3.0 * (n - 1.0) / (2.0 * m) - 2.0 * (n - 2.0) / n) * 4.0 * m * m / (4.0 * m * m + 5.0)
        }
        Noise::BiasInstability if m < 1.5 => 2.0 * (n - 2.0).powi(2) / (2.3 * n - 4.9),
        Noise::BiasInstability => 5.0 * n * n / (4.0 * m * (n + 3.0 * m)),
        // For less than the filter's length what is filtered goes as a walk does, by steps that know nothing of each other.
        Noise::RateRandomWalk | Noise::Filtered => {
            (n - 2.0) / m * ((n - 1.0).powi(2) - 3.0 * m * (n - 1.0) + 4.0 * m * m) / (n - 3.0).powi(2)
        }
    };
    if degrees.is_finite() { degrees.max(1.0) } else { 1.0 }
}

/// The interval that holds the true deviation with the confidence [`LEVEL`] (NIST SP 1065, 5.3.1): the variance times its
/// degrees of freedom over the true variance is chi-squared.
pub(super) fn interval(deviation: f64, degrees_of_freedom: f64) -> (f64, f64) {
    let aside = (1.0 - LEVEL) / 2.0;
    (bound(deviation, degrees_of_freedom, 1.0 - aside), bound(deviation, degrees_of_freedom, aside))
}

/// The true deviation whose records come out lower than this one with so much probability.
pub(super) fn bound(deviation: f64, degrees_of_freedom: f64, probability: f64) -> f64 {
    ChiSquared::new(degrees_of_freedom)
        .map_or(f64::NAN, |chi_squared| deviation * (degrees_of_freedom / chi_squared.inverse_cdf(probability)).sqrt())
}

/// How likely chance alone makes a variance so many times the true one, or more.
pub(super) fn beyond(ratio: f64, degrees_of_freedom: f64) -> f64 {
    // Of a true variance of 0 nothing is above it by chance.
    if !ratio.is_finite() {
        return 0.0;
    }
    ChiSquared::new(degrees_of_freedom).map_or(1.0, |chi_squared| chi_squared.sf(ratio * degrees_of_freedom))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables of the chi-squared distribution: 10 degrees, 2.5 % and 97.5 %: 3.247 and 20.483.
    #[test]
    fn the_interval_is_that_of_the_tables() {
        let (low, high) = interval(1.0, 10.0);
        assert!((low - (10.0_f64 / 20.483).sqrt()).abs() < 1e-4, "{low}");
        assert!((high - (10.0_f64 / 3.247).sqrt()).abs() < 1e-3, "{high}");
    }

    /// NIST SP 1065, table 31 (12.4): 1000 points, overlapping, averaging factor 10, white frequency noise: 146.177
    /// degrees of freedom for 1001 phase points.
    #[test]
    fn degrees_of_freedom_are_nists_example() {
        let degrees = degrees_of_freedom(Noise::AngleRandomWalk, 1001 - 20, 10);
        assert!((degrees - 146.177).abs() < 0.01, "{degrees}");
    }
}
