//! Whether a log's temperature went both ways, without which nobody has seen hysteresis.

use zerorate_fit::direction::both_ways;
use zerorate_fit::intervals::{common, joined, length};

use crate::quality::{NO_HYSTERESIS, Reason, ReasonKind};

/// Less than this share of the span passed both ways, and most of the curve is of one direction.
const BOTH_WAYS: f64 = 0.5;

/// Less than this share is none: a turn's rounding.
const NONE: f64 = 0.005;

/// A reason, where a log's temperatures went one way over most of their span; those of a log each, in the order of time, and
/// whether a rate was measured there.
pub(crate) fn reason(logs: &[Vec<(f64, bool)>]) -> Option<Reason> {
    let (up, down) = both_ways(logs);
    let span = length(&joined([&up[..], &down[..]].concat()));
    let share = length(&common(&up, &down)) / span;
    // Without a span there is nothing to say of it; that is another reason's.
    if span <= 0.0 || share >= BOTH_WAYS {
        return None;
    }
    let way = if length(&up) >= length(&down) { "rises" } else { "falls" };
    let lesser = length(&up).min(length(&down)) / span;
    let how_much = if share < NONE && lesser < NONE {
        format!("the temperature only {way}")
    } else if share < NONE {
        "the temperature rises over one part of its span and falls over another".to_owned()
    } else {
        format!("the temperature {way}, and only {:.0} % of its span was passed both ways", 100.0 * share)
    };
    let text = format!(
        "{how_much}: {NO_HYSTERESIS}, and on the way back the drift may be another by more than the held-out residual tells"
    );
    Some(Reason::new(ReasonKind::OneDirection, text))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Through some temperatures one after the other, 50 steps each.
    fn through(stations: &[f64]) -> Vec<f64> {
        let between = |pair: &[f64]| -> Vec<f64> {
            (0..50).map(|i| pair[0] + (pair[1] - pair[0]) * f64::from(i) / 50.0).collect()
        };
        stations.windows(2).flat_map(between).chain(stations.last().copied()).collect()
    }

    fn told(logs: &[Vec<f64>]) -> Option<String> {
        let measured = |log: &Vec<f64>| log.iter().map(|t| (*t, true)).collect();
        reason(&logs.iter().map(measured).collect::<Vec<_>>()).map(|reason| reason.text)
    }

    #[test]
    fn a_way_back_without_rates_is_none() {
        let cycle = through(&[-20.0, 60.0, -20.0]);
        let half = cycle.len() / 2;
        let log = cycle.iter().enumerate().map(|(row, t)| (*t, row < half)).collect();
        assert!(reason(&[log]).is_some_and(|reason| reason.text.starts_with("the temperature only rises:")));
    }

    #[test]
    fn a_ramp_up_or_down_is_of_one_direction_and_a_cycle_is_not() {
        assert!(told(&[through(&[-20.0, 60.0])]).unwrap().starts_with("the temperature only rises:"));
        assert!(told(&[through(&[60.0, -20.0])]).unwrap().starts_with("the temperature only falls:"));
        for cycle in [&[-20.0, 60.0, -20.0][..], &[20.0, -20.0, 60.0, 20.0], &[60.0, -20.0, 61.0]] {
            assert_eq!(told(&[through(cycle)]), None, "{cycle:?}");
        }
    }

    #[test]
    fn the_share_that_was_passed_both_ways_decides() {
        // Of 80 degrees 20 were passed back, and 48.
        let told_of = told(&[through(&[-20.0, 60.0, 40.0])]).unwrap();
        assert!(told_of.contains("rises, and only 25 % of its span"), "{told_of}");
        assert_eq!(told(&[through(&[-20.0, 60.0, 12.0])]), None);
        // Two short returns add up to what one would be.
        assert_eq!(told(&[through(&[0.0, 30.0, 10.0, 80.0, 50.0])]), None);
    }

    #[test]
    fn noise_and_a_jump_from_one_log_to_the_next_are_no_way_back() {
        let noisy: Vec<f64> = (0..2000_i32).map(|i| f64::from(i) * 0.04 + f64::from(i * 7919 % 100) / 100.0).collect();
        assert!(told(&[noisy]).is_some());
        assert!(told(&[through(&[-20.0, 20.0]), through(&[0.0, 60.0])]).is_some());
        assert_eq!(told(&[through(&[-20.0, 60.0]), through(&[60.0, -20.0])]), None);
        let apart = told(&[through(&[5.0, 25.0]), through(&[55.0, 35.0])]).unwrap();
        assert!(
            apart.starts_with("the temperature rises over one part of its span and falls over another:"),
            "{apart}"
        );
    }

    #[test]
    fn a_log_that_stands_still_or_is_empty_says_nothing() {
        assert_eq!((told(&[vec![25.0; 9]]), told(&[Vec::new()]), told(&[])), (None, None, None));
    }
}
