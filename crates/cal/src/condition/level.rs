//! Stretches in which the unit was moved, and steps of the rate, found on groups.

use super::group::typical_scatter;
use super::robust::{centre_and_sigma, median};
use super::{DropReason, Group, Step, Stretch, Tally};
use crate::quality::TemperatureUnit;

/// A group whose scatter is this many times the typical one was moved. With 21 rows a standard deviation is itself
/// known to 15 %.
const MOVED_SCATTER: f64 = 5.0;

/// A group this many standard deviations from the running median was moved.
const MOVED_SIGMA: f64 = 12.0;

/// Groups on each side that the running median looks at: a rotation shorter than as many groups cannot move it.
const NEIGHBOURS: usize = 10;

/// Groups on each side of a boundary from which a line is drawn to it.
const STEP_GROUPS: usize = 8;

/// A jump at a boundary of more than this many standard deviations is a step.
const STEP_SIGMA: f64 = 12.0;

/// A jump of the temperature of more than this share of the least span, 0.5 C, explains a jump of the rate.
const TEMPERATURE_JUMP: f64 = 0.05;

/// Steps taken out of one axis, at most: a rate with more of them is not one with steps.
const MAX_STEPS: usize = 8;

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
    let temperature_margin = TEMPERATURE_JUMP * unit.min_span();
    let axes = tallies.len();
    let mut moved = vec![false; groups.len()];
    for axis in 0..axes {
        mark_moved(groups, axis, &mut moved);
    }
    for (group, _) in groups.iter_mut().zip(&moved).filter(|(_, moved)| **moved) {
        for (part, tally) in group.axes.iter_mut().zip(&mut *tallies) {
            tally.add(DropReason::Rotation, u64::from(part.rows));
            part.rows = 0;
        }
    }
    let steps = (0..axes).flat_map(|axis| take_out_steps(groups, axis, temperature_margin)).collect();
    Levels { stretches: stretches(groups, &moved), steps }
}

fn mark_moved(groups: &[Group], axis: usize, moved: &mut [bool]) {
    let typical = typical_scatter(groups, axis);
    let used: Vec<usize> = (0..groups.len()).filter(|&group| groups[group].axes[axis].rows > 0).collect();
    let rates: Vec<f64> = used.iter().map(|&group| groups[group].axes[axis].rate).collect();
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
    for (&group, deviation) in used.iter().zip(&deviations) {
        let scatter = groups[group].axes[axis].scatter;
        if deviation.abs() > MOVED_SIGMA * sigma || scatter > MOVED_SCATTER * typical {
            moved[group] = true;
        }
    }
}

/// The standard deviation of white noise that successive values carry, whatever their trend: that of their second
/// differences over sqrt(1 + 4 + 1). A trend leaves no deviation from a running median, so that alone would be too small.
fn noise(values: &[f64]) -> f64 {
    let differences: Vec<f64> = values.windows(3).map(|v| v[0] - 2.0 * v[1] + v[2]).collect();
    if differences.is_empty() {
        return 0.0;
    }
    centre_and_sigma(&differences).1 / 6.0_f64.sqrt()
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

/// Finds the largest step, takes it out, and looks again.
fn take_out_steps(groups: &mut [Group], axis: usize, temperature_margin: f64) -> Vec<Step> {
    let used: Vec<usize> = (0..groups.len()).filter(|&group| groups[group].axes[axis].rows > 0).collect();
    let mut steps = Vec::new();
    if used.len() < 4 * STEP_GROUPS {
        return steps;
    }
    let temperatures: Vec<f64> = used.iter().map(|&group| groups[group].temperature).collect();
    let temperature_jumps = jumps(&used, &temperatures);
    while steps.len() < MAX_STEPS {
        let rates: Vec<f64> = used.iter().map(|&group| groups[group].axes[axis].rate).collect();
        let jumps = jumps(&used, &rates);
        let (_, sigma) = centre_and_sigma(&jumps);
        let limit = STEP_SIGMA * sigma.max(noise(&rates));
        let largest = (0..jumps.len())
            // A jump of the temperature explains a jump of the rate: the log was stopped and went on.
            .filter(|&place| temperature_jumps[place].abs() <= temperature_margin)
            .max_by(|&a, &b| jumps[a].abs().total_cmp(&jumps[b].abs()));
        let Some(place) = largest.filter(|&place| jumps[place].abs() > limit) else {
            break;
        };
        let first = &groups[used[place + STEP_GROUPS]];
        let step = Step {
            axis,
            row: first.first_row,
            time_s: first.time_s,
            temperature: first.temperature,
            size: jumps[place],
        };
        for group in &mut groups[used[place + STEP_GROUPS]..] {
            group.axes[axis].rate -= step.size;
        }
        steps.push(step);
    }
    steps.sort_by_key(|step| step.row);
    steps
}

/// For each boundary with enough groups on both sides, the line through the values after it less the line through those
/// before it, both drawn to the boundary. `used` numbers the groups, so that a stretch left out keeps its length.
fn jumps(used: &[usize], values: &[f64]) -> Vec<f64> {
    let points: Vec<(f64, f64)> = used.iter().map(|&group| group as f64).zip(values.iter().copied()).collect();
    points
        .windows(2 * STEP_GROUPS)
        .map(|window| {
            let (before, after) = window.split_at(STEP_GROUPS);
            let boundary = f64::midpoint(before[STEP_GROUPS - 1].0, after[0].0);
            line_at(after, boundary) - line_at(before, boundary)
        })
        .collect()
}

/// The least-squares line through points, at a place.
fn line_at(points: &[(f64, f64)], place: f64) -> f64 {
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / n, y + point.1 / n));
    let (rise, run) = points
        .iter()
        .fold((0.0, 0.0), |(rise, run), point| (rise + (point.0 - x) * (point.1 - y), run + (point.0 - x).powi(2)));
    y + rise / run * (place - x)
}
