//! Each scan corrected as it comes, by the law as it stands, beside the group that it adds up to.

use zerorate_core::compensate::{Q16, SampleCorrection};
use zerorate_core::units::Axis;

use crate::acquisition::{NumberedScan, axis_samples};

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
#[derive(Debug, Clone, Copy)]
pub(super) struct ScanByScan {
    before: Run,
    present: Run,
    last: Option<u32>,
    /// Scans of the first group, and of every further one.
    lengths: [u16; 2],
}

impl ScanByScan {
    /// An acquisition that begins at scan 0, with a first set of so many scans and further ones of so many.
    pub(super) const fn beginning(axes: [SampleCorrection; 2], first: u16, further: u16) -> Self {
        let run = Run { axes, next: 0 };
        Self { before: run, present: run, last: None, lengths: [first, further] }
    }

    /// The group after a set begins. Where scans of it have been read already, its wipers were written late, and what they do
    /// begins with the next.
    pub(super) fn group_begins(&mut self, set: u32, axes: [SampleCorrection; 2]) {
        let [first, further] = self.lengths.map(u32::from);
        let begins = first.wrapping_add(set.wrapping_mul(further));
        let next = begins.max(self.last.map_or(0, |last| last.wrapping_add(1)));
        self.before = core::mem::replace(&mut self.present, Run { axes, next });
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
        let run = if scan.number < self.present.next { &mut self.before } else { &mut self.present };
        Some(run.correct(scan))
    }
}
