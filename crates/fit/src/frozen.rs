//! A temperature that stands still while the rates go on: its sensor, or the line to it, has stopped.
//!
//! A part that is held at one temperature has a rate that settles and stays. A rate that goes on by much of all that it does
//! in a log, at one temperature, follows one that is not shown.

use std::ops::Range;

use crate::intervals::ends;
use crate::robust::{median, noise};

/// Temperatures within this share of the log's span are one.
const STILL: f64 = 0.02;

/// So long a part of a log stands still, at least: a steady ramp is within [`STILL`] for a quarter of it, and at a slow turn for
/// about as long.
const LEAST_PART: f64 = 0.08;

/// And so many groups.
const LEAST_GROUPS: usize = 12;

/// A rate that goes on by this share of its peak to peak is none that settles: what lags behind a chamber's temperature, and
/// what a part remembers at a turn, is less.
const GOES_ON: f64 = 0.3;

/// A dozen averages of noise alone lie within so many standard deviations of each other, but for one dozen in a thousand.
const OF_NOISE: f64 = 5.0;

/// A stretch of groups at one temperature.
#[derive(Debug, Clone, PartialEq)]
pub struct Frozen {
    /// The groups.
    pub groups: Range<usize>,
    /// The axis whose rate goes on the most.
    pub axis: usize,
    /// By how much of its peak to peak over the log, 0 to 1.
    pub share: f64,
}

/// The stretches of an uninterrupted log in which the temperature stands still and a rate goes on. What a group does not have
/// is NaN.
#[must_use]
pub fn frozen(temperatures: &[f64], rates: &[Vec<f64>]) -> Vec<Frozen> {
    let (least, most) = ends(measured(temperatures));
    let near = STILL * (most - least);
    if near.is_nan() || near <= 0.0 {
        return Vec::new();
    }
    let whole = |rates: &Vec<f64>| {
        let measured = measured(rates);
        let noise = noise(&measured);
        let (least, most) = ends(measured);
        (most - least, noise)
    };
    let whole: Vec<(f64, f64)> = rates.iter().map(whole).collect();
    let long = (LEAST_PART * temperatures.len() as f64).max(LEAST_GROUPS as f64);
    still(temperatures, near)
        .into_iter()
        .filter(|groups| groups.len() as f64 >= long)
        .filter_map(|groups| {
            let shares = rates.iter().zip(&whole).enumerate().filter_map(|(axis, (rates, &(whole, noise)))| {
                let (by, by_noise) = goes_on_by(&rates[groups.clone()], noise);
                (by - by_noise >= GOES_ON * whole).then_some((axis, by / whole))
            });
            let (axis, share) = shares.max_by(|a, b| a.1.total_cmp(&b.1))?;
            Some(Frozen { groups, axis, share })
        })
        .collect()
}

/// Successive groups whose temperatures lie so near to one another, one stretch after the other.
fn still(temperatures: &[f64], near: f64) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let (mut start, mut least, mut most) = (0, f64::INFINITY, f64::NEG_INFINITY);
    for (group, temperature) in temperatures.iter().enumerate().filter(|(_, temperature)| temperature.is_finite()) {
        (least, most) = (least.min(*temperature), most.max(*temperature));
        if most - least > near {
            found.push(start..group);
            (start, least, most) = (group, *temperature, *temperature);
        }
    }
    found.push(start..temperatures.len());
    found
}

/// How far the eighths of some rates are from one another, by their medians, and how far noise alone would take them; NaN of too
/// few.
fn goes_on_by(rates: &[f64], noise: f64) -> (f64, f64) {
    let measured = measured(rates);
    let eighth = (measured.len() / 8).max(1);
    let medians: Vec<f64> = measured.chunks_exact(eighth).map(|part| median(&mut part.to_vec())).collect();
    let (least, most) = ends(medians);
    (most - least, OF_NOISE * noise / (eighth as f64).sqrt())
}

fn measured(values: &[f64]) -> Vec<f64> {
    values.iter().copied().filter(|value| value.is_finite()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GROUPS: usize = 400;

    /// Up from -20 to 60 and down again, as a chamber goes.
    fn truth() -> Vec<f64> {
        (0..GROUPS).map(|group| 20.0 - 40.0 * (group as f64 / GROUPS as f64 * std::f64::consts::TAU).cos()).collect()
    }

    fn rates(truth: &[f64]) -> Vec<Vec<f64>> {
        vec![truth.iter().map(|t| 0.01 * t).collect(), truth.iter().map(|t| 0.001 * t * t).collect()]
    }

    fn noise(group: usize) -> f64 {
        0.1 * ((group * 7919 % 101) as f64 / 101.0 - 0.5)
    }

    #[test]
    fn a_sensor_that_stops_is_found_with_noise_and_without() {
        for size in [0.0, 1.0] {
            let mut shown = truth();
            let at = shown[120];
            (120..GROUPS).for_each(|group| shown[group] = at + size * noise(group));
            let [found] = &frozen(&shown, &rates(&truth()))[..] else { panic!("{size}") };
            assert!(found.groups.start.abs_diff(120) <= 6 && found.groups.end == GROUPS, "{found:?}");
            assert!(found.share > GOES_ON, "{found:?}");
        }
    }

    #[test]
    fn noise_at_a_slow_start_is_no_rate_that_goes_on() {
        // 140 averages, the first dozen within 2 % of the span; a rate that drifts not at all beside one that does.
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / (1_u64 << 31) as f64
        };
        for _ in 0..200 {
            let shown: Vec<f64> = (0..140).map(|group| 20.0 - 25.0 * (f64::from(group) / 140.0 * 3.1).cos()).collect();
            let still: Vec<f64> = (0..140).map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0).collect();
            assert_eq!(frozen(&shown, &[shown.clone(), still]), []);
        }
    }

    #[test]
    fn a_rate_that_has_come_back_by_the_end_has_gone_on_all_the_same() {
        let mut shown = truth();
        shown[40..].fill(truth()[40]);
        let found = frozen(&shown, &rates(&truth()));
        assert!(found.iter().any(|found| found.groups.end == GROUPS && found.share > 0.9), "{found:?}");
    }

    #[test]
    fn a_turn_and_a_soak_are_none_though_the_rate_lags_behind() {
        assert_eq!(frozen(&truth(), &rates(&truth())), []);
        // Held at the hot end for a third; the rate comes after it by a time constant of 24 groups.
        let held: Vec<f64> = (0..GROUPS).map(|group| (group as f64 * 0.3 - 20.0).min(60.0)).collect();
        let lagging: Vec<f64> = held
            .iter()
            .scan(-20.0, |state, t| {
                *state += (t - *state) / 24.0;
                Some(0.01 * *state)
            })
            .collect();
        assert_eq!(frozen(&held, &[lagging]), []);
        assert_eq!(frozen(&[20.0; GROUPS], &[truth()]), []);
        assert_eq!(frozen(&[], &[vec![]]), []);
    }
}
