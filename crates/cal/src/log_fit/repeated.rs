//! Numbers that stand in a log twice: rows again, or one column as two.

use super::overlap::LogRows;
use crate::condition::{Group, MIN_GROUPS};
use crate::log::Stream;
use crate::quality::{Reason, ReasonKind};

/// What is found of one log and its sensors' groups, a sentence each.
pub(super) fn reasons<'a>(
    log: &str,
    rows: &LogRows,
    sensors: impl Iterator<Item = (&'a Stream, &'a [Group])>,
) -> Vec<Reason> {
    let twice = rows.part_twice().map(|part| {
        format!(
            "{log}: about {:.0} % of the rows stand in it twice: what is held out is fitted all the same, so the held-out \
             figures promise too much; give each row once",
            (100.0 * part).max(1.0)
        )
    });
    let columns = sensors.flat_map(|(stream, groups)| alike(stream, groups));
    let columns = columns.map(|(a, b)| format!("{a} and {b} are the same numbers: one of the two was not measured"));
    twice.into_iter().chain(columns).map(|text| Reason::new(ReasonKind::Repeated, text)).collect()
}

/// The pairs of a sensor's axes whose rates are the same in all groups, and are not all one number.
fn alike<'a>(stream: &'a Stream, groups: &[Group]) -> Vec<(&'a str, &'a str)> {
    let rates = |axis: usize| groups.iter().map(move |group| group.axes[axis].rate).filter(|rate| rate.is_finite());
    let changes = |axis: usize| rates(axis).zip(rates(axis).skip(1)).any(|(rate, next)| rate.total_cmp(&next).is_ne());
    let is_same = |a: usize, b: usize| rates(a).eq(rates(b)) && rates(a).count() as u64 >= MIN_GROUPS && changes(a);
    let names = &stream.names;
    let pairs = (0..names.len()).flat_map(|a| (a + 1..names.len()).map(move |b| (a, b)));
    pairs.filter(|&(a, b)| is_same(a, b)).map(|(a, b)| (names[a].as_str(), names[b].as_str())).collect()
}
