//! The work of the data-ready interrupt: take a set, close the group, run the law, write the wiper (paper, fig. 5).
//!
//! Commands come in and reports go out by queues, so that nothing here waits for the host or for flash.

use heapless::Vec;
use heapless::spsc::{Consumer, Producer};
use zerorate_core::compensate::{AxisCompensation, AxisLaw, Mode};
use zerorate_core::drift::Coverage;
use zerorate_core::group::GroupSums;
use zerorate_core::units::{Axis, GroupNumber, Taps};
use zerorate_core::wire::{AxisReport, FaultCounts, GroupReport, Refusal, SAMPLES_PER_BLOCK, Sample, SampleBlock};

use crate::acquisition::{Acquisition, Set, Timing, axis_samples};
use crate::trim_part::TrimPart;

/// Commands that may wait for their group.
const MAX_WAITING: usize = 8;
/// The highest reading of a 14-bit converter, counts.
const FULL_SCALE: u16 = (1 << 14) - 1;

/// A command on its way to the compensator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scheduled {
    /// The host's number for it.
    pub sequence: u16,
    /// The first group for which it is to hold; `None`: the next one.
    pub at: Option<GroupNumber>,
    /// What to do.
    pub action: Action,
}

/// What a command asks of the compensator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// Changes an axis's mode.
    SetMode(Axis, Mode),
    /// Writes a wiper.
    SetTap(Axis, Taps),
    /// Makes the present taps those of power-up.
    StorePowerUpTap,
    /// Starts the acquisition anew, or stops it.
    SetAcquisition(bool),
    /// Whether every sample is reported.
    SetSamples(bool),
}

impl Action {
    /// Whether it changes how a group is taken, and so waits for the next.
    const fn waits_for_a_group(self) -> bool {
        matches!(self, Self::SetMode(..) | Self::SetTap(..) | Self::StorePowerUpTap)
    }
}

/// What the compensator has to say.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant)] // a queue on a device holds them by value
pub enum Report {
    /// A command was done, or not, from a group on.
    Done {
        /// The host's number for it.
        sequence: u16,
        /// The first group for which it holds.
        group: GroupNumber,
        /// What came of it.
        result: Result<(), Refusal>,
    },
    /// A closed group.
    Group(GroupReport),
    /// Some of a group's samples.
    Samples(SampleBlock),
}

/// What the task below the interrupt may look at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Status {
    /// The group that is being filled, or the first that will be.
    pub group: GroupNumber,
    /// Whether a calibration is in use.
    pub calibrated: bool,
    /// The compensator's part of the fault counters.
    pub faults: FaultCounts,
}

/// The compensator: an acquisition, a trim part, the laws of both axes and their state.
pub struct Compensator<A, P> {
    acquisition: A,
    part: P,
    timing: Timing,
    laws: Option<[AxisLaw; 2]>,
    axes: [AxisCompensation; 2],
    set: Set,
    running: bool,
    with_samples: bool,
    waiting: Vec<Scheduled, MAX_WAITING>,
    status: Status,
}

impl<A: Acquisition, P: TrimPart> Compensator<A, P> {
    /// A compensator at start-up: acquisition stopped, both wipers commanded to the middle tap, no calibration.
    #[must_use]
    pub fn new(acquisition: A, mut part: P, timing: Timing) -> Self {
        let mut status = Status::default();
        for axis in Axis::BOTH {
            if part.write(axis, Taps::MIDDLE).is_err() {
                status.faults.trim_errors += 1;
            }
        }
        Self {
            acquisition,
            part,
            timing,
            laws: None,
            axes: Axis::BOTH.map(|_| AxisCompensation::new(None, Taps::MIDDLE)),
            set: Set::default(),
            running: false,
            with_samples: false,
            waiting: Vec::new(),
            status,
        }
    }

    /// How sets are taken.
    #[must_use]
    pub const fn timing(&self) -> Timing {
        self.timing
    }

    /// What the task below may look at.
    #[must_use]
    pub const fn status(&self) -> Status {
        self.status
    }

    /// The acquisition, for whoever drives its ticks.
    pub const fn acquisition(&mut self) -> &mut A {
        &mut self.acquisition
    }

    /// Takes laws into use, keeping modes and taps.
    pub fn install(&mut self, laws: [AxisLaw; 2]) {
        for (axis, law) in self.axes.iter_mut().zip(&laws) {
            let mode = axis.mode();
            *axis = AxisCompensation::new(Some(law), axis.tap());
            axis.set_mode(mode);
        }
        self.laws = Some(laws);
        self.status.calibrated = true;
    }

    /// Puts both axes in the modes of start-up.
    pub fn set_modes(&mut self, modes: [Mode; 2]) {
        for (axis, mode) in self.axes.iter_mut().zip(modes) {
            axis.set_mode(mode);
        }
    }

    /// The interrupt: called when a set is ready, and when a command was queued.
    pub fn service(&mut self, commands: &mut Consumer<'_, Scheduled>, reports: &mut Producer<'_, Report>) {
        if self.running {
            match self.acquisition.read_set(&mut self.set, self.with_samples) {
                Ok(true) => {
                    self.close_group(reports);
                    self.run_commands(reports);
                }
                Ok(false) => {}
                Err(_) => self.status.faults.acquisition_errors += 1,
            }
        }
        while let Some(command) = commands.dequeue() {
            if self.running && command.action.waits_for_a_group() {
                if self.waiting.push(command).is_err() {
                    self.answer(command.sequence, Err(Refusal::Busy), reports);
                }
            } else {
                let result = self.act(command.action);
                self.answer(command.sequence, result, reports);
            }
        }
    }

    /// Runs the waiting commands whose group is about to begin, in the order in which they came.
    fn run_commands(&mut self, reports: &mut Producer<'_, Report>) {
        let next = self.status.group;
        let mut index = 0;
        while let Some(&command) = self.waiting.get(index) {
            if command.at.is_none_or(|at| at <= next) {
                self.waiting.remove(index);
                let result = self.act(command.action);
                self.answer(command.sequence, result, reports);
            } else {
                index += 1;
            }
        }
    }

    fn answer(&mut self, sequence: u16, result: Result<(), Refusal>, reports: &mut Producer<'_, Report>) {
        self.report(Report::Done { sequence, group: self.status.group, result }, reports);
    }

    fn report(&mut self, report: Report, reports: &mut Producer<'_, Report>) {
        if reports.enqueue(report).is_err() {
            self.status.faults.dropped_uploads += 1;
        }
    }

    fn act(&mut self, action: Action) -> Result<(), Refusal> {
        match action {
            Action::SetMode(axis, mode) => self.set_mode(axis, mode),
            Action::SetTap(axis, tap) => self.write_wiper(axis, tap).map_err(|()| Refusal::TrimPartFailed),
            Action::StorePowerUpTap => self.part.store_power_up().map_err(|_| {
                self.status.faults.trim_errors += 1;
                Refusal::TrimPartFailed
            }),
            Action::SetAcquisition(run) => self.set_acquisition(run),
            Action::SetSamples(with_samples) => {
                self.with_samples = with_samples;
                Ok(())
            }
        }
    }

    fn set_mode(&mut self, axis: Axis, mode: Mode) -> Result<(), Refusal> {
        match self.laws.as_ref().map(|laws| &laws[axis.index()]) {
            None if mode != Mode::Off => return Err(Refusal::NoCalibration),
            Some(law) if mode.moves_wiper() && !law.moves_wiper() => return Err(Refusal::NoEdges),
            _ => {}
        }
        self.axes[axis.index()].set_mode(mode);
        Ok(())
    }

    fn set_acquisition(&mut self, run: bool) -> Result<(), Refusal> {
        let done = if run { self.acquisition.start(self.timing) } else { self.acquisition.stop() };
        done.map_err(|_| Refusal::AcquisitionFailed)?;
        self.running = run;
        if run {
            self.status.group = GroupNumber(0);
            self.set.lost = 0;
        }
        Ok(())
    }

    fn write_wiper(&mut self, axis: Axis, tap: Taps) -> Result<(), ()> {
        if self.part.write(axis, tap).is_err() {
            self.status.faults.trim_errors += 1;
            return Err(());
        }
        let law = self.laws.as_ref().map(|laws| &laws[axis.index()]);
        self.axes[axis.index()].wiper_written(law, tap);
        Ok(())
    }

    /// Closes the group whose set was just read.
    fn close_group(&mut self, reports: &mut Producer<'_, Report>) {
        let group = GroupNumber(self.set.number);
        let missed = group.0.saturating_sub(self.status.group.0);
        self.status.faults.lost_sets += missed;
        let axes = Axis::BOTH.map(|axis| self.close_axis(axis, group, missed, reports));
        self.status.group = GroupNumber(group.0.wrapping_add(1));
        self.report(Report::Group(GroupReport { group, lost: self.set.lost, axes }), reports);
    }

    fn close_axis(
        &mut self,
        axis: Axis,
        group: GroupNumber,
        missed: u32,
        reports: &mut Producer<'_, Report>,
    ) -> AxisReport {
        let sums = self.set.sums[axis.index()];
        self.pass_samples(axis, group, missed, &sums, reports);
        let law = self.laws.as_ref().map(|laws| &laws[axis.index()]);
        let state = &mut self.axes[axis.index()];
        let (tap, mode) = (state.tap(), state.mode());
        let outcome = state.close_group(law, &sums);
        // A write that fails leaves the shadow as it was; the law asks again with the next group.
        let moved_to = outcome.move_to.filter(|&wanted| self.write_wiper(axis, wanted).is_ok());
        let saturated = sums.is_saturated(FULL_SCALE);
        let faults = &mut self.status.faults;
        faults.saturated += u32::from(saturated);
        faults.out_of_range += u32::from(matches!(outcome.coverage, Coverage::Below | Coverage::Above));
        AxisReport {
            sums,
            tap,
            mode,
            corrected_q16: outcome.corrected.0,
            coverage: outcome.coverage,
            saturated,
            moved_to,
        }
    }

    /// Takes the group's samples past the axis's state, one by one where they are asked for.
    fn pass_samples(
        &mut self,
        axis: Axis,
        group: GroupNumber,
        missed: u32,
        sums: &GroupSums,
        reports: &mut Producer<'_, Report>,
    ) {
        let state = &mut self.axes[axis.index()];
        state.skip_lost(missed.saturating_mul(sums.n));
        if self.set.scans.is_empty() {
            state.skip_samples(sums.n);
            return;
        }
        let mut index = 0_u16;
        for scans in self.set.scans.chunks(SAMPLES_PER_BLOCK) {
            let samples = scans.iter().map(|scan| {
                let (temperature, zro) = axis_samples(scan, axis);
                Sample { temperature, zro, corrected_q16: state.sample(zro).0 }
            });
            let block = SampleBlock { group, axis, index, samples: samples.collect() };
            index += u16::try_from(scans.len()).unwrap_or(u16::MAX);
            if reports.enqueue(Report::Samples(block)).is_err() {
                self.status.faults.dropped_uploads += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests;
