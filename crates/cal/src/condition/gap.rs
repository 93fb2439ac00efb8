//! Times for which nothing was logged.

use super::group::all_of;
use super::{DropReason, Excluded, Group};
use zerorate_fit::robust::median;

/// A time without rows is told if it is longer than this, and than [`GAP_GROUPS`].
const GAP_S: f64 = 30.0;

/// In typical groups.
const GAP_GROUPS: f64 = 3.0;

/// Groups of rows between which nothing was logged for long: their means are of two times.
pub(super) fn mark_gaps_within(groups: &[Group], marks: &mut [Option<DropReason>]) {
    let limit = gap_limit(groups);
    for (group, mark) in groups.iter().zip(marks) {
        // That its rows scatter as if it were moved comes of it.
        if group.times_s.1 - group.times_s.0 > limit {
            *mark = Some(DropReason::Gap);
        }
    }
}

/// Times without rows between groups.
pub(super) fn gaps(groups: &[Group]) -> Vec<Excluded> {
    let limit = gap_limit(groups);
    groups
        .windows(2)
        .filter(|pair| pair[0].log == pair[1].log && pair[1].times_s.0 - pair[0].times_s.1 > limit)
        .map(|pair| Excluded {
            reason: DropReason::Gap,
            rows: (pair[0].end_row, pair[1].first_row),
            time_s: (pair[0].times_s.1, pair[1].times_s.0),
            temperature: all_of(pair[0].temperatures, pair[1].temperatures),
        })
        .collect()
}

/// Whether one axis goes on from one group that has its rate to the next that has it: in one log, and with no long time
/// without numbers between them.
pub(super) fn goes_on(groups: &[Group]) -> impl Fn(usize, usize) -> bool + '_ {
    let limit = gap_limit(groups);
    move |before, after| {
        let (before_s, after_s) = (groups[before].times_s.1, groups[after].times_s.0);
        let is_far = (after - before) as f64 > 1.0 + GAP_GROUPS || after_s - before_s > limit;
        groups[before].log == groups[after].log && !is_far
    }
}

/// A time longer than this is a gap, seconds.
fn gap_limit(groups: &[Group]) -> f64 {
    // From start to start, for a group of one row has no length.
    let mut lengths: Vec<f64> = groups.windows(2).map(|pair| pair[1].times_s.0 - pair[0].times_s.0).collect();
    let typical = median(&mut lengths);
    if typical.is_finite() { (GAP_GROUPS * typical).max(GAP_S) } else { f64::INFINITY }
}
