//! A trend that a residual still has, in time, over temperature or from one direction to the other: what a reader would see in
//! the figure, in a number.
//!
//! It is asked of what the model leaves of the recording that it was fitted to, without its drift in time: held out, a fold at
//! an end would make the trend larger than it is. Neighbouring groups are alike, so that a slope's error follows from the
//! folds: it is fitted eight times, each time without one of them (the jackknife: Efron, *The Jackknife, the Bootstrap and
//! Other Resampling Plans*, 1982, chapter 3).

use serde::{Deserialize, Serialize};

use crate::direction::warming;
use crate::folds::{FOLDS, TELLING, fold_of_row, jackknife_error};
use crate::intervals::ends;
use crate::series::Series;

/// Noise alone exceeds this, to either side, once in a thousand times: Student's t of seven degrees of freedom, one fewer
/// than folds. A log has six axes and three trends each.
const BEYOND_NOISE: f64 = 5.408;

/// Where time and temperature correlate more than this, the log does not tell a trend in one from a trend in the other.
const ALIKE: f64 = 0.9;

/// What a trend is against.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Against {
    /// Time: from a log's start to its end.
    Time,
    /// Temperature: from the coldest group to the hottest.
    Temperature,
    /// The direction of the temperature: from cooling to heating.
    Direction,
    /// Time or temperature, and the log does not tell which: from its start to its end.
    TimeOrTemperature,
}

/// A straight trend in a residual.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Trend {
    /// Against what.
    pub against: Against,
    /// What it comes to from one end to the other, rate units; below 0 where the residual falls.
    pub change: f64,
    /// The standard error of that.
    pub standard_error: f64,
}

/// A group's residual, and where it stands: in time, seconds, in temperature, and half to either side of none while it heats or
/// cools.
#[derive(Debug, Clone, Copy)]
struct Point {
    log: u32,
    fold: usize,
    residual: f64,
    at: [f64; 3],
}

const TIME: usize = 0;
const TEMPERATURE: usize = 1;
const DIRECTION: usize = 2;

/// The trends of a residual, a group each (NaN for one without): the clearest first, and each other one in what is left
/// without it. None in most.
#[must_use]
pub fn trends(residuals: &[f64], series: &Series<'_>) -> Vec<Trend> {
    let groups = residuals.len() as u64;
    let warming = warming(series.temperature);
    let point = |(group, residual): (usize, &f64)| Point {
        log: series.log[group],
        fold: fold_of_row(group as u64, groups),
        residual: *residual,
        at: [series.time_s[group], series.temperature[group], if warming[group] { 0.5 } else { -0.5 }],
    };
    let mut points: Vec<Point> = residuals.iter().enumerate().map(point).collect();
    points.retain(|point| point.residual.is_finite() && point.at[TEMPERATURE].is_finite());
    // A log without times has none at all.
    let has_times = points.iter().all(|point| point.at[TIME].is_finite());
    let mut axes = if has_times { vec![TIME, TEMPERATURE, DIRECTION] } else { vec![TEMPERATURE, DIRECTION] };
    let alike = has_times && correlation(&points).abs() > ALIKE;
    let mut found = Vec::new();
    loop {
        let clear = axes.iter().filter_map(|&axis| Some((axis, Slope::of(&points, axis)?)));
        let Some((axis, slope)) = clear.max_by(|(_, a), (_, b)| a.t().total_cmp(&b.t())) else { return found };
        let against = match axis {
            DIRECTION => Against::Direction,
            _ if alike => Against::TimeOrTemperature,
            TIME => Against::Time,
            _ => Against::Temperature,
        };
        let (sign, span) = if alike { along_time(&points, axis) } else { (1.0, span(&points, axis)) };
        found.push(Trend { against, change: sign * slope.slope * span, standard_error: slope.standard_error * span });
        axes.retain(|&other| other != axis && !alike);
        points.iter_mut().for_each(|point| point.residual -= slope.slope * point.at[axis]);
    }
}

/// A slope and its standard error, where the slope is none of noise and worth telling.
struct Slope {
    slope: f64,
    standard_error: f64,
}

impl Slope {
    fn of(points: &[Point], axis: usize) -> Option<Self> {
        let slope = slope(points.iter(), axis);
        let mut folds: Vec<usize> = points.iter().map(|point| point.fold).collect();
        folds.dedup();
        if folds.len() < FOLDS {
            return None;
        }
        let without = folds.iter().map(|fold| slope_without(points, axis, *fold)).collect::<Vec<_>>();
        let found = Self { slope, standard_error: jackknife_error(&without) };
        let square = |slope: f64| {
            let left = centred(points.iter().map(|point| (point.log, point.residual - slope * point.at[axis])));
            left.iter().map(|left| left.powi(2)).sum::<f64>()
        };
        let is_worth_it = square(slope) * TELLING.powi(2) < square(0.0);
        (is_worth_it && found.t() > BEYOND_NOISE).then_some(found)
    }

    /// How many standard errors it is from none.
    fn t(&self) -> f64 {
        self.slope.abs() / self.standard_error
    }
}

fn slope_without(points: &[Point], axis: usize, fold: usize) -> f64 {
    slope(points.iter().filter(|point| point.fold != fold), axis)
}

/// The slope by least squares, each log about its own mean: its zero is its own.
fn slope<'p>(points: impl Iterator<Item = &'p Point> + Clone, axis: usize) -> f64 {
    let at = centred(points.clone().map(|point| (point.log, point.at[axis])));
    let residuals = points.map(|point| point.residual);
    let (products, squares) = at
        .iter()
        .zip(residuals)
        .fold((0.0, 0.0), |(products, squares), (at, residual)| (products + at * residual, squares + at * at));
    products / squares
}

/// Values of successive logs, each less the mean of its own.
fn centred(values: impl Iterator<Item = (u32, f64)>) -> Vec<f64> {
    let values: Vec<(u32, f64)> = values.collect();
    let of_log = |log: &[(u32, f64)]| {
        let mean = log.iter().map(|(_, value)| value).sum::<f64>() / log.len() as f64;
        log.iter().map(|(_, value)| value - mean).collect::<Vec<_>>()
    };
    values.chunk_by(|a, b| a.0 == b.0).flat_map(of_log).collect()
}

/// How time and temperature go together, -1 to 1.
fn correlation(points: &[Point]) -> f64 {
    let [times, temperatures] = [TIME, TEMPERATURE].map(|axis| centred(points.iter().map(|p| (p.log, p.at[axis]))));
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    product(&times, &temperatures) / (product(&times, &times) * product(&temperatures, &temperatures)).sqrt()
}

/// How far the points reach: in time within the longest log, in temperature over all.
fn span(points: &[Point], axis: usize) -> f64 {
    let reach = |points: &[Point]| {
        let (min, max) = ends(points.iter().map(|point| point.at[axis]));
        max - min
    };
    match axis {
        TIME => points.chunk_by(|a, b| a.log == b.log).map(reach).fold(0.0, f64::max),
        _ => reach(points),
    }
}

/// Which way an axis went with time, and how far: 1 where it rose.
fn along_time(points: &[Point], axis: usize) -> (f64, f64) {
    let sign = if axis == TEMPERATURE { correlation(points).signum() } else { 1.0 };
    (sign, span(points, axis))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::NextRun;

    /// White noise of one, evenly spread: a linear congruential generator's high bits (Knuth, volume 2, 3.3.4).
    fn noise(seed: u64, count: usize) -> Vec<f64> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / f64::from(1 << 24)
        };
        // Twelve of them have a variance of one.
        (0..count).map(|_| (0..12).map(|_| next()).sum::<f64>() - 6.0).collect()
    }

    const GROUPS: usize = 800;

    fn times() -> Vec<f64> {
        (0..GROUPS).map(|group| 10.0 * group as f64).collect()
    }

    /// There and back again.
    fn cycle() -> Vec<f64> {
        (0..GROUPS).map(|group| 20.0 - 40.0 * (group as f64 / GROUPS as f64 * std::f64::consts::TAU).cos()).collect()
    }

    fn found(temperature: &[f64], residuals: &[f64]) -> Vec<Trend> {
        let (time_s, ones, log) = (times(), [1.0; GROUPS], [0; GROUPS]);
        let series = Series {
            time_s: &time_s,
            temperature,
            shown: temperature,
            rate: residuals,
            weight: &ones,
            log: &log,
            next: NextRun::Another,
        };
        trends(residuals, &series)
    }

    #[test]
    fn a_trend_put_in_is_found_with_its_size_and_named_by_what_it_is_against() {
        for seed in 1..=20 {
            let drifting: Vec<f64> =
                noise(seed, GROUPS).iter().zip(times()).map(|(noise, time)| noise - 3.0 * time / 7990.0).collect();
            let [trend] = found(&cycle(), &drifting)[..] else { panic!("one trend, seed {seed}") };
            assert_eq!(trend.against, Against::Time);
            // The standard error of a slope over a span, of 800 of noise 1: sqrt(12 / 800) = 0.12.
            assert!((trend.change + 3.0).abs() < 0.5 && (0.03..0.4).contains(&trend.standard_error), "{trend:?}");

            let curved: Vec<f64> =
                noise(seed, GROUPS).iter().zip(cycle()).map(|(noise, t)| noise + 3.0 * (t - 20.0) / 80.0).collect();
            let [trend] = found(&cycle(), &curved)[..] else { panic!("one trend, seed {seed}") };
            assert_eq!(trend.against, Against::Temperature);
            assert!((trend.change - 3.0).abs() < 0.5, "{trend:?}");
        }
    }

    #[test]
    fn a_loop_is_told_by_its_two_directions() {
        let loops = |group: usize| if group < GROUPS / 2 { 0.75 } else { -0.75 };
        // Cycles by which time says nothing of it.
        let cycle = cycle();
        let twice: Vec<f64> = (0..GROUPS).map(|group| cycle[2 * group % GROUPS]).collect();
        for seed in 1..=20 {
            let looped: Vec<f64> = noise(seed, GROUPS)
                .iter()
                .enumerate()
                .map(|(group, noise)| noise + loops(2 * group % GROUPS))
                .collect();
            let [trend] = found(&twice, &looped)[..] else { panic!("one trend, seed {seed}") };
            assert_eq!(trend.against, Against::Direction);
            assert!((trend.change - 1.5).abs() < 0.3, "{trend:?}");
        }
    }

    #[test]
    fn noise_has_no_trend() {
        // One in a thousand is expected by the slope's error alone, and none of them makes a twentieth of the rms.
        assert!((1..=200).all(|seed| found(&cycle(), &noise(seed, GROUPS)).is_empty()));
    }

    #[test]
    fn in_one_ramp_time_and_temperature_are_not_told_apart() {
        let falling: Vec<f64> = times().iter().map(|time| 60.0 - 0.01 * time).collect();
        let residuals: Vec<f64> =
            noise(7, GROUPS).iter().zip(times()).map(|(noise, time)| noise + 4.0 * time / 7990.0).collect();
        let [trend] = found(&falling, &residuals)[..] else { panic!("one trend") };
        assert_eq!(trend.against, Against::TimeOrTemperature);
        assert!((trend.change - 4.0).abs() < 0.5, "it rises from start to end: {trend:?}");
    }

    #[test]
    fn a_trend_that_one_fold_makes_is_none() {
        let mut residuals = noise(3, GROUPS);
        residuals[700..].iter_mut().for_each(|residual| *residual += 3.0);
        assert_eq!(found(&cycle(), &residuals).into_iter().filter(|trend| trend.against == Against::Time).count(), 0);
    }
}
