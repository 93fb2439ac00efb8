//! Jumps of a series: where lines through what is before and after a boundary do not meet.

use zerorate_core::drift::{Scale, Shape};

use crate::intervals::ends;
use crate::least_squares::{Basis, Fit};
use crate::line::Line;

/// Groups on each side of a boundary from which a line is drawn to it: close by, so that the temperature's slope is in
/// the lines and no more of the drift than a line holds.
pub const REACH: usize = 8;

/// A curve that may step must find at least this share of what the lines on either side find: across a long gap the lines are
/// drawn too far to be believed, and a curve through both sides joins what a step would part.
const CONFIRMED: f64 = 0.5;

/// The order of that curve.
const CURVE_ORDER: usize = 3;

/// What happens at a boundary between groups.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jump {
    /// The last group before it.
    pub before: usize,
    /// The first group after it.
    pub group: usize,
    /// The line through the values after it less the line through those before it, both drawn to the boundary.
    pub size: f64,
    /// The standard error of that, by how far the values are from their lines.
    pub error: f64,
    /// The larger rms of the values about their lines.
    pub unsteadiness: f64,
}

impl Jump {
    /// Whether a curve over temperature leaves less of what is around if it may step there, by about as much as the lines say:
    /// "no step" is the hypothesis to beat, by the Bayesian information criterion (Schwarz, 1978). Around is twice the lines'
    /// reach on each side, and as long again as the gap where there is one.
    #[must_use]
    pub fn is_confirmed(&self, used: &[usize], temperatures: &[f64], rates: &[f64]) -> bool {
        let reach = 2 * REACH + (self.group - self.before);
        let place = used.partition_point(|group| *group < self.group);
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
        size / self.size > CONFIRMED && groups * libm::log(without / (without - gained)) > libm::log(groups)
    }
}

/// The jump at each boundary with enough groups on both sides, so many left out between them. `used` numbers the groups, so that
/// an interval left out keeps its length.
#[must_use]
pub fn jumps(used: &[usize], values: &[f64], between: usize) -> Vec<Jump> {
    let points: Vec<(f64, f64)> = used.iter().map(|&group| group as f64).zip(values.iter().copied()).collect();
    points
        .windows(2 * REACH + between)
        .zip(used[REACH - 1..].windows(2 + between))
        .map(|(window, groups)| {
            let (before, after) = (&window[..REACH], &window[REACH + between..]);
            let boundary = f64::midpoint(before[REACH - 1].0, after[0].0);
            let sides = [before, after].map(|points| {
                let line = Line::through(points);
                (line.at(boundary), line.error(points, boundary), line.rms(points))
            });
            let [(from, from_error, from_rms), (to, to_error, to_rms)] = sides;
            Jump {
                before: groups[0],
                group: groups[1 + between],
                size: to - from,
                error: libm::hypot(from_error, to_error),
                unsteadiness: from_rms.max(to_rms),
            }
        })
        .collect()
}

/// The size of the largest jump that is left when so many separate ones are taken away; 0 of none.
#[must_use]
pub fn background(jumps: &[Jump], separate: usize) -> f64 {
    let mut order: Vec<usize> = (0..jumps.len()).collect();
    order.sort_by(|a, b| jumps[*b].size.abs().total_cmp(&jumps[*a].size.abs()));
    let mut peaks: Vec<usize> = Vec::new();
    for place in order {
        // A jump shows at all boundaries whose lines reach over it.
        if peaks.iter().all(|peak| place.abs_diff(*peak) >= REACH) {
            if peaks.len() == separate {
                return jumps[place].size.abs();
            }
            peaks.push(place);
        }
    }
    0.0
}

/// What the best curve over temperature leaves of some values.
fn beside_a_curve(temperatures: &[f64], values: &[f64]) -> Option<Vec<f64>> {
    let (min, max) = ends(temperatures.iter().copied());
    let mut fit = Fit::new(Scale::spanning(min, max)?, Basis::Powers(CURVE_ORDER));
    temperatures.iter().zip(values).for_each(|(temperature, value)| fit.push(*temperature, *value));
    let curve: Shape = fit.finish().ok()?.shape()?;
    Some(temperatures.iter().zip(values).map(|(temperature, value)| value - curve.evaluate(*temperature)).collect())
}
