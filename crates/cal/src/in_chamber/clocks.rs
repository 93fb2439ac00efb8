//! Whether the two clocks by which a log and a chamber's recording are joined agree, as far as the data tell: a sensor cannot answer
//! before its air has moved, and one that answers long after it lies deep in a board, or its log's clock is late.

use zerorate_fit::intervals::ends;

/// Air and sensor must have moved by this for anything to be told, kelvins.
const MOVED_K: f64 = 5.0;
/// How far apart the clocks are looked for, seconds, where the recordings are long enough.
const FARTHEST_S: f64 = 1200.0;
/// In steps of this, seconds: an average of a log is of ten.
const STEP_S: f64 = 2.0;
/// So many averages at least.
const LEAST_POINTS: usize = 100;
/// An answer that leaves so many times the least is held possible: what a board of several stages leaves is no noise.
const AS_GOOD: f64 = 2.0;
/// A sensor in the chamber goes as far as the air, within a factor of two: its own scale may be off.
const GAIN: [f64; 2] = [0.5, 2.0];
/// What is left of the way by the best answer, of what the way itself is, rms: beyond it the sensor does not follow this air.
const FOLLOWS: f64 = 0.05;

/// Between which seconds after the air the sensor begins to answer, beside its lag; below 0 it is before it. `None` where that cannot
/// be told: too little has moved, or the sensor does not follow this air. `air` and `sensor` are times and temperatures, in order.
///
/// A sensor that follows with the time constant tau and answers d later obeys `tau ds/dt = g a(t - d) + b - s`. Its integral,
/// `S(t) = g A(t - d) + b t + c - tau s(t)`, is linear in all but d: it is solved for each d, and what is left says how good that is.
pub(super) fn answers(air: &[(f64, f64)], sensor: &[(f64, f64)]) -> Option<[f64; 2]> {
    let air: Vec<(f64, f64)> = air.iter().copied().filter(|(_, c)| c.is_finite()).collect();
    let (first, last) = (air.first()?.0, air.last()?.0);
    let farthest = (FARTHEST_S).min((last - first) / 4.0);
    let is_within = |time_s: f64| (first + farthest..=last - farthest).contains(&time_s);
    let sensor: Vec<(f64, f64)> =
        sensor.iter().copied().filter(|(time_s, c)| is_within(*time_s) && c.is_finite()).collect();
    let (from_s, to_s) = (sensor.first()?.0, sensor.last()?.0);
    let there = air.iter().filter(|(time_s, _)| (from_s..=to_s).contains(time_s));
    if sensor.len() < LEAST_POINTS || span(there) < MOVED_K || span(sensor.iter()) < MOVED_K {
        return None;
    }
    let (air, own) = (integral(&air), integral(&sensor));
    let mut known: Vec<Vec<f64>> = Vec::new();
    for column in [vec![1.0; sensor.len()], own.iter().map(|(time_s, _)| time_s - from_s).collect()] {
        known.push(unit(beside(column, &known)));
    }
    let whole = beside(own.iter().map(|(_, integral)| *integral).collect(), &known);
    known.push(unit(beside(sensor.iter().map(|(_, c)| *c).collect(), &known)));
    let still = beside(whole.clone(), &known);
    #[allow(clippy::cast_possible_truncation)] // some hundred steps
    let steps = (farthest / STEP_S) as i32;
    let left: Vec<(f64, f64)> = (-steps..=steps)
        .filter_map(|step| {
            let after_s = f64::from(step) * STEP_S;
            let mut at = 0;
            let shifted = sensor.iter().map(|(time_s, _)| interpolated(&air, time_s - after_s, &mut at)).collect();
            let column = beside(shifted, &known);
            let gain = dot(&column, &still) / dot(&column, &column);
            let rest: Vec<f64> = still.iter().zip(&column).map(|(own, air)| own - gain * air).collect();
            (GAIN[0]..=GAIN[1]).contains(&gain).then(|| (after_s, dot(&rest, &rest)))
        })
        .collect();
    let least = left.iter().map(|(_, left)| *left).fold(f64::INFINITY, f64::min);
    if least.sqrt() > FOLLOWS * dot(&whole, &whole).sqrt() {
        return None;
    }
    let as_good = || left.iter().filter(|(_, left)| *left <= AS_GOOD * least).map(|(after_s, _)| *after_s);
    // What is as good at the end of what was looked at may be better beyond it.
    let between = [as_good().next()?, as_good().next_back()?];
    between.iter().all(|end| end.abs() < f64::from(steps) * STEP_S).then_some(between)
}

fn span<'a>(points: impl Iterator<Item = &'a (f64, f64)>) -> f64 {
    let (low, high) = ends(points.map(|(_, c)| *c));
    high - low
}

/// A curve's integral from its first point, by trapezoids.
fn integral(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut sum = 0.0;
    let steps = points.windows(2).map(|pair| {
        sum += (pair[1].0 - pair[0].0) * f64::midpoint(pair[0].1, pair[1].1);
        (pair[1].0, sum)
    });
    points.first().map(|first| (first.0, 0.0)).into_iter().chain(steps).collect()
}

/// A curve between its points; `at` is where the last was found, for times that rise.
fn interpolated(points: &[(f64, f64)], time_s: f64, at: &mut usize) -> f64 {
    while *at + 2 < points.len() && points[*at + 1].0 < time_s {
        *at += 1;
    }
    let (from, to) = (points[*at], points[*at + 1]);
    from.1 + (to.1 - from.1) * (time_s - from.0) / (to.0 - from.0).max(f64::MIN_POSITIVE)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// What of a column stands beside those that are known, each of length one: taken off twice, for they are nearly along it.
fn beside(mut column: Vec<f64>, known: &[Vec<f64>]) -> Vec<f64> {
    for _ in 0..2 {
        for own in known {
            let share = dot(own, &column);
            column.iter_mut().zip(own).for_each(|(value, own)| *value -= share * own);
        }
    }
    column
}

fn unit(mut column: Vec<f64>) -> Vec<f64> {
    let length = dot(&column, &column).sqrt();
    column.iter_mut().for_each(|value| *value /= length.max(f64::MIN_POSITIVE));
    column
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 20 C for an hour, to -20 C at 1 K/min, an hour there, to 50 C at 2.5 K/min and an hour there, with a regulation's ripple; each second.
    fn air() -> Vec<(f64, f64)> {
        (0..4 * 3600 + 5280)
            .map(f64::from)
            .map(|time_s| {
                let minute = time_s / 60.0;
                let set_c = match minute {
                    ..60.0 => 20.0,
                    60.0..100.0 => 20.0 - (minute - 60.0),
                    100.0..160.0 => -20.0,
                    _ => f64::min(-20.0 + 2.5 * (minute - 160.0), 50.0),
                };
                (time_s, set_c + 0.1 * (time_s / 30.0).sin())
            })
            .collect()
    }

    /// Stages behind the air, by Euler's steps of a second; averages of ten seconds with noise, told by a clock that is late by so
    /// much, from a sensor that is off and whose degrees are too small.
    fn sensor(time_constants_s: &[f64], late_s: f64) -> Vec<(f64, f64)> {
        let mut stages = vec![26.0; time_constants_s.len()];
        let mut random = 7_u64;
        let own: Vec<f64> = air()
            .iter()
            .map(|(_, air)| {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let noise = (random >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
                let followed = stages.iter_mut().zip(time_constants_s).fold(*air, |about, (at, time_constant_s)| {
                    *at += (about - *at) / time_constant_s;
                    *at
                });
                1.1 * followed + 4.0 + 0.2 * noise
            })
            .collect();
        let averages = own.chunks_exact(10).enumerate();
        averages.map(|(place, ten)| (10.0 * place as f64 + 4.5 + late_s, ten.iter().sum::<f64>() / 10.0)).collect()
    }

    #[test]
    fn a_clock_that_is_off_by_25_seconds_is_seen_to_be_off_by_so_much() {
        for (lag_s, late_s) in
            [(150.0, 25.0), (150.0, -25.0), (150.0, 0.0), (30.0, -25.0), (900.0, -60.0), (900.0, 300.0)]
        {
            let [from, to] = answers(&air(), &sensor(&[lag_s], late_s)).unwrap();
            assert!((from - 3.0..=to + 3.0).contains(&late_s) && to - from < 20.0, "{lag_s}, {late_s}: {from} to {to}");
        }
    }

    #[test]
    fn stages_behind_one_another_answer_late_and_never_early() {
        for stages in [&[150.0, 25.0][..], &[300.0, 150.0], &[600.0, 60.0, 60.0]] {
            let [_, to] = answers(&air(), &sensor(stages, 0.0)).unwrap();
            assert!(to >= 0.0, "{stages:?}: {to}");
            // A second stage that is short beside the first is its time constant late, and a clock as much on top.
            let [from, late] = answers(&air(), &sensor(stages, 200.0)).unwrap();
            assert!(from > 190.0 && late < 450.0, "{stages:?}: {from} to {late}");
        }
    }

    #[test]
    fn nothing_is_told_of_what_does_not_move_or_does_not_follow() {
        let still: Vec<(f64, f64)> = air().iter().map(|(time_s, _)| (*time_s, 20.0)).collect();
        assert_eq!(answers(&still, &sensor(&[150.0], 0.0)), None);
        let other: Vec<(f64, f64)> =
            sensor(&[150.0], 0.0).iter().map(|(time_s, _)| (*time_s, 30.0 + 10.0 * (time_s / 900.0).sin())).collect();
        assert_eq!(answers(&air(), &other), None);
        assert_eq!(answers(&air(), &[]), None);
        assert_eq!(answers(&[], &sensor(&[150.0], 0.0)), None);
    }
}
