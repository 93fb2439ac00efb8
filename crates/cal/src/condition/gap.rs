//! Times for which nothing was logged.

use std::collections::BTreeMap;

use super::group::all_of;
use super::{DropReason, Excluded, Group};
use zerorate_fit::robust::median;

/// A time without rows is told if it is longer than this, and than [`GAP_GROUPS`].
const GAP_S: f64 = 30.0;

/// In typical groups.
const GAP_GROUPS: f64 = 3.0;

/// A log with fewer lengths of groups than this does not tell what is typical of it: the half of three may be gaps.
const TELLING_LENGTHS: usize = 5;

/// Groups of rows between which nothing was logged for long: their means are of two times.
pub(super) fn mark_gaps_within(groups: &[Group], marks: &mut [Option<DropReason>]) {
    let limits = GapLimits::of(groups);
    for (group, mark) in groups.iter().zip(marks) {
        // That its rows scatter as if it were moved comes of it.
        if group.widest_s > limits.of_log(group.log) {
            *mark = Some(DropReason::Gap);
        }
    }
}

/// Times without rows between groups.
pub(super) fn gaps(groups: &[Group]) -> Vec<Excluded> {
    let limits = GapLimits::of(groups);
    groups
        .windows(2)
        .filter(|pair| pair[0].log == pair[1].log && pair[1].times_s.0 - pair[0].times_s.1 > limits.of_log(pair[0].log))
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
    let limits = GapLimits::of(groups);
    move |before, after| {
        let (before_s, after_s) = (groups[before].times_s.1, groups[after].times_s.0);
        let is_far =
            (after - before) as f64 > 1.0 + GAP_GROUPS || after_s - before_s > limits.of_log(groups[before].log);
        groups[before].log == groups[after].log && !is_far
    }
}

/// For each log the time that is a gap if it is longer, seconds: logs of one unit may have been recorded at other rates, and
/// so have groups of other lengths.
struct GapLimits {
    by_log: BTreeMap<u32, f64>,
    /// Of a log that is too short to tell.
    else_s: f64,
}

impl GapLimits {
    fn of(groups: &[Group]) -> Self {
        // From start to start, for a group of one row has no length.
        let lengths = |log: &[Group]| -> Vec<f64> {
            log.windows(2)
                .map(|pair| pair[1].times_s.0 - pair[0].times_s.0)
                .filter(|length| length.is_finite())
                .collect()
        };
        let limit = |mut lengths: Vec<f64>| (GAP_GROUPS * median(&mut lengths)).max(GAP_S);
        let logs = groups.chunk_by(|a, b| a.log == b.log).map(|log| (log[0].log, lengths(log)));
        let logs: Vec<(u32, Vec<f64>)> = logs.filter(|(_, lengths)| !lengths.is_empty()).collect();
        let all: Vec<f64> = logs.iter().flat_map(|(_, lengths)| lengths).copied().collect();
        let else_s = if all.is_empty() { f64::INFINITY } else { limit(all) };
        let telling = logs.into_iter().filter(|(_, lengths)| lengths.len() >= TELLING_LENGTHS);
        Self { by_log: telling.map(|(log, lengths)| (log, limit(lengths))).collect(), else_s }
    }

    fn of_log(&self, log: u32) -> f64 {
        self.by_log.get(&log).copied().unwrap_or(self.else_s)
    }
}
