//! A step that is smaller than what lines on either side can tell: a matched filter over more of a series.
//!
//! Over a window the best cubic in time is taken from the values and from a step in its middle (Frisch and Waugh, 1933). What is
//! left of the one along what is left of the other is the step's size, and over its standard error a statistic z, of variance
//! 1 for white noise about any smooth drift. A drift that bends sharper than a cubic makes z large in many places. So a step is
//! told where z is large by what z is along the series, and where nothing else in it comes near.

use std::ops::Range;

use crate::jumps::Jump;
use crate::robust::{centre_and_sigma, noise};

/// Values on each side of the step: few where a drift bends, many where noise is all that hides it.
const REACHES: [usize; 2] = [12, 30];

/// Powers of time that a drift may have in a window.
const POWERS: usize = 4;

/// A step has at least this z, and as many times the standard deviation of z along the series. 99 of 100 series of a thousand white
/// values stay below 4.5; drift's own bends are the rest.
const LEAST: f64 = 5.5;

/// And stands out by this factor from the largest z that has none of it.
const STANDS_OUT: f64 = 1.35;

/// Less of a step than this share is not left where the window's values lie unevenly.
const LEFT_OF_STEP: f64 = 1e-2;

/// Where the likelihood of a place is a twentieth of the clearest one's, or less, the step is not: twice the logarithm, by which z
/// squared is less.
const TWENTIETH: f64 = 5.99;

/// A step that stands out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SmallStep {
    /// It, where it is the likeliest.
    pub jump: Jump,
    /// The groups between which it may as well lie: the last before it and the first after it.
    pub within: (usize, usize),
    /// Values on each side that show it.
    reach: usize,
}

/// The statistic at a boundary.
#[derive(Debug, Clone, Copy)]
struct Matched {
    /// The place of the first value after it.
    place: usize,
    size: f64,
    error: f64,
    rms: f64,
}

impl Matched {
    fn z(&self) -> f64 {
        (self.size / self.error).abs()
    }
}

/// The steps that may be one, the clearest first; at most one of each reach. `used` numbers the values' groups, and `goes_on` says
/// whether the series goes on from one to the next: no window reaches over a place where it does not.
#[must_use]
pub fn small_steps(used: &[usize], values: &[f64], goes_on: impl Fn(usize, usize) -> bool) -> Vec<SmallStep> {
    let sigma = noise(values);
    let mut start = 0;
    let stretches: Vec<Range<usize>> = used
        .chunk_by(|a, b| goes_on(*a, *b))
        .map(|stretch| {
            start += stretch.len();
            start - stretch.len()..start
        })
        .collect();
    let mut found: Vec<(f64, SmallStep)> = REACHES
        .iter()
        .filter_map(|&reach| {
            let all: Vec<Matched> =
                stretches.iter().flat_map(|stretch| along(used, values, stretch.clone(), reach, sigma)).collect();
            let peak = *all.iter().max_by(|a, b| a.z().total_cmp(&b.z()))?;
            let signed: Vec<f64> = all.iter().map(|matched| matched.size / matched.error).collect();
            let typical = centre_and_sigma(&signed).1.max(1.0);
            let elsewhere = all.iter().filter(|other| other.place.abs_diff(peak.place) > reach);
            let elsewhere = elsewhere.map(Matched::z).fold(0.0, f64::max);
            let stands_out = peak.z() > LEAST * typical && peak.z() > STANDS_OUT * elsewhere;
            let jump = Jump {
                before: used[peak.place - 1],
                group: used[peak.place],
                size: peak.size,
                error: peak.error,
                unsteadiness: peak.rms,
            };
            let as_likely = |matched: &&Matched| {
                matched.place.abs_diff(peak.place) <= reach && peak.z().powi(2) - matched.z().powi(2) < TWENTIETH
            };
            let places = || all.iter().filter(as_likely).map(|matched| matched.place);
            let (first, last) = (places().min().unwrap_or(peak.place), places().max().unwrap_or(peak.place));
            let within = (used[first - 1], used[last]);
            stands_out.then_some((peak.z() / typical, SmallStep { jump, within, reach }))
        })
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.into_iter().map(|(_, step)| step).collect()
}

impl SmallStep {
    /// What the same window shows at the same place of other values, as of the temperature.
    #[must_use]
    pub fn of_others(&self, used: &[usize], values: &[f64]) -> f64 {
        let place = used.partition_point(|other| *other < self.jump.group);
        matched(used, values, place, self.reach, 0.0).map_or(0.0, |matched| matched.size)
    }
}

fn along(used: &[usize], values: &[f64], stretch: Range<usize>, reach: usize, sigma: f64) -> Vec<Matched> {
    let places = stretch.start + reach..(stretch.end + 1).saturating_sub(reach);
    places.filter(|place| *place < used.len()).filter_map(|place| matched(used, values, place, reach, sigma)).collect()
}

fn matched(used: &[usize], values: &[f64], place: usize, reach: usize, sigma: f64) -> Option<Matched> {
    let window = place - reach..place + reach;
    let (first, last) = (used[window.start] as f64, used[window.end - 1] as f64);
    let time = |group: &usize| (2.0 * *group as f64 - first - last) / (last - first);
    let times: Vec<f64> = used[window.clone()].iter().map(time).collect();
    let mut step: Vec<f64> = window.clone().map(|other| if other < place { 0.0 } else { 1.0 }).collect();
    let mut values = values[window].to_vec();
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(POWERS);
    for power in 0..POWERS {
        let mut column: Vec<f64> = times.iter().map(|time| time.powi(i32::try_from(power).unwrap_or(0))).collect();
        basis.iter().for_each(|other| take(&mut column, other));
        let length = product(&column, &column).sqrt();
        column.iter_mut().for_each(|value| *value /= length);
        take(&mut step, &column);
        take(&mut values, &column);
        basis.push(column);
    }
    let left = product(&step, &step);
    if left < LEFT_OF_STEP * step.len() as f64 {
        return None;
    }
    let size = product(&step, &values) / left;
    let squares = (product(&values, &values) - size * size * left).max(0.0);
    let rms = (squares / (step.len() - POWERS - 1) as f64).sqrt();
    Some(Matched { place, size, error: rms.max(sigma) / left.sqrt(), rms })
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Takes from some values what they have along a column of length 1.
fn take(values: &mut [f64], column: &[f64]) {
    let along = product(values, column);
    values.iter_mut().zip(column).for_each(|(value, column)| *value -= along * column);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nearly normal, of variance 1: the sum of twelve uniform numbers, less six.
    fn noise(seed: u64, count: usize) -> Vec<f64> {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..count).map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0).collect()
    }

    const GROUPS: usize = 500;

    /// Two turns of a drift three hundred times its noise, with a step.
    fn drifting(seed: u64, step: f64) -> Vec<f64> {
        let drift = |group: usize| 150.0 * (group as f64 / GROUPS as f64 * 12.0).sin();
        let value = |(group, noise): (usize, f64)| drift(group) + noise + if group < 200 { 0.0 } else { step };
        noise(seed, GROUPS).into_iter().enumerate().map(value).collect()
    }

    fn found(values: &[f64]) -> Vec<SmallStep> {
        let used: Vec<usize> = (0..values.len()).collect();
        small_steps(&used, values, |_, _| true)
    }

    #[test]
    fn the_size_and_its_error_are_numpys() {
        // g = numpy.arange(24.); y = 0.3 * numpy.sin(1.7 * g) + 0.01 * g**2 + numpy.where(g >= 12, 2.0, 0)
        // x = (2 * g - 23) / 23; a = numpy.c_[numpy.ones(24), x, x**2, x**3, g >= 12]
        // c, r, _, _ = numpy.linalg.lstsq(a, y); c[4], numpy.sqrt(r[0] / 19 * numpy.linalg.inv(a.T @ a)[4, 4])
        let value = |g: f64| 0.3 * (1.7 * g).sin() + 0.01 * g * g + if g >= 12.0 { 2.0 } else { 0.0 };
        let values: Vec<f64> = (0..24).map(|g| value(f64::from(g))).collect();
        let used: Vec<usize> = (0..24).collect();
        let step = matched(&used, &values, 12, 12, 0.0).unwrap();
        assert!((step.size - 2.208_440_898_9).abs() < 1e-9, "{step:?}");
        assert!((step.error - 0.255_224_168_2).abs() < 1e-9, "{step:?}");
    }

    #[test]
    fn noise_about_a_smooth_drift_has_no_step() {
        let told = (0..200).filter(|seed| !found(&drifting(*seed, 0.0)).is_empty()).count();
        assert!(told <= 2, "{told} of 200");
    }

    #[test]
    fn a_step_of_eight_standard_deviations_is_found_in_its_place_and_sized_to_its_error() {
        let (mut told, mut squares) = (0.0, 0.0);
        for seed in 0..100 {
            let steps = found(&drifting(1000 + seed, -8.0));
            let Some(step) = steps.first() else { continue };
            assert!(step.within.0 < 200 && 200 <= step.within.1 && step.within.1 - step.within.0 < 10, "{step:?}");
            told += 1.0;
            squares += ((step.jump.size + 8.0) / step.jump.error).powi(2);
        }
        // By about its error, a little less than that where noise has moved the place.
        let rms = f64::sqrt(squares / told);
        assert!(told > 90.0 && (0.5..1.5).contains(&rms), "{told}, {rms}");
    }

    #[test]
    fn what_jumps_where_a_series_does_not_go_on_is_no_step() {
        let used: Vec<usize> = (0..GROUPS).collect();
        let values = drifting(7, 20.0);
        assert!(small_steps(&used, &values, |before, _| before != 199).is_empty());
        assert_eq!(small_steps(&used, &values, |_, _| true)[0].jump.group, 200);
    }
}
