//! The first readings after the start, which settle towards the others.

use super::{DropReason, Group};
use zerorate_fit::settling::{MOST, settling};

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
    // What settles fast scatters within a group as if it were moved.
    let moved = |place: usize| place < MOST && matches!(marks[place], Some(DropReason::Rotation | DropReason::Step));
    let point = |(place, group): (usize, &Group)| {
        let (temperature, rate) = (group.temperature, group.axes[axis].rate);
        let kept = group.axes[axis].rows > 0 || moved(place);
        (kept && temperature.is_finite() && rate.is_finite()).then_some((temperature, rate))
    };
    let found = settling(&groups.iter().enumerate().map(point).collect::<Vec<_>>(), margin);
    marks[..found].fill(Some(DropReason::StartUp));
}
