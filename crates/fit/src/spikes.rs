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
pub fn outliers(values: &[f64], margin: f64) -> Vec<bool> {
    let mut outliers = vec![false; values.len()];
    let finite: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    if finite.len() < MIN_SEARCHED {
        return outliers;
    }
    let (centre, sigma) = centre_and_sigma(&finite);
    // A margin says by itself what is far.
    let few = if margin > 0.0 { 1.0 } else { (FEW_ROWS.0 / finite.len() as f64).powf(FEW_ROWS.1).max(1.0) };
    let limit = (SPIKE_SIGMA * few * sigma).max(margin);
    for (outlier, value) in outliers.iter_mut().zip(values) {
        *outlier = (value - centre).abs() > limit;
    }
    let found = outliers.iter().filter(|outlier| **outlier).count();
    if found as f64 > MAX_SPIKES * finite.len() as f64 {
        outliers.fill(false);
    }
    outliers
}
