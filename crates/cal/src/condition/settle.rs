//! The first readings after the start, which settle towards the others.

use super::{DropReason, Group};
use zerorate_fit::robust::{extrapolated, noise};

/// Groups at the beginning of a log that may settle: the first minute or so.
const MOST: usize = 8;

/// Groups behind them that show where the rate settles to.
const REFERENCE: usize = 12;

/// From group to group what settles comes closer by this factor at least, as with a time constant of 40 s; what is slower is
/// a drift.
const DECAY: f64 = 1.3;

/// A group further than this many standard deviations from where the others lead settles.
const SETTLING_SIGMA: f64 = 10.0;

/// By so many standard deviations more than that factor, from the first group to the one that has settled: the curve itself bends
/// away from a line, and with some noise the bend of one group comes closer fast enough.
const SURE: f64 = 3.0;

/// Marks the groups at the beginning of each log that settle, in one axis, by more than `margin`.
pub(super) fn mark_settling(groups: &[Group], axis: usize, margin: f64, marks: &mut [Option<DropReason>]) {
    let mut start = 0;
    while start < groups.len() {
        let end = start + groups[start..].iter().take_while(|group| group.log == groups[start].log).count();
        mark_start(&groups[start..end], axis, margin, &mut marks[start..end]);
        start = end;
    }
}

fn mark_start(groups: &[Group], axis: usize, margin: f64, marks: &mut [Option<DropReason>]) {
    if groups.len() < 2 * (MOST + REFERENCE) {
        return;
    }
    let point = |place: usize| (groups[place].temperature, groups[place].axes[axis].rate);
    // What settles fast scatters within a group as if it were moved.
    let moved: Vec<bool> =
        marks.iter().take(MOST).map(|mark| matches!(mark, Some(DropReason::Rotation | DropReason::Step))).collect();
    let usable = |place: &usize| {
        let kept = groups[*place].axes[axis].rows > 0 || moved.get(*place).is_some_and(|moved| *moved);
        kept && groups[*place].temperature.is_finite() && groups[*place].axes[axis].rate.is_finite()
    };
    let settled: Vec<(f64, f64)> = (MOST..MOST + REFERENCE).filter(usable).map(point).collect();
    let later: Vec<f64> = (MOST..groups.len()).filter(usable).map(|place| point(place).1).collect();
    if settled.len() < REFERENCE / 2 || !(0..MOST).all(|place| usable(&place)) {
        return;
    }
    let sigma = noise(&later);
    let off = |place: usize| {
        let (predicted, spread) = extrapolated(&settled, point(place).0);
        ((point(place).1 - predicted).abs(), (SETTLING_SIGMA * sigma.max(spread)).max(margin))
    };
    let settling = (0..MOST).take_while(|place| off(*place).0 > off(*place).1).count();
    let fast = (0..settling).all(|place| off(place).0 > DECAY * off(place + 1).0);
    let decay = (0..settling).fold(1.0, |decay, _| DECAY * decay);
    let surely = off(0).0 - decay * off(settling).0 > SURE * sigma * decay.hypot(1.0);
    if settling > 0 && fast && surely {
        marks[..settling].fill(Some(DropReason::StartUp));
    }
}
