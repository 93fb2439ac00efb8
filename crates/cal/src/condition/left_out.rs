//! Groups that are left out: their rows become 0 and are counted, and their intervals are told.

use super::group::all_of;
use super::{DropReason, Excluded, Group, Tally};

/// Leaves out the groups that are marked, and counts their rows.
pub(super) fn leave_out_marked(
    groups: &mut [Group],
    tallies: &mut [Tally],
    marks: &[Option<DropReason>],
) -> Vec<Excluded> {
    for (group, reason) in groups.iter().zip(marks).filter_map(|(group, mark)| Some((group, (*mark)?))) {
        for (tally, part) in tallies.iter_mut().zip(&group.axes) {
            tally.add(reason, u64::from(part.rows));
        }
    }
    leave_out(groups, marks);
    excluded(groups, marks)
}

/// Leaves out the groups that are marked.
pub(super) fn leave_out(groups: &mut [Group], marks: &[Option<DropReason>]) {
    let marked = groups.iter_mut().zip(marks).filter(|(_, mark)| mark.is_some());
    for part in marked.flat_map(|(group, _)| &mut group.axes) {
        (part.rows, part.weight) = (0, 0.0);
    }
}

/// The intervals of the groups that are marked.
pub(super) fn excluded(groups: &[Group], marks: &[Option<DropReason>]) -> Vec<Excluded> {
    let mut found: Vec<Excluded> = Vec::new();
    let mut log = None;
    for (group, mark) in groups.iter().zip(marks) {
        let Some(reason) = *mark else { continue };
        // No interval goes on in another log.
        let same_log = log.replace(group.log) == Some(group.log);
        let goes_on = |interval: &&mut Excluded| interval.rows.1 == group.first_row && interval.reason == reason;
        match found.last_mut().filter(|interval| same_log && goes_on(interval)) {
            Some(interval) => {
                interval.rows.1 = group.end_row;
                interval.time_s.1 = group.times_s.1;
                interval.temperature = all_of(interval.temperature, group.temperatures);
            }
            None => found.push(Excluded {
                reason,
                rows: (group.first_row, group.end_row),
                time_s: group.times_s,
                temperature: group.temperatures,
            }),
        }
    }
    found
}
