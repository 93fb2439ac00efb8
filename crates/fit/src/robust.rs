//! Statistics that a few outliers cannot move.

use crate::line::Line;

/// The median absolute deviation times this is the standard deviation of a normal distribution: 1 / 0.6745.
pub const MAD_TO_SIGMA: f64 = 1.4826;

/// The mean absolute deviation times this is the standard deviation of a normal distribution: sqrt(pi / 2).
const MEAN_DEVIATION_TO_SIGMA: f64 = 1.2533;

/// A residual of more than this many standard deviations counts less (Huber, 1964): 1.345 would lose 5 % on clean data; 2
/// loses 1 %, and conditioning has already taken out the outliers.
pub(crate) const HUBER: f64 = 2.0;

/// The median, as numpy's: of an even number the mean of the two in the middle; NaN of none. The values are reordered.
pub fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let even = values.len().is_multiple_of(2);
    let (below, &mut upper, _) = values.select_nth_unstable_by(values.len() / 2, f64::total_cmp);
    let lower = below.iter().copied().max_by(f64::total_cmp).filter(|_| even);
    lower.map_or(upper, |lower| lower.midpoint(upper))
}

/// The median and the standard deviation about it by the median absolute deviation.
///
/// Where more than half the values are equal, as with a coarse A/D, that deviation is 0 and the mean one is taken.
pub fn centre_and_sigma(values: &[f64]) -> (f64, f64) {
    let centre = median(&mut values.to_vec());
    let mut deviations: Vec<f64> = values.iter().map(|value| (value - centre).abs()).collect();
    let mean = deviations.iter().sum::<f64>() / deviations.len() as f64;
    let sigma = MAD_TO_SIGMA * median(&mut deviations);
    (centre, if sigma > 0.0 { sigma } else { MEAN_DEVIATION_TO_SIGMA * mean })
}

/// The standard deviation of white noise that successive values carry, whatever their trend: that of their second
/// differences over sqrt(1 + 4 + 1). A trend leaves no deviation from a running median, so that alone would be too small.
pub fn noise(values: &[f64]) -> f64 {
    let differences: Vec<f64> = values.windows(3).map(|v| v[0] - 2.0 * v[1] + v[2]).collect();
    if differences.is_empty() {
        return 0.0;
    }
    centre_and_sigma(&differences).1 / 6.0_f64.sqrt()
}

/// The line through points, drawn to a place, and how uncertain a point is there by how far they are from it.
#[must_use]
pub fn extrapolated(points: &[(f64, f64)], place: f64) -> (f64, f64) {
    let line = Line::through(points);
    let mut off: Vec<f64> = points.iter().map(|point| line.off(*point).abs()).collect();
    (line.at(place), MAD_TO_SIGMA * median(&mut off) * (1.0 + line.leverage(place)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[allow(clippy::float_cmp)]
    fn a_median_is_numpys() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        // numpy.median([4.0, 1.0, 3.0, 2.5]), and of one and of two.
        assert_eq!(median(&mut [4.0, 1.0, 3.0, 2.5]), 2.75);
        assert_eq!(median(&mut [7.0]), 7.0);
        assert_eq!(median(&mut [9.0, 7.0]), 8.0);
        assert!(median(&mut []).is_nan());
    }
}
