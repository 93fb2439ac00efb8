//! Jumps of the rate that stay.

use zerorate_core::drift::{Scale, Shape};
use zerorate_fit::least_squares::{Basis, Fit};
use zerorate_fit::robust::{centre_and_sigma, noise};

use super::group::all_of;
use super::line::line_at;
use super::{Group, Step};

/// Groups on each side of a boundary from which a line is drawn to it: close by, so that the temperature's slope is in
/// the lines and no more of the drift than a line holds.
const STEP_GROUPS: usize = 8;

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

/// A curve that may step must find at least this share of what the lines on either side find: across a long gap the lines are
/// drawn too far to be believed, and a curve through both sides joins what a step would part.
const CONFIRMED: f64 = 0.5;

/// The order of that curve.
const CURVE_ORDER: usize = 3;

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
    if used.len() < 4 * STEP_GROUPS {
        return steps;
    }
    let temperatures: Vec<f64> = used.iter().map(|&group| groups[group].temperature).collect();
    let largest = |groups: &[Group], most: usize, share: f64, between: usize| -> Option<Step> {
        let rates: Vec<f64> = used.iter().map(|&group| groups[group].axes[axis].rate).collect();
        let jumps = jumps(&used, &rates, 0);
        let (_, sigma) = centre_and_sigma(&jumps.iter().map(|jump| jump.size).collect::<Vec<_>>());
        let (low, high) = rates
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), rate| (low.min(*rate), high.max(*rate)));
        let limit = (STEP_SIGMA * sigma.max(noise(&rates)))
            .max(STANDS_OUT * background(&jumps, most))
            .max(share * (high - low));
        let temperature_jumps = self::jumps(&used, &temperatures, between);
        let jump = self::jumps(&used, &rates, between)
            .into_iter()
            .zip(temperature_jumps)
            .filter(|(jump, temperature)| {
                jump.size.abs() > limit
                    && jump.size.abs() > STEADY * jump.unsteadiness
                    && temperature.size.abs() <= temperature_margin
                    // Between two logs it is no step.
                    && groups[jump.group].log == groups[jump.before].log
                    && is_confirmed(jump, &used, &temperatures, &rates)
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

/// Whether a curve over temperature leaves less of what is around if it may step there, by about as much as the lines say:
/// "no step" is the hypothesis to beat, by the Bayesian information criterion (Schwarz, 1978). Around is twice the lines'
/// reach on each side, and as long again as the gap where there is one.
fn is_confirmed(jump: &Jump, used: &[usize], temperatures: &[f64], rates: &[f64]) -> bool {
    let reach = 2 * STEP_GROUPS + (jump.group - jump.before);
    let place = used.partition_point(|group| *group < jump.group);
    let around = place.saturating_sub(reach)..(place + reach).min(used.len());
    let after: Vec<f64> = around.clone().map(|other| f64::from(u8::from(other >= place))).collect();
    let (temperatures, rates) = (&temperatures[around.clone()], &rates[around]);
    let Some((rates, after)) = beside_a_curve(temperatures, rates).zip(beside_a_curve(temperatures, &after)) else {
        return false;
    };
    // Both less the curve: the coefficient is that of a fit of curve and step together (Frisch and Waugh, 1933).
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let size = product(&rates, &after) / product(&after, &after);
    let (without, gained) = (product(&rates, &rates), size * product(&rates, &after));
    let groups = rates.len() as f64;
    size / jump.size > CONFIRMED && groups * (without / (without - gained)).ln() > groups.ln()
}

/// What the best curve over temperature leaves of some values.
fn beside_a_curve(temperatures: &[f64], values: &[f64]) -> Option<Vec<f64>> {
    let (min, max) = temperatures.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(*t), b.max(*t)));
    let mut fit = Fit::new(Scale::spanning(min, max)?, Basis::Powers(CURVE_ORDER));
    temperatures.iter().zip(values).for_each(|(temperature, value)| fit.push(*temperature, *value));
    let curve: Shape = fit.finish().ok()?.shape()?;
    Some(temperatures.iter().zip(values).map(|(temperature, value)| value - curve.evaluate(*temperature)).collect())
}

/// The size of the largest jump that is left when so many separate ones are taken away; 0 of none.
fn background(jumps: &[Jump], separate: usize) -> f64 {
    let mut order: Vec<usize> = (0..jumps.len()).collect();
    order.sort_by(|a, b| jumps[*b].size.abs().total_cmp(&jumps[*a].size.abs()));
    let mut peaks: Vec<usize> = Vec::new();
    for place in order {
        // A jump shows at all boundaries whose lines reach over it.
        if peaks.iter().all(|peak| place.abs_diff(*peak) >= STEP_GROUPS) {
            if peaks.len() == separate {
                return jumps[place].size.abs();
            }
            peaks.push(place);
        }
    }
    0.0
}

/// What happens at a boundary between groups.
struct Jump {
    /// The last group before it.
    before: usize,
    /// The first group after it.
    group: usize,
    /// The line through the values after it less the line through those before it, both drawn to the boundary.
    size: f64,
    /// The larger rms of the values about their lines.
    unsteadiness: f64,
}

/// The jump at each boundary with enough groups on both sides, so many left out between them. `used` numbers the groups, so that
/// an interval left out keeps its length.
fn jumps(used: &[usize], values: &[f64], between: usize) -> Vec<Jump> {
    let points: Vec<(f64, f64)> = used.iter().map(|&group| group as f64).zip(values.iter().copied()).collect();
    points
        .windows(2 * STEP_GROUPS + between)
        .zip(used[STEP_GROUPS - 1..].windows(2 + between))
        .map(|(window, groups)| {
            let (before, after) = (&window[..STEP_GROUPS], &window[STEP_GROUPS + between..]);
            let boundary = f64::midpoint(before[STEP_GROUPS - 1].0, after[0].0);
            let ((before, before_rms), (after, after_rms)) = (line_at(before, boundary), line_at(after, boundary));
            let unsteadiness = before_rms.max(after_rms);
            Jump { before: groups[0], group: groups[1 + between], size: after - before, unsteadiness }
        })
        .collect()
}
