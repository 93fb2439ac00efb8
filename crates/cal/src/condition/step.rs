//! Jumps of the rate that stay.

use zerorate_fit::jumps::{Jump, REACH, background, jumps};
use zerorate_fit::robust::{centre_and_sigma, noise};

use super::group::all_of;
use super::{Group, Step};

/// A jump at a boundary of more than this many standard deviations of all such jumps may be a step.
const STEP_SIGMA: f64 = 15.0;

/// A step is this many times the rms of the values about the lines on either side: a rate that bends from one level to
/// another drifts, and only one that is steady before and after has stepped.
const STEADY: f64 = 8.0;

/// Steps taken out of one axis, at most: a rate with more of them is not one with steps.
const MAX_STEPS: usize = 4;

/// A step stands out by this factor from the largest jump beyond [`MAX_STEPS`]. Parts jump by themselves at some
/// temperatures: the shared chamber recording has a dozen jumps, the largest 2.5 times the fifth.
const STANDS_OUT: f64 = 5.0;

/// A step that is taken out is this share of the peak to peak of the axis, at least: smaller jumps may be a part's own way of
/// drifting, and removing one would remove what is to be fitted (the largest of the shared chamber recording is 0.11). One that
/// stands out all the same is told and left in.
const SHARE: f64 = 0.15;

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
pub(super) fn take_out_steps(groups: &mut [Group], axis: usize, temperature_margin: f64) -> Steps {
    let used: Vec<usize> = (0..groups.len()).filter(|&group| groups[group].axes[axis].rows > 0).collect();
    let mut steps = Steps::default();
    if used.len() < 4 * REACH {
        return steps;
    }
    let temperatures: Vec<f64> = used.iter().map(|&group| groups[group].temperature).collect();
    let largest = |groups: &[Group], most: usize, share: f64, between: usize| -> Option<Step> {
        let rates: Vec<f64> = used.iter().map(|&group| groups[group].axes[axis].rate).collect();
        let all = jumps(&used, &rates, 0);
        let (_, sigma) = centre_and_sigma(&all.iter().map(|jump| jump.size).collect::<Vec<_>>());
        let (low, high) = rates
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), rate| (low.min(*rate), high.max(*rate)));
        let limit =
            (STEP_SIGMA * sigma.max(noise(&rates))).max(STANDS_OUT * background(&all, most)).max(share * (high - low));
        let temperature_jumps = jumps(&used, &temperatures, between);
        let jump = jumps(&used, &rates, between)
            .into_iter()
            .zip(temperature_jumps)
            .filter(|(jump, temperature)| {
                jump.size.abs() > limit
                    && jump.size.abs() > STEADY * jump.unsteadiness
                    && temperature.size.abs() <= temperature_margin
                    // Between two logs it is no step.
                    && groups[jump.group].log == groups[jump.before].log
                    && jump.is_confirmed(&used, &temperatures, &rates)
            })
            .map(|(jump, _)| jump)
            .max_by(|a, b| a.size.abs().total_cmp(&b.size.abs()))?;
        Some(step(groups, axis, &jump))
    };
    for most in (1..=MAX_STEPS).rev() {
        let Some(step) = largest(groups, most, SHARE, 0) else { break };
        let after = groups.iter_mut().filter(|group| group.first_row >= step.row);
        after.for_each(|group| group.axes[axis].rate -= step.size);
        steps.taken.push(step);
    }
    // A small step within a group leaves it there, and the line through that group is none.
    steps.left = (0..=1).find_map(|between| largest(groups, MAX_STEPS, 0.0, between));
    steps.taken.sort_by_key(|step| step.row);
    steps
}

/// The step that a jump is. Where groups were left out between those that show it, it lies in them; else the two beside it
/// may hold some of it, and it lies between their middles.
fn step(groups: &[Group], axis: usize, jump: &Jump) -> Step {
    let (before, after) = (&groups[jump.before], &groups[jump.group]);
    let middle = |group: &Group| u64::midpoint(group.first_row, group.end_row);
    let between = &groups[jump.before + 1..jump.group];
    let (rows, time_s, temperature) = if between.is_empty() {
        let temperature = (before.temperature.min(after.temperature), before.temperature.max(after.temperature));
        ((middle(before), middle(after)), (before.time_s, after.time_s), temperature)
    } else {
        let temperature = between.iter().map(|group| group.temperatures).fold((f64::NAN, f64::NAN), all_of);
        ((before.end_row, after.first_row), (before.times_s.1, after.times_s.0), temperature)
    };
    Step { axis, row: after.first_row, rows, time_s, temperature, size: jump.size }
}
