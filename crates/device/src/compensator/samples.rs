//! The samples of a closed group on their way out, a block at a time.

use zerorate_core::compensate::AxisCompensation;
use zerorate_core::units::Axis;
use zerorate_core::wire::{GroupReport, SAMPLES_PER_BLOCK, Sample, SampleBlock, SampleWindow};

use crate::acquisition::{Scan, axis_samples};

#[allow(clippy::cast_possible_truncation)] // 25
const BLOCK: u16 = SAMPLES_PER_BLOCK as u16;

/// A closed group whose samples are being reported. Its own report follows the last of them.
pub(super) struct Stream {
    pub(super) report: GroupReport,
    /// The axes as they were before the group's first sample.
    axes: [AxisCompensation; 2],
    axis: Axis,
    /// The next sample of that axis.
    index: u16,
}

impl Stream {
    pub(super) const fn new(axes: [AxisCompensation; 2], report: GroupReport) -> Self {
        Self { report, axes, axis: Axis::X, index: 0 }
    }

    /// The next samples that are asked for, each corrected by what was known when it was taken; `None` when there are no
    /// more.
    pub(super) fn next_block(&mut self, window: &SampleWindow, scans: &[Scan]) -> Option<SampleBlock> {
        loop {
            let (index, end) = self.next_run(window, scans.len())?;
            let state = &mut self.axes[self.axis.index()];
            state.skip_samples(u32::from(index - self.index));
            self.index = index;
            let end = end.min(index.saturating_add(BLOCK));
            let Some(run) = scans.get(usize::from(index)..usize::from(end)).filter(|run| !run.is_empty()) else {
                if self.axis == Axis::Y {
                    return None;
                }
                (self.axis, self.index) = (Axis::Y, 0);
                continue;
            };
            let samples = run.iter().map(|scan| {
                let (temperature, zro) = axis_samples(scan, self.axis);
                Sample { temperature, zro, corrected_q16: state.sample(zro).0 }
            });
            let samples = samples.collect();
            self.index = end;
            return Some(SampleBlock { group: self.report.group, axis: self.axis, index, samples });
        }
    }

    /// The next samples of the present axis that are asked for: from one number to before another.
    fn next_run(&self, window: &SampleWindow, scans: usize) -> Option<(u16, u16)> {
        let n = u16::try_from(scans).ok()?;
        let (first, last_from) = window.of(self.axis, n);
        Some(if self.index < first { (self.index, first) } else { (self.index.max(last_from), n) })
    }

    /// Blocks that are still to come of a whole group.
    pub(super) fn left(&self, window: &SampleWindow) -> u32 {
        let blocks = |samples: u16| u32::from(samples.div_ceil(BLOCK));
        let of = |axis: Axis, from: u16| {
            let n = u16::try_from(self.report.axes[axis.index()].sums.n).unwrap_or(u16::MAX);
            let (first, last_from) = window.of(axis, n);
            blocks(first.saturating_sub(from)) + blocks(n.saturating_sub(last_from.max(from)))
        };
        match self.axis {
            Axis::X => of(Axis::X, self.index) + of(Axis::Y, 0),
            Axis::Y => of(Axis::Y, self.index),
        }
    }
}
