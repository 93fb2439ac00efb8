//! Whether several logs share temperatures enough for the zero of each to be told from the drift.

use zerorate_fit::auto::BEYOND;
use zerorate_fit::intervals::{Interval, ends};

use crate::quality::{Reason, ReasonKind};
use crate::units::from_to;

/// A reason, where some of the logs share less with the others than a curve is believed past an end; their temperatures a log each,
/// and whether a rate was measured there. A log that lies within another's temperatures shares all that it has.
pub(super) fn reason(logs: &[Vec<(f64, bool)>], unit: &str) -> Option<Reason> {
    let of_log =
        |log: &Vec<(f64, bool)>| ends(log.iter().filter(|(t, rated)| *rated && t.is_finite()).map(|(t, _)| *t));
    let mut ranges: Vec<Interval> = logs.iter().map(of_log).filter(|(min, max)| min <= max).collect();
    ranges.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (coldest, hottest) = ends(ranges.iter().flat_map(|(min, max)| [*min, *max]));
    let enough = BEYOND * (hottest - coldest);
    let mut sets: Vec<Interval> = Vec::new();
    for (min, max) in ranges {
        match sets.last_mut() {
            Some(last) if last.1.min(max) - min >= enough.min(max - min).min(last.1 - last.0) => {
                last.1 = last.1.max(max)
            }
            _ => sets.push((min, max)),
        }
    }
    let [first, second, ..] = &sets[..] else { return None };
    let range = |(min, max): &Interval| format!("{} {unit}", from_to(*min, *max));
    let text = format!(
        "the logs over {} and those over {} have hardly a temperature in common: each log has a zero of its own, and how much of \
         what lies between them is drift is a guess; add a log that goes over both",
        range(first),
        range(second)
    );
    Some(Reason::new(ReasonKind::LogsApart, text))
}
