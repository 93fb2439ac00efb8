//! Which way the temperature was going, point by point, without being fooled by noise.

use crate::report::LogPoint;

/// A turn counts once the temperature has come back by this part of its span.
const TURN: f64 = 0.03;

/// For each point whether it was recorded while the unit warmed.
pub(super) fn warming(points: &[LogPoint]) -> Vec<bool> {
    let temperatures = || points.iter().map(|point| point.temperature).filter(|t| t.is_finite());
    let (min, max) = temperatures().fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), t| (min.min(t), max.max(t)));
    let turn = TURN * (max - min);
    let mut warming = vec![true; points.len()];
    // The leg begins at the last extreme; its direction is known once the temperature has moved by a turn.
    let (mut start, mut up) = (0, None);
    let (mut lowest, mut highest) = (0, 0);
    for (place, point) in points.iter().enumerate().filter(|(_, point)| point.temperature.is_finite()) {
        if point.temperature < points[lowest].temperature || points[lowest].temperature.is_nan() {
            lowest = place;
        }
        if point.temperature > points[highest].temperature || points[highest].temperature.is_nan() {
            highest = place;
        }
        let risen = up != Some(true) && point.temperature > points[lowest].temperature + turn;
        let fallen = up != Some(false) && point.temperature < points[highest].temperature - turn;
        if risen || fallen {
            let extreme = if risen { lowest } else { highest };
            // What came before the extreme went the other way.
            warming[start..extreme].fill(!risen);
            (start, up) = (extreme, Some(risen));
            (lowest, highest) = (place, place);
        }
    }
    warming[start..].fill(up.unwrap_or(true));
    warming
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_noisy_triangle_has_one_turn() {
        let point = |i: i32| {
            let noise = f64::from(i * 7919 % 100) / 100.0;
            let temperature = 60.0 - f64::from((i - 500).abs()) / 5.0 + noise;
            LogPoint { elapsed_s: f64::from(i), temperature, rate: 0.0, corrected: 0.0 }
        };
        let points: Vec<LogPoint> = (0..1000).map(point).collect();
        let warming = warming(&points);
        let turns: Vec<usize> = (1..1000).filter(|i| warming[*i] != warming[i - 1]).collect();
        assert_eq!(turns.len(), 1);
        assert!(warming[0] && turns[0].abs_diff(500) < 10, "{turns:?}");
    }

    #[test]
    fn a_log_without_points_or_change_is_no_trouble() {
        assert!(warming(&[]).is_empty());
        let still = LogPoint { elapsed_s: 0.0, temperature: 25.0, rate: 0.0, corrected: 0.0 };
        assert_eq!(warming(&[still; 3]), [true; 3]);
    }
}
