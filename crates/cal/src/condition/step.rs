//! Jumps of the rate that stay.

use super::robust::{centre_and_sigma, noise};
use super::{Group, Step};

/// Groups on each side of a boundary from which a line is drawn to it.
const STEP_GROUPS: usize = 8;

/// A jump at a boundary of more than this many standard deviations is a step.
const STEP_SIGMA: f64 = 12.0;

/// A step is this many times the rms of the values about the lines on either side: a rate that bends from one level to
/// another drifts, and only one that is steady before and after has stepped. The largest bends of the shared chamber
/// recording come to 9.
const STEADY: f64 = 15.0;

/// Steps taken out of one axis, at most: a rate with more of them is not one with steps.
const MAX_STEPS: usize = 8;

/// Finds the largest step of an axis, takes it out, and looks again. `temperature_margin` is the jump of the temperature
/// that explains a jump of the rate, as where a log was stopped and went on.
pub(super) fn take_out_steps(groups: &mut [Group], axis: usize, temperature_margin: f64) -> Vec<Step> {
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
        let (_, sigma) = centre_and_sigma(&jumps.iter().map(|jump| jump.size).collect::<Vec<_>>());
        let limit = STEP_SIGMA * sigma.max(noise(&rates));
        let largest = jumps
            .iter()
            .zip(&temperature_jumps)
            .filter(|(jump, temperature)| {
                jump.size.abs() > limit
                    && jump.size.abs() > STEADY * jump.unsteadiness
                    && temperature.size.abs() <= temperature_margin
            })
            .map(|(jump, _)| jump)
            .max_by(|a, b| a.size.abs().total_cmp(&b.size.abs()));
        let Some(jump) = largest else {
            break;
        };
        let first = &groups[jump.group];
        let step =
            Step { axis, row: first.first_row, time_s: first.time_s, temperature: first.temperature, size: jump.size };
        for group in &mut groups[jump.group..] {
            group.axes[axis].rate -= step.size;
        }
        steps.push(step);
    }
    steps.sort_by_key(|step| step.row);
    steps
}

/// What happens at a boundary between groups.
struct Jump {
    /// The first group after it.
    group: usize,
    /// The line through the values after it less the line through those before it, both drawn to the boundary.
    size: f64,
    /// The larger rms of the values about their lines.
    unsteadiness: f64,
}

/// The jump at each boundary with enough groups on both sides. `used` numbers the groups, so that a stretch left out
/// keeps its length.
fn jumps(used: &[usize], values: &[f64]) -> Vec<Jump> {
    let points: Vec<(f64, f64)> = used.iter().map(|&group| group as f64).zip(values.iter().copied()).collect();
    points
        .windows(2 * STEP_GROUPS)
        .zip(&used[STEP_GROUPS..])
        .map(|(window, &group)| {
            let (before, after) = window.split_at(STEP_GROUPS);
            let boundary = f64::midpoint(before[STEP_GROUPS - 1].0, after[0].0);
            let ((before, before_rms), (after, after_rms)) = (line_at(before, boundary), line_at(after, boundary));
            Jump { group, size: after - before, unsteadiness: before_rms.max(after_rms) }
        })
        .collect()
}

/// The least-squares line through points at a place, and the rms of the points about it.
fn line_at(points: &[(f64, f64)], place: f64) -> (f64, f64) {
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / n, y + point.1 / n));
    let (rise, run) = points
        .iter()
        .fold((0.0, 0.0), |(rise, run), point| (rise + (point.0 - x) * (point.1 - y), run + (point.0 - x).powi(2)));
    let slope = rise / run;
    let squares: f64 = points.iter().map(|point| (point.1 - y - slope * (point.0 - x)).powi(2)).sum();
    (y + slope * (place - x), (squares / n).sqrt())
}
