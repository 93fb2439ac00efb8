//! Temperatures that are not what the gyro has: frozen, or in coarse steps.

use super::{DropReason, Group};
use zerorate_fit::jumps::line_at;
use zerorate_fit::robust::median;

/// Groups in which the temperature does not change at all, at least, to be frozen.
const FROZEN_GROUPS: usize = 6;

/// A frozen temperature ends in a jump of this many times what it changes by from group to group.
const FROZEN_JUMP: f64 = 5.0;

/// Marks intervals in which the temperature stood still although it moves elsewhere, and then jumped to where it was.
pub(super) fn mark_frozen(groups: &[Group], marks: &mut [Option<DropReason>]) {
    let flat = |group: &Group| group.temperatures.0 >= group.temperatures.1;
    let still = groups.iter().filter(|group| flat(group)).count();
    if still == 0 || 2 * still > groups.len() {
        return;
    }
    let change = |pair: &[Group]| (pair[1].temperature - pair[0].temperature).abs();
    let mut changes: Vec<f64> =
        groups.windows(2).filter(|pair| !flat(&pair[0]) && !flat(&pair[1])).map(change).collect();
    let typical = median(&mut changes);
    let mut start = 0;
    for run in groups.chunk_by(|a, b| flat(a) && flat(b) && same(a.temperature, b.temperature)) {
        let end = start + run.len();
        if run.len() >= FROZEN_GROUPS
            && flat(&run[0])
            && groups.get(end).is_some_and(|next| change_to(&run[0], next) > FROZEN_JUMP * typical)
        {
            marks[start..end]
                .iter_mut()
                .filter(|mark| mark.is_none())
                .for_each(|mark| *mark = Some(DropReason::FrozenTemperature));
        }
        start = end;
    }
}

fn change_to(group: &Group, next: &Group) -> f64 {
    (next.temperature - group.temperature).abs()
}

fn same(a: f64, b: f64) -> bool {
    a.total_cmp(&b).is_eq()
}

/// Dequantises a coarse temperature: each group takes the mean of those around it, over about the time that the
/// temperature takes from one step to the next. `step` is the size of a step.
pub fn dequantise(groups: &mut [Group], step: f64) {
    let temperatures: Vec<f64> = groups.iter().map(|group| group.temperature).collect();
    let rise: f64 = temperatures.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|rise| rise.is_finite()).sum();
    if rise <= 0.0 {
        return;
    }
    // Groups from one step to the next, on average.
    let spacing = step * temperatures.len() as f64 / rise;
    let reach = (0..=MOST_REACH).take_while(|reach| 2.0 * (*reach as f64) < spacing).last().unwrap_or(0);
    for (place, group) in groups.iter_mut().enumerate() {
        // Symmetric, so that a slope stays one at the ends.
        let reach = reach.min(place).min(temperatures.len() - 1 - place);
        let around = temperatures[place - reach..=place + reach].iter().filter(|t| t.is_finite());
        let (sum, count) = around.fold((0.0, 0_u32), |(sum, count), t| (sum + t, count + 1));
        if count > 0 && group.temperature.is_finite() {
            group.temperature = sum / f64::from(count);
        }
    }
}

/// Groups from which a line is drawn back to those at the start of a log that have no temperature, and so many of those
/// at most: a line through a minute is believed for a minute.
const BACKWARD_GROUPS: usize = 6;

/// Gives the groups at the start of each log that have no temperature one on the line through the first that have: what the
/// drift remembers did not begin where the sensor's first number came. For the history alone: their rows stay left out.
pub fn extend_to_the_start(groups: &mut [Group]) {
    for log in groups.chunk_by_mut(|a, b| a.log == b.log) {
        let Some(first) = log.iter().position(|group| group.temperature.is_finite()) else { continue };
        // Rows are as far apart as they are where there is no time.
        let place = |group: &Group| if group.time_s.is_finite() { group.time_s } else { group.first_row as f64 };
        let measured = log[first..].iter().filter(|group| group.temperature.is_finite()).take(BACKWARD_GROUPS);
        let points: Vec<(f64, f64)> = measured.map(|group| (place(group), group.temperature)).collect();
        if points.len() < BACKWARD_GROUPS {
            continue;
        }
        for group in &mut log[first.saturating_sub(BACKWARD_GROUPS)..first] {
            group.temperature = line_at(&points, place(group)).0;
        }
    }
}

/// Groups on each side over which steps are averaged, at most: ten minutes of 10 s each.
const MOST_REACH: usize = 30;
