//! Which way the temperature was going, point by point, without being fooled by noise.

use crate::intervals::{Interval, ends, joined};

/// A turn counts once the temperature has come back by this part of its span.
const TURN: f64 = 0.03;

/// For each temperature, in order of time, whether it was recorded while the unit warmed.
#[must_use]
pub fn warming(temperatures: &[f64]) -> Vec<bool> {
    let (min, max) = ends(temperatures.iter().copied().filter(|t| t.is_finite()));
    let turn = TURN * (max - min);
    let mut warming = vec![true; temperatures.len()];
    // The leg begins at the last extreme; its direction is known once the temperature has moved by a turn.
    let (mut start, mut up) = (0, None);
    let (mut lowest, mut highest) = (0, 0);
    for (place, now) in temperatures.iter().enumerate().filter(|(_, now)| now.is_finite()) {
        if *now < temperatures[lowest] || temperatures[lowest].is_nan() {
            lowest = place;
        }
        if *now > temperatures[highest] || temperatures[highest].is_nan() {
            highest = place;
        }
        let risen = up != Some(true) && *now > temperatures[lowest] + turn;
        let fallen = up != Some(false) && *now < temperatures[highest] - turn;
        if risen || fallen {
            let extreme = if risen { lowest } else { highest };
            // What came before the extreme went the other way. Before the first leg there was no turn, only noise: a
            // recording that only warms does not begin by cooling.
            warming[start..extreme].fill(if up.is_none() { risen } else { !risen });
            (start, up) = (extreme, Some(risen));
            (lowest, highest) = (place, place);
        }
    }
    warming[start..].fill(up.unwrap_or(true));
    warming
}

/// Both directions must travel this share of the span for a history, or a drift in time, to be told from the curve.
const TRAVEL: f64 = 1.0 / 3.0;

/// A turn back by less than this share of the span is noise.
const NOISE: f64 = 0.05;

/// Whether the temperatures of logs, each in order of time, go up and down by a third of their span or more, turns of noise not
/// counted. From the end of one log to the start of the next nobody saw them go.
pub(crate) fn go_both_ways(logs: &[&[f64]]) -> bool {
    let finite = |log: &[f64]| log.iter().copied().filter(|t| t.is_finite()).collect::<Vec<f64>>();
    let logs: Vec<Vec<f64>> = logs.iter().map(|log| finite(log)).collect();
    let (least, most) = ends(logs.iter().flatten().copied());
    let margin = NOISE * (most - least);
    let (mut up, mut down) = (0.0, 0.0);
    for log in &logs {
        let Some(mut follower) = log.first().copied() else { continue };
        for t in log {
            let next = follower.clamp(t - margin, t + margin);
            up += (next - follower).max(0.0);
            down += (follower - next).max(0.0);
            follower = next;
        }
    }
    least < most && up.min(down) >= TRAVEL * (most - least)
}

/// The temperatures passed upwards and downwards by logs, each in the order of time with whether something was measured there.
#[must_use]
pub fn both_ways(logs: &[Vec<(f64, bool)>]) -> (Vec<Interval>, Vec<Interval>) {
    let (mut up, mut down) = (Vec::new(), Vec::new());
    for log in logs {
        let warming = warming(&log.iter().map(|(temperature, _)| *temperature).collect::<Vec<_>>());
        let mut start = 0;
        for leg in warming.chunk_by(|a, b| a == b) {
            // Where it turns belongs to both ways.
            let end = start + leg.len();
            let passed = log[start..(end + 1).min(log.len())].iter().filter(|(t, measured)| *measured && t.is_finite());
            let way = if leg[0] { &mut up } else { &mut down };
            way.push(ends(passed.map(|(t, _)| *t)));
            start = end;
        }
    }
    (joined(up), joined(down))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_noisy_triangle_has_one_turn() {
        let temperature = |i: i32| {
            let noise = f64::from(i * 7919 % 100) / 100.0;
            60.0 - f64::from((i - 500).abs()) / 5.0 + noise
        };
        let temperatures: Vec<f64> = (0..1000).map(temperature).collect();
        let warming = warming(&temperatures);
        let turns: Vec<usize> = (1..1000).filter(|i| warming[*i] != warming[i - 1]).collect();
        assert_eq!(turns.len(), 1);
        assert!(warming[0] && turns[0].abs_diff(500) < 10, "{turns:?}");
    }

    #[test]
    fn logs_that_all_warm_go_one_way_though_each_begins_cold() {
        let warms: Vec<f64> = (0..100).map(f64::from).collect();
        let cools: Vec<f64> = warms.iter().rev().copied().collect();
        assert!(!go_both_ways(&[&warms, &warms, &warms]));
        assert!(go_both_ways(&[&warms, &cools]));
        assert!(go_both_ways(&[&[&warms[..], &cools[..]].concat()]));
        assert!(!go_both_ways(&[]) && !go_both_ways(&[&[]]));
    }

    #[test]
    fn noise_before_the_first_leg_is_no_turn() {
        let noise = |i: i32| f64::from(i * 7919 % 100) / 100.0;
        let rising: Vec<f64> = (0..200).map(|i| f64::from(i) * 0.3 + noise(i)).collect();
        assert_eq!(warming(&rising), [true; 200]);
        let dip = [25.1, 25.0, 30.0, 40.0, 50.0, 60.0];
        assert_eq!(warming(&dip), [true; 6]);
        let falling: Vec<f64> = dip.iter().map(|t| -t).collect();
        assert_eq!(warming(&falling), [false; 6]);
    }

    #[test]
    fn a_log_without_points_or_change_is_no_trouble() {
        assert!(warming(&[]).is_empty());
        assert_eq!(warming(&[25.0; 3]), [true; 3]);
    }
}
