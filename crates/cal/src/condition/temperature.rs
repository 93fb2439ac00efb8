//! Temperatures that are not what the gyro has: frozen, or in coarse steps.

use std::ops::Range;

use super::left_out::leave_out_marked;
use super::{DropReason, Excluded, Group, Tally};
use crate::units::TemperatureUnit;
use zerorate_fit::coarse::smoothed;
use zerorate_fit::dropouts::{Shown, dropouts};
use zerorate_fit::line::Line;
use zerorate_fit::robust::median;

/// A dropout of the temperature is a jump of more than this share of the least span, 1 C, and of more than two steps of a coarse
/// sensor.
const DROPOUT: f64 = 0.1;

/// A sensor whose readings typically go forth and back by so many of its steps within a group never stands still by itself.
const NOISY_STEPS: f64 = 2.0;

/// Leaves out the groups in which the temperature jumped away and back ([`dropouts`]), and those in which a noisy one stood
/// still. What the drift remembers did not go where it jumped: those groups lie on a line between the groups beside them.
pub fn leave_out_untrue_temperatures(
    groups: &mut [Group],
    tallies: &mut [Tally],
    unit: TemperatureUnit,
    temperature_step: f64,
) -> Vec<Excluded> {
    let margin = dropout_margin(unit, temperature_step);
    let mut marks: Vec<Option<DropReason>> = vec![None; groups.len()];
    let mut start = 0;
    for log in groups.chunk_by_mut(|a, b| a.log == b.log) {
        let shown = |group: &Group| Shown { mean: group.temperature, range: group.temperatures, leap: group.leap };
        for found in dropouts(&log.iter().map(shown).collect::<Vec<_>>(), margin) {
            let beside = |place: Option<usize>| place.and_then(|place| log.get(place)).map(|group| group.temperature);
            let (before, after) = (beside(found.start.checked_sub(1)), beside(Some(found.end)));
            let (from, to) = (before.or(after).unwrap_or(f64::NAN), after.or(before).unwrap_or(f64::NAN));
            for (place, group) in log[found.clone()].iter_mut().enumerate() {
                group.temperature = from + (to - from) * (place + 1) as f64 / (found.len() + 1) as f64;
            }
            marks[start + found.start..start + found.end].fill(Some(DropReason::TemperatureSpike));
        }
        start += log.len();
    }
    mark_still_without_noise(groups, temperature_step, &mut marks);
    leave_out_marked(groups, tallies, &marks)
}

/// What a jump of the temperature is larger than.
pub fn dropout_margin(unit: TemperatureUnit, temperature_step: f64) -> f64 {
    let steps = if temperature_step.is_finite() { 2.0 * temperature_step } else { 0.0 };
    (DROPOUT * unit.min_span()).max(steps)
}

/// Marks intervals in which a temperature with noise had none: its sensor, or the line to it, had stopped.
fn mark_still_without_noise(groups: &[Group], temperature_step: f64, marks: &mut [Option<DropReason>]) {
    let moving = groups.iter().filter(|group| !flat(group));
    let forth_and_back = median(&mut moving.map(|group| group.leap.1.min(-group.leap.0)).collect::<Vec<_>>());
    if forth_and_back.is_nan() || forth_and_back < NOISY_STEPS * temperature_step {
        return;
    }
    for run in still(groups).filter(|run| run.len() >= FROZEN_GROUPS) {
        marks[with_ends(&run, groups)].fill(Some(DropReason::FrozenTemperature));
    }
}

/// Frozen groups with those beside them, in which it stopped, and jumped to where it was: a part of their rows is not true.
fn with_ends(run: &Range<usize>, groups: &[Group]) -> Range<usize> {
    let log = groups[run.start].log;
    let is_of_it = |place: usize| groups.get(place).is_some_and(|group| group.log == log);
    let before = run.start.checked_sub(1).is_some_and(is_of_it);
    run.start - usize::from(before)..run.end + usize::from(is_of_it(run.end))
}

/// Where successive groups have one temperature and no other.
fn still(groups: &[Group]) -> impl Iterator<Item = Range<usize>> + '_ {
    let mut end = 0;
    let runs = groups.chunk_by(|a, b| flat(a) && flat(b) && same(a.temperature, b.temperature) && a.log == b.log);
    runs.map(move |run| {
        end += run.len();
        end - run.len()..end
    })
    .filter(|run| flat(&groups[run.start]))
}

fn flat(group: &Group) -> bool {
    group.temperatures.0 >= group.temperatures.1
}

/// Groups in which the temperature does not change at all, at least, to be frozen.
const FROZEN_GROUPS: usize = 6;

/// A frozen temperature ends in a jump of this many times what it changes by from group to group.
const FROZEN_JUMP: f64 = 5.0;

/// Marks intervals in which the temperature stood still although it moves elsewhere, and then jumped to where it was.
pub(super) fn mark_frozen(groups: &[Group], marks: &mut [Option<DropReason>]) {
    let still_groups = groups.iter().filter(|group| flat(group)).count();
    if still_groups == 0 || 2 * still_groups > groups.len() {
        return;
    }
    let change = |from: &Group, to: &Group| (to.temperature - from.temperature).abs();
    let moving = groups.windows(2).filter(|pair| !flat(&pair[0]) && !flat(&pair[1]));
    let typical = median(&mut moving.map(|pair| change(&pair[0], &pair[1])).collect::<Vec<_>>());
    let jumps = |run: &Range<usize>| {
        groups.get(run.end).is_some_and(|next| change(&groups[run.start], next) > FROZEN_JUMP * typical)
    };
    for run in still(groups).filter(|run| run.len() >= FROZEN_GROUPS && jumps(run)) {
        let unmarked = marks[with_ends(&run, groups)].iter_mut().filter(|mark| mark.is_none());
        unmarked.for_each(|mark| *mark = Some(DropReason::FrozenTemperature));
    }
}

/// Whether two averages are of one number: of more or fewer rows it is rounded otherwise.
fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * a.abs()
}

/// Gives each group of a coarse sensor the mean temperature of those around it ([`smoothed`]).
pub fn dequantise(groups: &mut [Group], step: f64) {
    let temperatures: Vec<f64> = groups.iter().map(|group| group.temperature).collect();
    for (group, smooth) in groups.iter_mut().zip(smoothed(&temperatures, step)).filter(|(_, smooth)| smooth.is_finite())
    {
        group.interpolated = smooth - group.temperature;
        group.temperature = smooth;
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
        let line = Line::through(&points);
        for group in &mut log[first.saturating_sub(BACKWARD_GROUPS)..first] {
            group.temperature = line.at(place(group));
        }
    }
}
