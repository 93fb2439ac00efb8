//! The samples of a closed group on their way out, a block at a time.

use core::ops::Range;

use zerorate_core::compensate::SampleCorrection;
use zerorate_core::units::Axis;
use zerorate_core::wire::{GroupReport, SAMPLES_PER_BLOCK, Sample, SampleBlock, SampleWindow};

use crate::acquisition::{Scan, axis_samples};

#[allow(clippy::cast_possible_truncation)] // 25
const BLOCK: u16 = SAMPLES_PER_BLOCK as u16;

/// A closed group whose samples are being reported. Its own report follows the last of them.
pub(super) struct Stream {
    pub(super) report: GroupReport,
    /// What corrects the next of their samples, and how many have passed.
    axes: [(SampleCorrection, u16); 2],
    /// The samples that are still to come.
    runs: [(Axis, Range<u16>); 4],
}

impl Stream {
    /// The samples that are asked for of a group of so many scans. `axes` are as they were before the first of them.
    pub(super) fn new(report: GroupReport, axes: [SampleCorrection; 2], window: &SampleWindow, scans: usize) -> Self {
        let n = u16::try_from(scans).unwrap_or(u16::MAX);
        let [(x, x_last), (y, y_last)] = Axis::BOTH.map(|axis| window.of(axis, n));
        let runs = [(Axis::X, 0..x), (Axis::X, x_last..n), (Axis::Y, 0..y), (Axis::Y, y_last..n)];
        Self { report, axes: axes.map(|axis| (axis, 0)), runs }
    }

    /// The next samples, each corrected by what was known when it was taken; `None` when there are no more.
    pub(super) fn next_block(&mut self, scans: &[Scan]) -> Option<SampleBlock> {
        let (axis, run) = self.runs.iter_mut().find(|(_, run)| !run.is_empty())?;
        let index = run.start;
        run.start = run.end.min(index.saturating_add(BLOCK));
        let (correction, passed) = &mut self.axes[axis.index()];
        correction.skip(u32::from(index - *passed));
        *passed = run.start;
        let scans = scans.get(usize::from(index)..usize::from(run.start))?;
        let samples = scans.iter().map(|scan| {
            let (temperature, zro) = axis_samples(scan, *axis);
            Sample { temperature, zro, corrected_q16: correction.correct(zro).0 }
        });
        Some(SampleBlock { group: self.report.group, axis: *axis, index, samples: samples.collect() })
    }

    /// Blocks that are still to come.
    pub(super) fn left(&self) -> u32 {
        self.runs.iter().map(|(_, run)| u32::from((run.end - run.start).div_ceil(BLOCK))).sum()
    }
}
