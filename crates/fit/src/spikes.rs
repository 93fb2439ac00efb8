//! Single values far from the others of their group.

use crate::robust::centre_and_sigma;

/// A row further than this many standard deviations from its group's median is a spike, in a group of thirty rows or more.
const SPIKE_SIGMA: f64 = 8.0;

/// Of fewer rows the standard deviation, which is by their absolute deviations' median, is known less well. With a limit
/// that grows by this power of thirty over their number one row in a million of normal noise is beyond it, of ten rows as of
/// thirty (found by drawing them); with 8 of ten it was one in 1500.
const FEW_ROWS: (f64, f64) = (30.0, 1.3);

/// Fewer values than this are not searched for spikes.
pub const MIN_SEARCHED: usize = 7;

/// More than this share of a group are no spikes: the group itself is disturbed, and its scatter shows it.
const MAX_SPIKES: f64 = 0.2;

/// Which finite values are far from the others' median, and further than `margin`; none when they are many, for then
/// they are no exceptions.
#[must_use]
fn outliers(values: &[f64], margin: f64) -> Vec<bool> {
    // A margin says by itself what is far.
    let few = |count: usize| if margin > 0.0 { 1.0 } else { of_few(count) };
    beyond(values, |sigma, count| (SPIKE_SIGMA * few(count) * sigma).max(margin))
}

/// The same of a reading that may begin to move: what is reached from the others row by row, none further than `margin` from the
/// one before, is the beginning of a way and no exception.
#[must_use]
pub fn outliers_off_the_way(values: &[f64], margin: f64) -> Vec<bool> {
    let mut outliers = outliers(values, margin);
    let onwards: Vec<usize> = (0..values.len()).filter(|&row| values[row].is_finite()).collect();
    let back: Vec<usize> = onwards.iter().rev().copied().collect();
    for pair in onwards.windows(2).chain(back.windows(2)) {
        let (before, row) = (pair[0], pair[1]);
        outliers[row] &= outliers[before] || (values[row] - values[before]).abs() > margin;
    }
    outliers
}

/// The same of values that come in steps; infinite where they are no steps. A value a step away is no spike: of a coarse
/// converter most values are one, and the deviation of the others tells nothing.
#[must_use]
pub fn outliers_beyond_steps(values: &[f64], step: f64) -> Vec<bool> {
    let margin = if step.is_finite() { 1.5 * step } else { 0.0 };
    beyond(values, |sigma, count| (SPIKE_SIGMA * of_few(count) * sigma).max(margin))
}

/// How much further the limit of so many values is.
fn of_few(count: usize) -> f64 {
    libm::pow(FEW_ROWS.0 / count as f64, FEW_ROWS.1).max(1.0)
}

fn beyond(values: &[f64], limit: impl Fn(f64, usize) -> f64) -> Vec<bool> {
    let mut outliers = vec![false; values.len()];
    let finite: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    if finite.len() < MIN_SEARCHED {
        return outliers;
    }
    let (centre, sigma) = centre_and_sigma(&finite);
    let limit = limit(sigma, finite.len());
    for (outlier, value) in outliers.iter_mut().zip(values) {
        *outlier = (value - centre).abs() > limit;
    }
    let found = outliers.iter().filter(|outlier| **outlier).count();
    if found as f64 > MAX_SPIKES * finite.len() as f64 {
        outliers.fill(false);
    }
    outliers
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twenty rows at 5 degrees with a noise of hundredths, the last three on their way to the next soak.
    #[test]
    fn the_beginning_of_a_way_is_no_outlier_and_what_jumps_is_one() {
        let mut rows: Vec<f64> = (0..20_u32).map(|row| 5.0 + 1e-3 * f64::from(row * 7919 % 41) - 0.02).collect();
        for (row, rise) in [(17, 0.6), (18, 1.2), (19, 1.8)] {
            rows[row] += rise;
        }
        assert!(outliers(&rows, 1.0)[18] && outliers(&rows, 1.0)[19]);
        assert!(!outliers_off_the_way(&rows, 1.0).contains(&true));
        rows.reverse();
        assert!(!outliers_off_the_way(&rows, 1.0).contains(&true));
        rows[10] = 85.0;
        rows[9] = f64::NAN;
        let found = outliers_off_the_way(&rows, 1.0);
        assert_eq!((0..20).filter(|&row| found[row]).collect::<Vec<_>>(), [10]);
    }
}
