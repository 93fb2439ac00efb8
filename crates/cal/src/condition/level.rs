//! What can be seen on groups: intervals that are no drift, and steps of the rate.

use super::gap::{gaps, mark_gaps_within};
use super::left_out::{excluded, leave_out, leave_out_marked};
use super::motion::mark_moved;
use super::settle::mark_settling;
use super::step::{are_opposite, take_out_steps};
use super::temperature::mark_frozen;
use super::{DropReason, Excluded, Group, Step, Stopped, Tally};
use crate::units::TemperatureUnit;

/// A jump of the temperature of more than this share of the least span, 0.5 C, explains a jump of the rate.
const TEMPERATURE_JUMP: f64 = 0.05;

/// What was found.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Levels {
    /// Intervals left out of all axes, for a unit that is moved is moved as a whole; and gaps.
    pub excluded: Vec<Excluded>,
    /// Steps taken out.
    pub steps: Vec<Step>,
    /// Steps too small for that, which were left in.
    pub left_in: Vec<Step>,
    /// Where an axis read one number: left out of that axis alone.
    pub stopped: Vec<Stopped>,
}

impl Levels {
    /// Puts the steps back that were taken out.
    pub fn put_back(&self, groups: &mut [Group]) {
        for step in &self.steps {
            let after = groups.iter_mut().filter(|group| group.first_row >= step.row);
            after.for_each(|group| group.axes[step.axis].rate += step.size);
        }
    }
}

/// Leaves out the groups in which the unit was moved, settled after its start, or had no true temperature (their rows
/// become 0 and are counted) and takes out steps: rates after a step are reduced by its size, so the curve holds for the
/// level before the first one. `rotation_threshold` is a rate that only a rotating unit shows, infinite where there is none.
/// `rate_steps` are the steps of each axis's converter: a change of one is no movement and no step of the rate.
pub fn level(
    groups: &mut [Group],
    tallies: &mut [Tally],
    unit: TemperatureUnit,
    rotation_threshold: f64,
    rate_steps: &[f64],
) -> Levels {
    // By the side of a step what is less than one and a half is rounding.
    let margin_of = |axis: usize| rate_steps.get(axis).filter(|step| step.is_finite()).map_or(0.0, |step| 1.5 * step);
    let axes = tallies.len();
    let mut marks: Vec<Option<DropReason>> = vec![None; groups.len()];
    for axis in 0..axes {
        mark_moved(groups, axis, rotation_threshold, margin_of(axis), &mut marks);
    }
    mark_frozen(groups, &mut marks);
    mark_gaps_within(groups, &mut marks);
    let rows: Vec<Vec<u32>> = groups.iter().map(|group| group.axes.iter().map(|part| part.rows).collect()).collect();
    leave_out(groups, &marks);
    let margin = TEMPERATURE_JUMP * unit.min_span();
    let (mut steps, mut left_in) = (Vec::new(), Vec::new());
    for axis in 0..axes {
        let found = take_out_steps(groups, axis, margin, margin_of(axis));
        steps.extend(found.taken);
        left_in.extend(found.left);
    }
    join_opposite_steps(groups, &mut steps, &mut marks);
    for axis in 0..axes {
        mark_settling(groups, axis, margin_of(axis), &mut marks);
    }
    name_the_groups_of_steps(groups, &steps, &mut marks);
    take_back_jumps(groups, &rows, &steps, &mut marks);
    leave_out(groups, &marks);
    for ((group, rows), mark) in groups.iter().zip(rows).zip(&marks) {
        for ((tally, rows), part) in tallies.iter_mut().zip(rows).zip(&group.axes) {
            if let Some(reason) = mark.filter(|_| part.rows == 0) {
                tally.add(reason, u64::from(rows));
            }
        }
    }
    let mut excluded = excluded(groups, &marks);
    excluded.extend(gaps(groups));
    excluded.sort_by_key(|interval| interval.rows);
    Levels { excluded, steps, left_in, stopped: Vec::new() }
}

/// Leaves out the groups of one sensor at times at which another of the same unit was moved. Gives what was left out
/// besides what was left out before.
pub fn leave_out_times(groups: &mut [Group], tallies: &mut [Tally], times_s: &[(f64, f64)]) -> Vec<Excluded> {
    let overlaps = |group: &Group| times_s.iter().any(|(from, to)| group.times_s.0 <= *to && group.times_s.1 >= *from);
    let marks: Vec<Option<DropReason>> = groups
        .iter()
        .map(|group| (group.axes.iter().any(|part| part.rows > 0) && overlaps(group)).then_some(DropReason::Rotation))
        .collect();
    leave_out_marked(groups, tallies, &marks)
}

/// A step up and one back down by as much are a rotation that lasted, or a disturbance: the interval between is left out and
/// the level after it is as it was.
fn join_opposite_steps(groups: &mut [Group], steps: &mut Vec<Step>, marks: &mut [Option<DropReason>]) {
    let mut place = 0;
    while place + 1 < steps.len() {
        let (first, second) = (&steps[place], &steps[place + 1]);
        if !are_opposite(first, second) {
            place += 1;
            continue;
        }
        let (axis, from, to, up, down) = (first.axis, first.row, second.row, first.size, second.size);
        groups.iter().zip(marks.iter_mut()).filter(|(group, _)| first.holds(group)).for_each(|(_, mark)| {
            *mark = Some(DropReason::Rotation);
        });
        for (group, mark) in groups.iter_mut().zip(marks.iter_mut()).filter(|(group, _)| group.first_row >= from) {
            group.axes[axis].rate += up;
            if group.first_row < to {
                *mark = Some(DropReason::Rotation);
            } else {
                group.axes[axis].rate += down;
            }
        }
        steps.drain(place..place + 2);
    }
}

/// A group in which a step falls is of both sides, and is left out. It may scatter like a moved one, but nothing moved.
fn name_the_groups_of_steps(groups: &[Group], steps: &[Step], marks: &mut [Option<DropReason>]) {
    for step in steps {
        let own: Vec<usize> = (0..groups.len()).filter(|place| step.holds(&groups[*place])).collect();
        let (Some(first), Some(last)) = (own.first(), own.last()) else { continue };
        let beside = [first.checked_sub(1), Some(last + 1)].into_iter().flatten();
        let moved = beside.filter_map(|place| *marks.get(place)?).any(|mark| mark == DropReason::Rotation);
        for place in own {
            let is_moved = moved && marks[place] == Some(DropReason::Rotation);
            if !is_moved && matches!(marks[place], None | Some(DropReason::Rotation)) {
                marks[place] = Some(DropReason::Step);
            }
        }
    }
}

/// A group that only jumps is left out beside a step; where the jump is none, but a part's own, it is kept.
fn take_back_jumps(groups: &mut [Group], rows: &[Vec<u32>], steps: &[Step], marks: &mut [Option<DropReason>]) {
    for place in 0..groups.len() {
        if marks[place] != Some(DropReason::Step) || steps.iter().any(|step| step.holds(&groups[place])) {
            continue;
        }
        let around = [place.checked_sub(1), Some(place + 1)].into_iter().flatten();
        let moved = around.filter_map(|other| *marks.get(other)?).any(|mark| mark == DropReason::Rotation);
        marks[place] = moved.then_some(DropReason::Rotation);
        if !moved {
            for (part, rows) in groups[place].axes.iter_mut().zip(&rows[place]) {
                part.rows = *rows;
                part.weight = f64::from(u8::from(*rows > 0));
            }
        }
    }
}
