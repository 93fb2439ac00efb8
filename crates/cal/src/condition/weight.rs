//! Equal weight in temperature: what a log dwelt on is not fitted at the cost of what it passed.

use super::Group;

/// Bins over the temperature range: finer than any curve bends.
const BINS: usize = 40;

/// A group counts at most this many times the average, and at least the inverse of it: a temperature that was passed in
/// one group is not known better by counting it more.
const MOST: f64 = 4.0;

/// Weighs an axis's groups by the inverse of how many there are at their temperature; 1 on average over those kept.
pub fn weigh(groups: &mut [Group], axis: usize) {
    let kept = |group: &Group| group.axes[axis].rows > 0 && group.temperature.is_finite();
    let (least, most) = groups
        .iter()
        .filter(|group| kept(group))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), group| (a.min(group.temperature), b.max(group.temperature)));
    if least >= most || !least.is_finite() {
        return;
    }
    // The cast is of a place below the number of bins.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let bin = |temperature: f64| (((temperature - least) / (most - least) * BINS as f64) as usize).min(BINS - 1);
    let mut counts = [0.0_f64; BINS];
    groups.iter().filter(|group| kept(group)).for_each(|group| counts[bin(group.temperature)] += 1.0);
    // A bin and its neighbours, so that a weight does not change from group to group.
    let density = |place: usize| {
        let around = &counts[place.saturating_sub(1)..(place + 2).min(BINS)];
        around.iter().sum::<f64>() / around.len() as f64
    };
    let total: f64 = counts.iter().sum();
    let filled = counts.iter().filter(|count| **count > 0.0).count() as f64;
    let mut sum = 0.0;
    for group in groups.iter_mut().filter(|group| kept(group)) {
        let weight = (total / filled / density(bin(group.temperature))).clamp(1.0 / MOST, MOST);
        group.axes[axis].weight = weight;
        sum += weight;
    }
    for group in groups.iter_mut().filter(|group| kept(group)) {
        group.axes[axis].weight *= total / sum;
    }
}
