//! The work of the data-ready interrupt: take a set, close the group, run the law, write the wiper (paper, fig. 5).
//!
//! Commands are handed over between groups, and what there is to say waits to be fetched: nothing here waits for the host
//! or for flash.

mod axis;
mod command;
mod continuity;
mod outbox;
mod report;
mod samples;
mod scans;
mod temperature;

use heapless::Vec;
use zerorate_core::board::BoardNumbers;
use zerorate_core::compensate::{Mode, SampleCorrection};
use zerorate_core::record::Laws;
use zerorate_core::units::{Axis, GroupNumber, Taps};
use zerorate_core::wire::{AxisScan, FaultCounts, GroupReport, Refusal, ScanFlags, ScanReport};

use self::axis::AxisAtWork;
use self::continuity::Continuity;
use self::outbox::Outbox;
use self::scans::ScanByScan;
use self::temperature::Believable;
use crate::acquisition::{Acquisition, Set, Timing, axis_samples};
use crate::trim_part::TrimPart;

pub use self::command::{Action, Scheduled};
pub use self::report::{Outcome, Report, Status};

/// Commands that may wait for their group.
const MAX_WAITING: usize = 8;

/// Scans of the first group of a board that begins by itself: its wipers follow a tenth of a group after the start. Its mean
/// temperature is noisier than that of a group of 500 by three times: 0.4 counts rms by a sensor of 3, a hundredth of a kelvin,
/// which at the paper's steepest is a tenth of a count of drift.
const FIRST_GROUP: u16 = 50;

/// The compensator: an acquisition, a trim part, and both axes at work.
pub struct Compensator<A, P> {
    acquisition: A,
    part: P,
    timing: Timing,
    /// Scans of the first set when the acquisition is started, until one has come.
    first_length: u16,
    board: BoardNumbers,
    axes: [AxisAtWork; 2],
    set: Set,
    scans: ScanByScan,
    /// The group that is being filled, or the first that will be.
    group: GroupNumber,
    running: bool,
    continuity: Continuity,
    /// Sets lost since the acquisition was started.
    lost: u32,
    /// Sets that have arrived since start-up.
    sets: u32,
    waiting: Vec<Scheduled, MAX_WAITING>,
    outbox: Outbox,
    faults: FaultCounts,
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
        let axes = Axis::BOTH.map(|axis| AxisAtWork::new(axis, taps[axis.index()]));
        let corrections = sample_corrections(&axes);
        Self {
            acquisition,
            part,
            timing,
            first_length: timing.set_length,
            board: BoardNumbers::PAPER,
            axes,
            set: Set::default(),
            scans: ScanByScan::beginning(corrections, timing.set_length, timing.set_length),
            group: GroupNumber(0),
            running: false,
            continuity: Continuity::beginning(true),
            lost: 0,
            sets: 0,
            waiting: Vec::new(),
            outbox: Outbox::new(),
            faults: FaultCounts::default(),
        }
    }

    /// Commands both wipers to the middle tap.
    pub fn rest(&mut self) {
        for axis in &mut self.axes {
            // One that fails is counted; with the next group all are written again.
            let _ = axis.write(&mut self.part, Taps::MIDDLE, &mut self.faults);
        }
    }

    /// What the task below may look at.
    #[must_use]
    pub const fn status(&self) -> Status {
        let [AxisAtWork { state: x, .. }, AxisAtWork { state: y, .. }] = &self.axes;
        Status {
            group: self.group,
            running: self.running,
            sets: self.sets,
            taps: [x.tap(), y.tap()],
            modes: [x.mode(), y.mode()],
            faults: FaultCounts { dropped_uploads: self.outbox.dropped, ..self.faults },
        }
    }

    /// The acquisition, for whoever drives its ticks.
    pub const fn acquisition(&mut self) -> &mut A {
        &mut self.acquisition
    }

    /// The board that it is built on, by which it judges readings until a record tells more; the paper's where nobody says.
    pub const fn built_on(&mut self, board: BoardNumbers) {
        self.board = board;
    }

    /// Takes laws into use, keeping modes and taps.
    pub fn install(&mut self, laws: Laws) {
        self.board = laws.board;
        for (axis, law) in self.axes.iter_mut().zip(laws.axes) {
            axis.install(law);
        }
        self.scans.replace(sample_corrections(&self.axes));
    }

    /// Puts both axes in the modes of start-up.
    pub fn set_modes(&mut self, modes: [Mode; 2]) {
        for (axis, mode) in self.axes.iter_mut().zip(modes) {
            axis.state.set_mode(mode);
        }
    }

    /// Takes groups without being asked, the first a short one. An acquisition that cannot be reached is counted, and tried
    /// again.
    pub fn begin_alone(&mut self) {
        let reached = self.set_acquisition(true, FIRST_GROUP.min(self.timing.set_length)).is_ok();
        self.faults.acquisition_errors += u32::from(!reached);
        self.continuity = Continuity::beginning(reached);
        self.running = true;
    }

    /// The interrupt: called when a set is ready.
    pub fn service(&mut self) {
        let with_samples = self.outbox.wants_samples();
        // Scans that came one by one need not be read again.
        let came = with_samples && self.scans.has_all();
        if self.running && self.read_set(with_samples && !came) {
            self.sets = self.sets.wrapping_add(1);
            let before = with_samples.then(|| sample_corrections(&self.axes));
            let report = self.close_group();
            match before {
                None => {
                    self.outbox.group(report);
                    self.run_commands();
                }
                Some(before) => {
                    // A wiper that was commanded waits no more than the law's for samples, which take 6 ms on the bus.
                    self.run_commands();
                    let are_there = if came { self.take_scans() } else { self.read_scans() };
                    if are_there {
                        self.outbox.group_and_samples(report, before, self.set.scans.len());
                    } else {
                        self.outbox.group(report);
                    }
                }
            }
            self.scans.group_begins(self.set.number, sample_corrections(&self.axes));
        }
    }

    /// The interrupt of a scan: called when one is ready, before [`service`](Self::service) for the set that it fills. The scan,
    /// corrected by the law as it stands; none where it was read before, or cannot be.
    pub fn scan(&mut self) -> Option<ScanReport> {
        if !self.running {
            return None;
        }
        let mut read = self.acquisition.latest_scan();
        if read.is_err() {
            self.faults.acquisition_errors += 1;
            read = self.acquisition.latest_scan();
            self.faults.acquisition_errors += u32::from(read.is_err());
        }
        let scan = read.ok().flatten()?;
        let corrected = self.scans.correct(scan)?;
        let axes = Axis::BOTH.map(|axis| {
            let (corrected, is_settling) = corrected[axis.index()];
            let (_, zro) = axis_samples(&scan.scan, axis);
            let flags = self.axes[axis.index()].flags();
            let flags = flags.with(ScanFlags::SETTLING, is_settling);
            let flags = flags.with(ScanFlags::SATURATED, zro == 0 || zro >= self.board.full_scale);
            AxisScan { corrected_q16: corrected.0, flags }
        });
        Some(ScanReport { scan: scan.number, axes })
    }

    /// The tick, once a second. It takes a set that waits though its edge was served in vain: after reads that failed data
    /// ready stays high, and no edge comes again. An acquisition from which none comes is set up anew.
    pub fn tick(&mut self) {
        self.service();
        if self.running && self.continuity.is_broken(self.timing) {
            self.faults.acquisition_errors += 1;
            self.continuity.set_up_anew(self.group, self.lost, self.timing);
            let reached = self.start_acquisition().is_ok();
            self.continuity.started(reached);
        }
    }

    /// Takes a command, after the set that may be waiting: does it at once, or keeps it until its group is about to begin.
    pub fn order(&mut self, command: Scheduled) {
        self.service();
        let Scheduled { sequence, action, .. } = command;
        if self.running && action.waits_for_a_group() {
            if self.waiting.push(command).is_err() {
                self.answer(sequence, Err(Refusal::Busy));
            }
            return;
        }
        let result = self.act(action);
        if matches!(action, Action::SetAcquisition(_)) && result.is_ok() {
            // The groups that commands wait for will not come.
            for command in core::mem::take(&mut self.waiting) {
                self.answer(command.sequence, Err(Refusal::Stopped));
            }
        }
        self.answer(sequence, result);
    }

    /// The next of what there is to say.
    pub fn next_report(&mut self) -> Option<Report> {
        self.outbox.next(&self.set.scans)
    }

    /// Reads the sums of the set that waits; `false` when there is none, or it cannot be read. A read that failed is tried
    /// once more: a set that was not read whole still waits.
    fn read_set(&mut self, then_scans: bool) -> bool {
        let mut read = self.acquisition.read_set(&mut self.set, then_scans);
        if read.is_err() {
            self.faults.acquisition_errors += 1;
            self.outbox.set_goes();
            read = self.acquisition.read_set(&mut self.set, then_scans);
            self.faults.acquisition_errors += u32::from(read.is_err());
        }
        let is_read = matches!(read, Ok(true));
        if is_read {
            self.outbox.set_goes();
        }
        if is_read && self.continuity.is_known(&self.set) {
            // Its scans could not be read, so it still waited.
            self.let_go();
            return false;
        }
        is_read
    }

    /// Reads the scans of the set whose group was just closed: law and wipers do not wait for them. Those that cannot be read
    /// are dropped, and the set is let go.
    fn read_scans(&mut self) -> bool {
        let is_read = (0..2).any(|_| {
            let read = self.acquisition.read_scans(&mut self.set);
            self.faults.acquisition_errors += u32::from(read.is_err());
            read.is_ok()
        });
        if !is_read {
            self.outbox.samples_are_missing();
            self.let_go();
        }
        is_read
    }

    /// Takes the scans of the set whose group was just closed as they came one by one.
    fn take_scans(&mut self) -> bool {
        let are_its = self.scans.give(self.set.number, &mut self.set.scans);
        if !are_its {
            self.outbox.samples_are_missing();
        }
        are_its
    }

    /// Lets the set go that was read and still waits. Where that fails it is read once more, with the tick, and known.
    fn let_go(&mut self) {
        let released = self.acquisition.read_set(&mut self.set, false);
        self.faults.acquisition_errors += u32::from(released.is_err());
    }

    /// Closes the group whose set was just read.
    fn close_group(&mut self) -> GroupReport {
        let (group, lost) = self.continuity.set_came(&self.set);
        self.lost = lost;
        let missed = group.0.saturating_sub(self.group.0);
        self.faults.lost_sets += missed;
        for (axis, sums) in self.axes.iter_mut().zip(&self.set.sums) {
            axis.lose(missed, sums.n);
        }
        self.first_length = self.timing.set_length;
        let believable = Believable { board: self.board, timing: self.timing };
        let axes = Axis::BOTH.map(|axis| {
            let sums = self.set.sums[axis.index()];
            let other = self.axes[1 - axis.index()].temperature.believed();
            self.axes[axis.index()].close(sums, other, missed, believable, &mut self.part, &mut self.faults)
        });
        self.group = GroupNumber(group.0.wrapping_add(1));
        let acquisition_errors = self.faults.acquisition_errors;
        GroupReport { group, lost, acquisition_errors, axes }
    }

    /// Runs the waiting commands whose group is about to begin, in the order in which they came.
    fn run_commands(&mut self) {
        let next = self.group;
        let is_due = |command: &Scheduled| command.at.is_none_or(|at| at <= next);
        while let Some(index) = self.waiting.iter().position(is_due) {
            let Scheduled { sequence, action, .. } = self.waiting.remove(index);
            let result = self.act(action);
            self.answer(sequence, result);
        }
    }

    fn answer(&mut self, sequence: u16, result: Result<(), Refusal>) {
        self.outbox.answer(sequence, (self.group, result));
    }

    fn act(&mut self, action: Action) -> Result<(), Refusal> {
        match action {
            Action::SetMode(axis, mode) => self.axes[axis.index()].set_mode(mode),
            Action::SetTap(axis, tap) => self.axes[axis.index()].write(&mut self.part, tap, &mut self.faults),
            Action::StorePowerUpTap => self.part.store_power_up().map_err(|_| self.trim_failed()),
            Action::RecallPowerUpTap => {
                self.part.recall_power_up().map_err(|_| self.trim_failed())?;
                self.axes.iter_mut().for_each(AxisAtWork::recall);
                Ok(())
            }
            Action::SetAcquisition(run) => self.set_acquisition(run, self.timing.set_length),
            Action::SetSamples(window) => {
                self.outbox.set_window(window);
                Ok(())
            }
        }
    }

    fn trim_failed(&mut self) -> Refusal {
        self.faults.trim_errors += 1;
        Refusal::TrimPartFailed
    }

    /// Starts the acquisition anew at set 0, of which the scans are counted anew, too.
    fn start_acquisition(&mut self) -> Result<(), A::Error> {
        let corrections = sample_corrections(&self.axes);
        self.scans = ScanByScan::beginning(corrections, self.first_length, self.timing.set_length);
        self.acquisition.start(self.timing, self.first_length)
    }

    /// Starts it with a first set of so many scans, or stops it.
    fn set_acquisition(&mut self, run: bool, first: u16) -> Result<(), Refusal> {
        self.first_length = first;
        let done = if run { self.start_acquisition() } else { self.acquisition.stop() };
        done.map_err(|_| Refusal::AcquisitionFailed)?;
        self.running = run;
        self.outbox.forget_samples();
        if run {
            self.group = GroupNumber(0);
            self.lost = 0;
            self.continuity = Continuity::beginning(true);
            for axis in &mut self.axes {
                // Time has passed, nobody knows how much: any temperature is as good as another.
                axis.temperature = Default::default();
            }
        }
        Ok(())
    }
}

fn sample_corrections(axes: &[AxisAtWork; 2]) -> [SampleCorrection; 2] {
    axes.each_ref().map(|axis| axis.state.sample_correction())
}

#[cfg(test)]
mod tests;
