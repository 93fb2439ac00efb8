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

/// Which scans of a group have come one by one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Came {
    /// Nobody reads them: the line scan ready is not connected, or the port has none.
    None,
    /// Some were missed.
    Some,
    /// Every one.
    All,
}

/// The corrections of the group that is being filled and of the one before: the last scan of a group may be read when the
/// group has just been closed.
pub(super) struct ScanByScan {
    before: Run,
    present: Run,
    last: Option<u32>,
    /// Scans of the first group, and of every further one.
    lengths: [u16; 2],
    /// It is not the first group.
    is_later: bool,
    /// The number of the first scan of the group that is being filled, and its scans as far as each has come: where all have,
    /// its samples need not be read from the port, which takes longer than two scans. Of a group that is closed late the next
    /// one's first scans stand behind them.
    begins: u32,
    came: Vec<Scan, MAX_SET_LENGTH>,
}

impl ScanByScan {
    /// No acquisition yet. All of it is zeros, so that it takes no flash.
    pub(super) const fn new() -> Self {
        let run = Run { axes: [SampleCorrection::NONE; 2], next: 0 };
        Self { before: run, present: run, last: None, lengths: [0; 2], is_later: false, begins: 0, came: Vec::new() }
    }

    /// An acquisition begins at scan 0, with a first set of so many scans and further ones of so many.
    pub(super) fn begin(&mut self, axes: [SampleCorrection; 2], first: u16, further: u16) {
        let run = Run { axes, next: 0 };
        (self.before, self.present, self.last) = (run, run, None);
        (self.lengths, self.is_later, self.begins) = ([first, further], false, 0);
        self.came.clear();
    }

    /// The group after a set begins. Where scans of it have been read already, its wipers were written late, and what they do
    /// begins with the next.
    pub(super) fn group_begins(&mut self, set: u32, axes: [SampleCorrection; 2]) {
        let begins = self.end_of(set);
        self.forget_up_to(begins);
        let read = self.last.map_or(begins, |last| last.wrapping_add(1));
        let next = if is_before(begins, read) { read } else { begins };
        self.before = core::mem::replace(&mut self.present, Run { axes, next });
        self.is_later = true;
    }

    /// The number of the scan after a set.
    fn end_of(&self, set: u32) -> u32 {
        let [first, further] = self.lengths.map(u32::from);
        first.wrapping_add(set.wrapping_mul(further))
    }

    /// Scans of the group that is being filled.
    fn length(&self) -> usize {
        let [first, further] = self.lengths;
        usize::from(if self.is_later { further } else { first })
    }

    /// What has come stands from a later scan on.
    fn forget_up_to(&mut self, begins: u32) {
        let passed = usize::try_from(begins.wrapping_sub(self.begins)).unwrap_or(usize::MAX);
        if passed < self.came.len() {
            _ = self.came.drain(..passed);
        } else {
            self.came.clear();
        }
        self.begins = begins;
    }

    /// Which scans of the group that is about to close have come.
    pub(super) fn came(&self) -> Came {
        if self.came.len() >= self.length() {
            Came::All
        } else if self.last.is_some_and(|last| !is_before(last, self.begins)) {
            Came::Some
        } else {
            Came::None
        }
    }

    /// The scan that the group about to close lacks, if it is the last one alone.
    pub(super) fn lacked(&self) -> Option<u32> {
        let last = self.length().checked_sub(1)?;
        let is_lacking = last > 0 && self.came.len() == last;
        is_lacking.then(|| self.begins.wrapping_add(u32::try_from(last).unwrap_or(0)))
    }

    /// The scan that was lacking: it is still to be corrected.
    pub(super) fn complete(&mut self, scan: Scan) {
        let _ = self.came.push(scan);
    }

    /// Gives the scans of a set, all of which have come; `false` if they are another set's.
    pub(super) fn give(&mut self, set: u32, into: &mut Vec<Scan, MAX_SET_LENGTH>) -> bool {
        let (length, end) = (self.length(), self.end_of(set));
        let are_its = self.begins.wrapping_add(u32::try_from(length).unwrap_or(0)) == end;
        if are_its {
            core::mem::swap(&mut self.came, into);
            self.came.clear();
            // Where there is no room for the next group's first scans, that one is not whole.
            let _ = self.came.extend_from_slice(into.get(length..).unwrap_or_default());
            into.truncate(length);
            self.begins = end;
        }
        are_its
    }

    /// Other corrections, from the next scan on.
    pub(super) const fn replace(&mut self, axes: [SampleCorrection; 2]) {
        self.present.axes = axes;
    }

    /// A scan, each axis with whether its wiper was settling; none if it came before.
    pub(super) fn correct(&mut self, scan: NumberedScan) -> Option<[(Q16, bool); 2]> {
        if self.last.is_some_and(|last| !is_before(last, scan.number)) {
            return None;
        }
        self.last = Some(scan.number);
        if u32::try_from(self.came.len()).is_ok_and(|came| self.begins.wrapping_add(came) == scan.number) {
            let _ = self.came.push(scan.scan);
        }
        let run = if is_before(scan.number, self.present.next) { &mut self.before } else { &mut self.present };
        Some(run.correct(scan))
    }
}

/// Whether a scan comes before another one. Their numbers go round after 149 days of the paper's: the nearer way counts.
const fn is_before(a: u32, b: u32) -> bool {
    a.wrapping_sub(b).cast_signed() < 0
}
