//! Equal weight in temperature: what a log dwelt on is not fitted at the cost of what it passed.

use crate::intervals::ends;

/// Bins over the temperature range: finer than any curve bends.
const BINS: usize = 40;

/// A group counts at most this many times the average, and at least the inverse of it: a temperature that was passed in
/// one group is not known better by counting it more.
const MOST: f64 = 4.0;

/// The weight of each temperature: the inverse of how many there are like it, 1 on average. None where they do not differ.
#[must_use]
pub fn weights(temperatures: &[f64]) -> Option<Vec<f64>> {
    let (least, most) = ends(temperatures.iter().copied());
    if least >= most || !least.is_finite() {
        return None;
    }
    // The cast is of a place below the number of bins.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let bin = |temperature: f64| (((temperature - least) / (most - least) * BINS as f64) as usize).min(BINS - 1);
    let mut counts = [0.0_f64; BINS];
    temperatures.iter().for_each(|temperature| counts[bin(*temperature)] += 1.0);
    // A bin and its neighbours, so that a weight does not change from group to group.
    let density = |place: usize| {
        let around = &counts[place.saturating_sub(1)..(place + 2).min(BINS)];
        around.iter().sum::<f64>() / around.len() as f64
    };
    let total = temperatures.len() as f64;
    let filled = counts.iter().filter(|count| **count > 0.0).count() as f64;
    let raw = temperatures.iter().map(|t| (total / filled / density(bin(*t))).clamp(1.0 / MOST, MOST));
    let sum: f64 = raw.clone().sum();
    Some(raw.map(|weight| weight * total / sum).collect())
}
