//! Jumps of the rate that stay.

use zerorate_fit::intervals::ends;
use zerorate_fit::jumps::{Jump, REACH, background, jumps};
use zerorate_fit::line::Line;
use zerorate_fit::robust::{centre_and_sigma, noise};
use zerorate_fit::small_step::{SmallStep, small_steps};

use super::gap::goes_on;
use super::group::all_of;
use super::{Group, Step};

/// A jump at a boundary of more than this many standard deviations of all such jumps may be a step.
const STEP_SIGMA: f64 = 15.0;

/// A step is this many times the rms of the values about the lines on either side: a rate that bends from one level to
/// another drifts, and only one that is steady before and after has stepped.
const STEADY: f64 = 8.0;

/// And this many times its own standard error: across a gap the lines are drawn far, and their noise with them.
const SURE: f64 = 5.0;

/// Steps taken out of one axis, at most: a rate with more of them is not one with steps.
const MAX_STEPS: usize = 4;

/// A step stands out by this factor from the largest jump beyond [`MAX_STEPS`]. Parts jump by themselves at some
/// temperatures: the shared chamber recording has a dozen jumps, the largest 2.5 times the fifth.
const STANDS_OUT: f64 = 5.0;

/// A step that is taken out is this share of the peak to peak of the axis, at least: smaller jumps may be a part's own way of
/// drifting, and removing one would remove what is to be fitted (the largest of the shared chamber recording is 0.11). One that
/// stands out all the same is told and left in.
const SHARE: f64 = 0.15;

/// Lines through the temperature on either side of a ramp's end part by more than this many times the rms about them: a parabola,
/// a turn that is no corner, parts them by 28 times; by more across a gap, as their middles are further apart.
const BENT: f64 = 30.0;

/// The steps of one axis.
#[derive(Debug, Default)]
pub(super) struct Steps {
    /// Taken out of the rates.
    pub taken: Vec<Step>,
    /// Too small a part of the drift for that.
    pub left: Option<Step>,
}

/// Finds the largest step of an axis, takes it out, and looks again. `temperature_margin` is the jump of the temperature
/// that explains a jump of the rate, as where a log was stopped and went on.
/// A jump of less than `rate_margin` is the converter's.
pub(super) fn take_out_steps(groups: &mut [Group], axis: usize, temperature_margin: f64, rate_margin: f64) -> Steps {
    let used: Vec<usize> = (0..groups.len()).filter(|&group| groups[group].axes[axis].rows > 0).collect();
    let mut steps = Steps::default();
    if used.len() < 4 * REACH {
        return steps;
    }
    let temperatures: Vec<f64> = used.iter().map(|&group| groups[group].temperature).collect();
    let largest = |groups: &[Group], most: usize, share: f64| -> Option<Step> {
        let rates: Vec<f64> = used.iter().map(|&group| groups[group].axes[axis].rate).collect();
        let all = jumps(&used, &rates, 0);
        let (_, sigma) = centre_and_sigma(&all.iter().map(|jump| jump.size).collect::<Vec<_>>());
        let (low, high) = ends(rates.iter().copied());
        let limit = (STEP_SIGMA * sigma.max(noise(&rates)))
            .max(STANDS_OUT * background(&all, most))
            .max(share * (high - low))
            .max(rate_margin);
        let goes_on = goes_on(groups);
        // The jump of the temperature is told by the same lines.
        let is_own = |jump: &Jump, temperature: f64| {
            temperature.abs() <= temperature_margin
                && jump.size.abs() > SURE * jump.error
                // Between two logs it is no step.
                && groups[jump.group].log == groups[jump.before].log
                // Beside a turn the rates of heating and of cooling lie on either side of a gap: hysteresis is no step.
                && (goes_on(jump.before, jump.group) || !turns(&used, &temperatures, jump.group, temperature_margin))
                && !bends(&used, &temperatures, jump.group, temperature_margin)
                && is_even(groups, &used, jump.group)
                && jump.is_confirmed(&used, &temperatures, &rates)
        };
        let largest_with = |between: usize| {
            let jumps = jumps(&used, &rates, between).into_iter().zip(jumps(&used, &temperatures, between));
            jumps
                .filter(|(jump, temperature)| {
                    // One average alone, or what was left out, lies between.
                    (jump.group - jump.before == 1 + between) == (between > 0)
                        && jump.size.abs() > limit
                        && jump.size.abs() > STEADY * jump.unsteadiness
                        && is_own(jump, temperature.size)
                })
                .map(|(jump, _)| jump)
                .max_by(|a, b| a.size.abs().total_cmp(&b.size.abs()))
        };
        let small = || {
            let is_small = |step: &SmallStep| {
                step.jump.size.abs() > rate_margin && is_own(&step.jump, step.of_others(&used, &temperatures))
            };
            let found = small_steps(&used, &rates, &goes_on).into_iter().find(is_small)?;
            Some(Jump { before: found.within.0, group: found.within.1, ..found.jump })
        };
        // What scatters by a step was left out as moved, and is its place; else it lies in an average like the others.
        let found = largest_with(0).or_else(|| largest_with(1)).or_else(|| (share == 0.0).then(small).flatten());
        Some(step(groups, axis, &found?))
    };
    let take = |groups: &mut [Group], step: Step, taken: &mut Vec<Step>| {
        let after = groups.iter_mut().filter(|group| group.first_row >= step.row);
        after.for_each(|group| group.axes[axis].rate -= step.size);
        taken.push(step);
    };
    for most in (1..=MAX_STEPS).rev() {
        let Some(step) = largest(groups, most, SHARE) else { break };
        take(groups, step, &mut steps.taken);
    }
    steps.left = largest(groups, MAX_STEPS, 0.0);
    // What went and came back by as much is taken out on both sides or on none: half of it would be a step of ours.
    let undone = |step: &Step| steps.taken.iter().any(|taken| are_opposite(taken, step));
    if let Some(step) = steps.left.take_if(|step| undone(step)) {
        take(groups, step, &mut steps.taken);
        steps.left = largest(groups, MAX_STEPS, 0.0);
    }
    steps.taken.sort_by_key(|step| step.row);
    steps
}

/// Whether the temperature turns round within the groups that show a jump to a group, by more than a margin's half.
fn turns(used: &[usize], temperatures: &[f64], group: usize, margin: f64) -> bool {
    let place = used.partition_point(|other| *other < group);
    let around = &temperatures[place.saturating_sub(REACH)..(place + REACH).min(temperatures.len())];
    let (min, max) = ends(around.iter().copied());
    let [first, last] = [around.first(), around.last()].map(|end| end.copied().unwrap_or(f64::NAN));
    max - min - (last - first).abs() > 0.5 * margin
}

/// Whether the temperature begins or ends a ramp, or turns round, at a group: there a rate that goes by how fast the temperature
/// changes jumps, and no unit has stepped. By lines through the groups on either side, which part by more than a margin's half, and
/// by more than a turn that is smooth parts them.
fn bends(used: &[usize], temperatures: &[f64], group: usize, margin: f64) -> bool {
    let place = used.partition_point(|other| *other < group);
    let reach = place.saturating_sub(REACH)..(place + REACH).min(used.len());
    let points: Vec<(f64, f64)> = reach.clone().map(|other| (used[other] as f64, temperatures[other])).collect();
    let (before, after) = points.split_at(place - reach.start);
    let [from, to] = [before, after].map(Line::through);
    let parted = (REACH as f64 * (to.slope() - from.slope())).abs();
    let apart = (to.centre() - from.centre()) / REACH as f64;
    parted > (0.5 * margin).max(BENT * apart * from.rms(before).max(to.rms(after)))
}

/// Averages around a step differ in length by this factor at most: two that were joined, and a bit of a third.
const UNEVEN: f64 = 2.5;

/// Whether the averages that show a jump to a group are of one length: where a log goes on more slowly the same drift is another
/// number of averages long, and its lines part.
fn is_even(groups: &[Group], used: &[usize], group: usize) -> bool {
    let place = used.partition_point(|other| *other < group);
    let around = &used[place.saturating_sub(REACH)..(place + REACH).min(used.len())];
    let goes_on = goes_on(groups);
    let lengths = around
        .windows(2)
        .filter(|pair| pair[1] == pair[0] + 1 && goes_on(pair[0], pair[1]))
        .map(|pair| groups[pair[1]].times_s.0 - groups[pair[0]].times_s.0);
    let (shortest, longest) = lengths.fold((f64::INFINITY, 0.0_f64), |(a, b), length| (a.min(length), b.max(length)));
    longest <= UNEVEN * shortest
}

/// Two steps in opposite directions whose sizes agree to this share are one interval of another rate.
const AGREEMENT: f64 = 0.1;

/// Whether one step undoes the other.
pub(super) fn are_opposite(one: &Step, other: &Step) -> bool {
    one.axis == other.axis && (one.size + other.size).abs() < AGREEMENT * one.size.abs()
}

/// The step that a jump is. It lies in what was left out between the groups that show it; in an average that was not it may
/// lie so near to an end that the next has some of it, and it is told between the middles of those beside it.
fn step(groups: &[Group], axis: usize, jump: &Jump) -> Step {
    let (before, after) = (&groups[jump.before], &groups[jump.group]);
    let between = &groups[jump.before + 1..jump.group];
    let middle = |group: &Group| u64::midpoint(group.first_row, group.end_row);
    let (rows, time_s, temperature) = if between.is_empty() || between.iter().any(|group| group.axes[axis].rows > 0) {
        let temperature = (before.temperature.min(after.temperature), before.temperature.max(after.temperature));
        ((middle(before), middle(after)), (before.time_s, after.time_s), temperature)
    } else {
        let temperature = between.iter().map(|group| group.temperatures).fold((f64::NAN, f64::NAN), all_of);
        ((before.end_row, after.first_row), (before.times_s.1, after.times_s.0), temperature)
    };
    Step { axis, row: after.first_row, rows, time_s, temperature, size: jump.size, error: jump.error }
}
