//! The work of the data-ready interrupt: take a set, close the group, run the law, write the wiper (paper, fig. 5).
//!
//! Commands come in and reports go out by queues, so that nothing here waits for the host or for flash.

use heapless::Vec;
use heapless::spsc::{Consumer, Producer};
use zerorate_core::compensate::{AxisCompensation, AxisLaw, Mode};
use zerorate_core::drift::Coverage;
use zerorate_core::units::{Axis, GroupNumber, Taps};
use zerorate_core::wire::{AxisReport, FaultCounts, GroupReport, Refusal, SampleWindow};

use crate::acquisition::{Acquisition, Set, Timing};
use crate::compensator::samples::Stream;
use crate::trim_part::TrimPart;

mod samples;

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
    /// Which samples are reported.
    SetSamples(SampleWindow),
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
    Samples(zerorate_core::wire::SampleBlock),
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
    window: SampleWindow,
    /// The last group, while its samples are on their way out.
    stream: Option<Stream>,
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
            window: SampleWindow::NONE,
            stream: None,
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
    ///
    /// The samples of a group that are asked for are too many for the queue: after each time that the reports have been
    /// taken out, [`stream`](Self::stream) goes on with them.
    pub fn service(&mut self, commands: &mut Consumer<'_, Scheduled>, reports: &mut Producer<'_, Report>) {
        if self.running {
            match self.read_set(reports) {
                Ok(true) => {
                    self.close_group(reports);
                    self.run_commands(reports);
                }
                Ok(false) => {}
                Err(_) => self.status.faults.acquisition_errors += 1,
            }
        }
        self.stream(reports);
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

    fn read_set(&mut self, reports: &mut Producer<'_, Report>) -> Result<bool, A::Error> {
        let read = self.acquisition.read_set(&mut self.set, self.window.is_open());
        // The samples of the group before are gone with its set; the group itself is not.
        if let (Some(stream), Ok(true) | Err(_)) = (&self.stream, &read) {
            self.status.faults.dropped_uploads += stream.left(&self.window);
            let report = stream.report.clone();
            self.stream = None;
            self.report(Report::Group(report), reports);
        }
        read
    }

    /// Goes on reporting the samples of the last group as far as the queue has room; `true` while there are more.
    pub fn stream(&mut self, reports: &mut Producer<'_, Report>) -> bool {
        let Some(stream) = &mut self.stream else { return false };
        // What is answered meanwhile finds room as well.
        while reports.len() + samples::KEPT_FREE < reports.capacity() {
            let Some(block) = stream.next_block(&self.window, &self.set.scans) else {
                let report = stream.report.clone();
                self.stream = None;
                self.report(Report::Group(report), reports);
                return false;
            };
            if reports.enqueue(Report::Samples(block)).is_err() {
                self.status.faults.dropped_uploads += 1;
            }
        }
        true
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
            Action::SetSamples(window) => {
                self.window = window;
                self.stream = None;
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
        self.stream = None;
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
        for axis in Axis::BOTH {
            let n = self.set.sums[axis.index()].n;
            self.axes[axis.index()].skip_lost(missed.saturating_mul(n));
            self.axes[axis.index()].lose_groups(missed);
        }
        let before = self.axes.clone();
        let axes = Axis::BOTH.map(|axis| self.close_axis(axis));
        self.status.group = GroupNumber(group.0.wrapping_add(1));
        let report = GroupReport { group, lost: self.set.lost, axes };
        if self.set.scans.is_empty() {
            self.report(Report::Group(report), reports);
        } else {
            self.stream = Some(Stream::new(before, report));
        }
    }

    fn close_axis(&mut self, axis: Axis) -> AxisReport {
        let sums = self.set.sums[axis.index()];
        let law = self.laws.as_ref().map(|laws| &laws[axis.index()]);
        let state = &mut self.axes[axis.index()];
        state.skip_samples(sums.n);
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
}

#[cfg(test)]
mod tests;
