//! Groups in which the unit was moved.

use std::ops::Range;

use super::gap::goes_on;
use super::group::typical_scatter;
use super::{DropReason, Group};
use zerorate_fit::robust::{centre_and_sigma, median, noise};

/// A group whose scatter is this many times the typical one was moved. With 21 rows a standard deviation is itself
/// known to 15 %.
const MOVED_SCATTER: f64 = 5.0;

/// A group this many standard deviations from the running median was moved.
const MOVED_SIGMA: f64 = 12.0;

/// A group that scatters by less than this share of what the rate changes by over it jumps: a jump in its middle scatters
/// by a half.
const JUMP_SCATTER: f64 = 0.6;

/// And this many times what the rate typically changes by from group to group around it: where a ramp turns round, a drift that
/// goes straight up to the turn and straight back is half of [`NEIGHBOURS`] changes from its running median.
const CORNER: f64 = 8.0;

/// Groups on each side that the running median looks at: a rotation shorter than as many groups cannot move it.
const NEIGHBOURS: usize = 10;

/// Marks the groups in which an axis shows a movement; `rotation_threshold` is a distance from the median rate that no
/// drift reaches.
/// What is less than `margin` is the converter's.
pub(super) fn mark_moved(
    groups: &[Group],
    axis: usize,
    rotation_threshold: f64,
    margin: f64,
    marks: &mut [Option<DropReason>],
) {
    let typical = typical_scatter(groups, axis);
    let used: Vec<usize> = (0..groups.len()).filter(|&group| groups[group].axes[axis].rows > 0).collect();
    let rate = |group: &usize| groups[*group].axes[axis].rate;
    let middle = median(&mut used.iter().map(rate).collect::<Vec<_>>());
    // A rate need not go on in another log as it was where one ended.
    let runs: Vec<Vec<Place>> = used
        .chunk_by(|a, b| groups[*a].log == groups[*b].log)
        .map(|run| places(groups, run, &run.iter().map(rate).collect::<Vec<_>>()))
        .collect();
    let deviations: Vec<f64> = runs.iter().flatten().map(|place| place.deviation).collect();
    if deviations.is_empty() {
        return;
    }
    let (_, sigma) = centre_and_sigma(&deviations);
    let sigma = sigma.max(noise(&used.iter().map(rate).collect::<Vec<_>>()));
    for place in runs.iter().flatten() {
        let turned = (rate(&place.group) - middle).abs() > rotation_threshold;
        let limit = (MOVED_SIGMA * sigma).max(CORNER * place.slope).max(margin);
        let scatter = groups[place.group].axes[axis].scatter;
        if place.deviation.abs() > limit || turned {
            marks[place.group] = Some(DropReason::Rotation);
        } else if scatter > MOVED_SCATTER * typical && scatter > margin && marks[place.group].is_none() {
            let jumps = scatter < JUMP_SCATTER * place.jump;
            marks[place.group] = Some(if jumps { DropReason::Step } else { DropReason::Rotation });
        }
    }
}

/// A group among its neighbours.
struct Place {
    group: usize,
    /// From the median around it.
    deviation: f64,
    /// What the rate typically changes by from group to group around it.
    slope: f64,
    /// From the group before it to the group after it.
    jump: f64,
}

fn places(groups: &[Group], run: &[usize], rates: &[f64]) -> Vec<Place> {
    let goes_on = goes_on(groups);
    let changes: Vec<f64> = rates.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    run.chunk_by(|a, b| goes_on(*a, *b))
        .scan(0, |end, stretch| {
            let start = std::mem::replace(end, *end + stretch.len());
            Some(start..*end)
        })
        .flat_map(|stretch| stretch.clone().map(move |place| (place, stretch.clone())))
        .map(|(place, stretch)| {
            // Symmetric, so that a drift at the ends is no deviation.
            let reach = NEIGHBOURS.min(place).min(rates.len() - 1 - place);
            let from_median = |around: Range<usize>| rates[place] - median(&mut rates[around].to_vec());
            let around = place - reach..place + reach + 1;
            let own_side = around.start.max(stretch.start)..around.end.min(stretch.end);
            let mut deviation = from_median(around);
            // A rate need not go on after a gap as it was before: it is to deviate from those of its own side too. A
            // straight drift does, by less than a corner.
            if own_side.len() > NEIGHBOURS / 2 {
                let from_own_side = from_median(own_side);
                deviation = if from_own_side.abs() < deviation.abs() { from_own_side } else { deviation };
            }
            let around = place.saturating_sub(NEIGHBOURS)..(place + NEIGHBOURS).min(changes.len());
            let slope = if around.is_empty() { 0.0 } else { median(&mut changes[around].to_vec()) };
            let (before, after) = (place.saturating_sub(1).max(stretch.start), (place + 1).min(stretch.end - 1));
            Place { group: run[place], deviation, slope, jump: (rates[after] - rates[before]).abs() }
        })
        .collect()
}
