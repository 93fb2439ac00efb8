//! What can be seen on groups: stretches in which the unit was moved, and steps of the rate.

use super::motion::mark_moved;
use super::step::take_out_steps;
use super::{DropReason, Group, Step, Stretch, Tally};
use crate::quality::TemperatureUnit;

/// A jump of the temperature of more than this share of the least span, 0.5 C, explains a jump of the rate.
const TEMPERATURE_JUMP: f64 = 0.05;

/// What was found.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Levels {
    /// Stretches left out of all axes, for a unit that is moved is moved as a whole.
    pub stretches: Vec<Stretch>,
    /// Steps taken out.
    pub steps: Vec<Step>,
}

/// Leaves out the groups in which the unit was moved (their rows become 0 and are counted) and takes out steps: rates
/// after a step are reduced by its size, so the curve holds for the level before the first one.
pub fn level(groups: &mut [Group], tallies: &mut [Tally], unit: TemperatureUnit) -> Levels {
    let axes = tallies.len();
    let mut moved = vec![false; groups.len()];
    for axis in 0..axes {
        mark_moved(groups, axis, &mut moved);
    }
    let rows: Vec<Vec<u32>> = groups.iter().map(|group| group.axes.iter().map(|part| part.rows).collect()).collect();
    for (group, _) in groups.iter_mut().zip(&moved).filter(|(_, moved)| **moved) {
        group.axes.iter_mut().for_each(|part| part.rows = 0);
    }
    let margin = TEMPERATURE_JUMP * unit.min_span();
    let steps: Vec<Step> = (0..axes).flat_map(|axis| take_out_steps(groups, axis, margin)).collect();
    let mut stretches = stretches(groups, &moved);
    for stretch in &mut stretches {
        name_the_group_of_a_step(stretch, groups, &steps);
    }
    for (group, rows) in groups.iter().zip(rows) {
        let left_out = stretches.iter().find(|stretch| (stretch.rows.0..stretch.rows.1).contains(&group.first_row));
        for ((tally, rows), stretch) in tallies.iter_mut().zip(rows).zip(std::iter::repeat(left_out)) {
            if let Some(stretch) = stretch {
                tally.add(stretch.reason, u64::from(rows));
            }
        }
    }
    Levels { stretches, steps }
}

/// A group in which a step falls scatters like a moved one, but nothing moved.
fn name_the_group_of_a_step(stretch: &mut Stretch, groups: &[Group], steps: &[Step]) {
    let one_group = groups.iter().any(|group| (group.first_row, group.end_row) == stretch.rows);
    if one_group && steps.iter().any(|step| step.row == stretch.rows.1) {
        stretch.reason = DropReason::Step;
    }
}

fn stretches(groups: &[Group], moved: &[bool]) -> Vec<Stretch> {
    let mut found: Vec<Stretch> = Vec::new();
    for (group, _) in groups.iter().zip(moved).filter(|(_, moved)| **moved) {
        match found.last_mut().filter(|stretch| stretch.rows.1 == group.first_row) {
            Some(stretch) => {
                stretch.rows.1 = group.end_row;
                stretch.time_s.1 = group.time_s;
                stretch.temperature.0 = stretch.temperature.0.min(group.temperature);
                stretch.temperature.1 = stretch.temperature.1.max(group.temperature);
            }
            None => found.push(Stretch {
                reason: DropReason::Rotation,
                rows: (group.first_row, group.end_row),
                time_s: (group.time_s, group.time_s),
                temperature: (group.temperature, group.temperature),
            }),
        }
    }
    found
}
