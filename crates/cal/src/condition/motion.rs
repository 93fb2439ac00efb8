//! Groups in which the unit was moved.

use super::group::typical_scatter;
use super::robust::{centre_and_sigma, median, noise};
use super::{DropReason, Group};

/// A group whose scatter is this many times the typical one was moved. With 21 rows a standard deviation is itself
/// known to 15 %.
const MOVED_SCATTER: f64 = 5.0;

/// A group this many standard deviations from the running median was moved.
const MOVED_SIGMA: f64 = 12.0;

/// And this many times what the rate typically changes by from group to group around it: where a ramp turns, a drift that
/// goes straight up to the turn and straight back is half of [`NEIGHBOURS`] changes from its running median.
const CORNER: f64 = 8.0;

/// Groups on each side that the running median looks at: a rotation shorter than as many groups cannot move it.
const NEIGHBOURS: usize = 10;

/// Marks the groups in which an axis shows a movement; `turns` is a distance from the median rate that no drift reaches.
pub(super) fn mark_moved(groups: &[Group], axis: usize, turns: f64, marks: &mut [Option<DropReason>]) {
    let typical = typical_scatter(groups, axis);
    let used: Vec<usize> = (0..groups.len()).filter(|&group| groups[group].axes[axis].rows > 0).collect();
    let rates: Vec<f64> = used.iter().map(|&group| groups[group].axes[axis].rate).collect();
    let middle = median(&mut rates.clone());
    let deviations: Vec<f64> = (0..rates.len())
        .map(|place| {
            // Symmetric, so that a drift at the ends of the log is no deviation.
            let reach = NEIGHBOURS.min(place).min(rates.len() - 1 - place);
            rates[place] - median(&mut rates[place - reach..=place + reach].to_vec())
        })
        .collect();
    if deviations.is_empty() {
        return;
    }
    let (_, sigma) = centre_and_sigma(&deviations);
    let sigma = sigma.max(noise(&rates));
    let changes: Vec<f64> = rates.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    for (place, ((&group, deviation), rate)) in used.iter().zip(&deviations).zip(&rates).enumerate() {
        let scatter = groups[group].axes[axis].scatter;
        let turned = (rate - middle).abs() > turns;
        let around = place.saturating_sub(NEIGHBOURS)..(place + NEIGHBOURS).min(changes.len());
        let slope = median(&mut changes[around].to_vec());
        let limit = (MOVED_SIGMA * sigma).max(if slope.is_nan() { 0.0 } else { CORNER * slope });
        if deviation.abs() > limit || scatter > MOVED_SCATTER * typical || turned {
            marks[group] = Some(DropReason::Rotation);
        }
    }
}
