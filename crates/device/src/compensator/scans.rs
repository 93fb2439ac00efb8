//! Each scan corrected as it comes, by the law as it stands, beside the group that it adds up to.

use heapless::Vec;
use zerorate_core::compensate::{Q16, SampleCorrection};
use zerorate_core::units::Axis;

use crate::acquisition::{MAX_SET_LENGTH, NumberedScan, Scan, axis_samples};

/// Both axes from a scan on.
#[derive(Debug, Clone, Copy)]
struct Run {
    axes: [SampleCorrection; 2],
    /// The number of the scan that is corrected next.
    next: u32,
}

impl Run {
    /// A scan of this run, each axis with whether its wiper was settling; the wiper settles over those that were missed.
    fn correct(&mut self, NumberedScan { number, scan }: NumberedScan) -> [(Q16, bool); 2] {
        let missed = number.wrapping_sub(self.next);
        self.next = number.wrapping_add(1);
        Axis::BOTH.map(|axis| {
            let correction = &mut self.axes[axis.index()];
            correction.skip(missed);
            let is_settling = correction.is_settling();
            (correction.correct(axis_samples(&scan, axis).1), is_settling)
        })
    }
}

/// The corrections of the group that is being filled and of the one before: the last scan of a group may be read when the
/// group has just been closed.
pub(super) struct ScanByScan {
    before: Run,
    present: Run,
    last: Option<u32>,
    /// Scans of the first group, and of every further one.
    lengths: [u16; 2],
    /// The number of the first scan of the group that is being filled, and its scans as far as each has come: where all have,
    /// its samples need not be read from the port, which takes longer than two scans.
    begins: u32,
    came: Vec<Scan, MAX_SET_LENGTH>,
}

impl ScanByScan {
    /// An acquisition that begins at scan 0, with a first set of so many scans and further ones of so many.
    pub(super) const fn beginning(axes: [SampleCorrection; 2], first: u16, further: u16) -> Self {
        let run = Run { axes, next: 0 };
        Self { before: run, present: run, last: None, lengths: [first, further], begins: 0, came: Vec::new() }
    }

    /// The group after a set begins. Where scans of it have been read already, its wipers were written late, and what they do
    /// begins with the next.
    pub(super) fn group_begins(&mut self, set: u32, axes: [SampleCorrection; 2]) {
        self.begins = self.end_of(set);
        self.came.clear();
        let next = self.begins.max(self.last.map_or(0, |last| last.wrapping_add(1)));
        self.before = core::mem::replace(&mut self.present, Run { axes, next });
    }

    /// The number of the scan after a set.
    fn end_of(&self, set: u32) -> u32 {
        let [first, further] = self.lengths.map(u32::from);
        first.wrapping_add(set.wrapping_mul(further))
    }

    /// Whether every scan of the group that is about to close has come.
    pub(super) fn has_all(&self) -> bool {
        let [first, further] = self.lengths;
        self.came.len() == usize::from(if self.begins == 0 { first } else { further })
    }

    /// Gives the scans that have come; `false` if they are another set's.
    pub(super) fn give(&mut self, set: u32, into: &mut Vec<Scan, MAX_SET_LENGTH>) -> bool {
        let are_its =
            self.has_all() && self.begins.wrapping_add(u32::try_from(self.came.len()).unwrap_or(0)) == self.end_of(set);
        if are_its {
            core::mem::swap(&mut self.came, into);
        }
        are_its
    }

    /// Other corrections, from the next scan on.
    pub(super) const fn replace(&mut self, axes: [SampleCorrection; 2]) {
        self.present.axes = axes;
    }

    /// A scan, each axis with whether its wiper was settling; none if it came before.
    pub(super) fn correct(&mut self, scan: NumberedScan) -> Option<[(Q16, bool); 2]> {
        if self.last.is_some_and(|last| scan.number <= last) {
            return None;
        }
        self.last = Some(scan.number);
        if u32::try_from(self.came.len()).is_ok_and(|came| self.begins.wrapping_add(came) == scan.number) {
            // Where there is no room for more, the group has more than its scans and is not whole.
            let _ = self.came.push(scan.scan);
        }
        let run = if scan.number < self.present.next { &mut self.before } else { &mut self.present };
        Some(run.correct(scan))
    }
}
