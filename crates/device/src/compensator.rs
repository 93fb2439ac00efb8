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
use crate::compensator::temperature::TemperatureWatch;
use crate::trim_part::TrimPart;

mod samples;
mod temperature;

/// Commands that may wait for their group.
const MAX_WAITING: usize = 8;
/// Answers that may wait for room among the reports: more than there can be commands under way.
const MAX_ANSWERS: usize = 16;
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

/// A command's number, the first group for which it holds, and what came of it.
type Answered = (u16, GroupNumber, Result<(), Refusal>);

/// What the task below the interrupt may look at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status {
    /// The group that is being filled, or the first that will be.
    pub group: GroupNumber,
    /// Whether groups are being taken.
    pub running: bool,
    /// Sets that have arrived since start-up, for the watchdog.
    pub sets: u32,
    /// The last commanded taps.
    pub taps: [Taps; 2],
    /// The modes.
    pub modes: [Mode; 2],
    /// Whether a calibration is in use.
    pub calibrated: bool,
    /// The compensator's part of the fault counters.
    pub faults: FaultCounts,
}

impl Default for Status {
    fn default() -> Self {
        Self {
            group: GroupNumber(0),
            running: false,
            sets: 0,
            taps: [Taps::MIDDLE; 2],
            modes: [Mode::Off; 2],
            calibrated: false,
            faults: FaultCounts::default(),
        }
    }
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
    /// Answers that found no room yet: none is ever dropped, or the host would ask in vain.
    answers: Vec<Answered, MAX_ANSWERS>,
    temperatures: [TemperatureWatch; 2],
    /// Wipers that may stand elsewhere than commanded, because a write failed.
    unsure: [bool; 2],
    status: Status,
}

impl<A: Acquisition, P: TrimPart> Compensator<A, P> {
    /// A compensator at start-up: acquisition stopped, both wipers commanded to the middle tap, no calibration.
    #[must_use]
    pub fn new(acquisition: A, part: P, timing: Timing) -> Self {
        let mut compensator = Self::holding(acquisition, part, timing, [Taps::MIDDLE; 2]);
        compensator.rest();
        compensator
    }

    /// A compensator after a restart that nobody asked for: the wipers are left where they stand, which are the taps that
    /// the board has kept through it. With the first group each is written what it should have.
    #[must_use]
    pub fn holding(acquisition: A, part: P, timing: Timing, taps: [Taps; 2]) -> Self {
        Self {
            acquisition,
            part,
            timing,
            laws: None,
            axes: taps.map(|tap| AxisCompensation::new(None, tap)),
            set: Set::default(),
            running: false,
            window: SampleWindow::NONE,
            stream: None,
            waiting: Vec::new(),
            answers: Vec::new(),
            temperatures: Default::default(),
            unsure: [true; 2],
            status: Status::default(),
        }
    }

    /// Commands both wipers to the middle tap.
    pub fn rest(&mut self) {
        for axis in Axis::BOTH {
            // One that fails is counted, and written again with the next group.
            let _ = self.write_wiper(axis, Taps::MIDDLE);
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
        let [x, y] = &self.axes;
        Status { running: self.running, taps: [x.tap(), y.tap()], modes: [x.mode(), y.mode()], ..self.status }
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

    /// Takes groups again after a restart that nobody asked for. An acquisition that cannot be reached is counted.
    pub fn resume(&mut self) {
        if self.set_acquisition(true).is_err() {
            self.status.faults.acquisition_errors += 1;
        }
    }

    /// The interrupt: called when a set is ready, and when a command was queued.
    ///
    /// The samples of a group that are asked for are too many for the queue: after each time that the reports have been
    /// taken out, [`stream`](Self::stream) goes on with them.
    pub fn service(&mut self, commands: &mut Consumer<'_, Scheduled>, reports: &mut Producer<'_, Report>) {
        self.report_answers(reports);
        if self.running && self.read_set(reports) {
            self.status.sets = self.status.sets.wrapping_add(1);
            self.close_group(reports);
            self.run_commands(reports);
        }
        self.stream(reports);
        while let Some(command) = commands.dequeue() {
            if self.running && command.action.waits_for_a_group() {
                if self.waiting.push(command).is_err() {
                    self.answer(command.sequence, Err(Refusal::Busy), reports);
                }
            } else {
                let result = self.act(command.action);
                if matches!(command.action, Action::SetAcquisition(_)) && result.is_ok() {
                    self.refuse_waiting(reports);
                }
                self.answer(command.sequence, result, reports);
            }
        }
    }

    /// Reads the set that waits; `false` when there is none, or it cannot be read. A read that failed is tried once more:
    /// a set that was not read whole still waits.
    fn read_set(&mut self, reports: &mut Producer<'_, Report>) -> bool {
        let with_scans = self.window.is_open();
        let mut read = self.acquisition.read_set(&mut self.set, with_scans);
        if read.is_err() {
            self.status.faults.acquisition_errors += 1;
            self.set_goes(reports);
            read = self.acquisition.read_set(&mut self.set, with_scans);
            self.status.faults.acquisition_errors += u32::from(read.is_err());
        }
        let is_read = matches!(read, Ok(true));
        if is_read {
            self.set_goes(reports);
        }
        is_read
    }

    /// The samples of the group before are gone with its set; the group itself is not.
    fn set_goes(&mut self, reports: &mut Producer<'_, Report>) {
        if let Some(stream) = self.stream.take() {
            self.status.faults.dropped_uploads += stream.left(&self.window);
            self.report(Report::Group(stream.report), reports);
        }
    }

    /// Goes on reporting the samples of the last group as far as the queue has room; `true` while there are more.
    pub fn stream(&mut self, reports: &mut Producer<'_, Report>) -> bool {
        self.report_answers(reports);
        let Some(stream) = &mut self.stream else { return !self.answers.is_empty() };
        // What is answered meanwhile finds room as well.
        while reports.len() + samples::KEPT_FREE < reports.capacity() {
            let Some(block) = stream.next_block(&self.window, &self.set.scans) else {
                let report = stream.report.clone();
                self.stream = None;
                self.report(Report::Group(report), reports);
                return !self.answers.is_empty();
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
        if self.answers.push((sequence, self.status.group, result)).is_err() {
            self.status.faults.dropped_uploads += 1;
        }
        self.report_answers(reports);
    }

    /// Reports what was answered, in that order, as far as there is room.
    fn report_answers(&mut self, reports: &mut Producer<'_, Report>) {
        while reports.ready() && !self.answers.is_empty() {
            let (sequence, group, result) = self.answers.remove(0);
            let _ = reports.enqueue(Report::Done { sequence, group, result });
        }
    }

    /// The groups that commands wait for will not come.
    fn refuse_waiting(&mut self, reports: &mut Producer<'_, Report>) {
        while !self.waiting.is_empty() {
            let command = self.waiting.remove(0);
            self.answer(command.sequence, Err(Refusal::Stopped), reports);
        }
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
            // Time has passed, nobody knows how much: any temperature is as good as another.
            self.temperatures = Default::default();
        }
        Ok(())
    }

    fn write_wiper(&mut self, axis: Axis, tap: Taps) -> Result<(), ()> {
        self.unsure[axis.index()] = self.part.write(axis, tap).is_err();
        if self.unsure[axis.index()] {
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
        let axes = Axis::BOTH.map(|axis| self.close_axis(axis, missed));
        self.status.group = GroupNumber(group.0.wrapping_add(1));
        let acquisition_errors = self.status.faults.acquisition_errors;
        let report = GroupReport { group, lost: self.set.lost, acquisition_errors, axes };
        if self.set.scans.is_empty() {
            self.report(Report::Group(report), reports);
        } else {
            self.stream = Some(Stream::new(before, report));
        }
    }

    fn close_axis(&mut self, axis: Axis, missed: u32) -> AxisReport {
        let sums = self.set.sums[axis.index()];
        let law = self.laws.as_ref().map(|laws| &laws[axis.index()]);
        let state = &mut self.axes[axis.index()];
        state.skip_samples(sums.n);
        let (tap, mode) = (state.tap(), state.mode());
        let (temperature, code) = self.temperatures[axis.index()].check(&sums, missed, self.timing);
        let outcome = state.close_group_at(law, &sums, code);
        // A write that fails leaves the shadow as it was; the law asks again with the next group. Where the wiper stands
        // then nobody knows, so the tap it should have is written again, too.
        let rewrite = Some(tap).filter(|_| self.unsure[axis.index()]);
        let written = outcome.move_to.or(rewrite).map(|wanted| self.write_wiper(axis, wanted));
        let moved_to = outcome.move_to.filter(|_| written == Some(Ok(())));
        let saturated = sums.is_saturated(FULL_SCALE);
        let faults = &mut self.status.faults;
        temperature::count(temperature, faults);
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
            temperature,
            trim_failed: written == Some(Err(())),
        }
    }
}

#[cfg(test)]
mod tests;
