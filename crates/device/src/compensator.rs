//! The work of the data-ready interrupt: take a set, close the group, run the law, write the wiper (paper, fig. 5).
//!
//! Commands are handed over between groups, and what there is to say waits to be fetched: nothing here waits for the host
//! or for flash.

mod axis;
mod command;
mod continuity;
mod memory;
mod outbox;
mod report;
mod samples;
mod scans;
mod temperature;

use core::borrow;

use heapless::Vec;
use zerorate_core::board::BoardNumbers;
use zerorate_core::compensate::{Mode, SampleCorrection};
use zerorate_core::record::Laws;
use zerorate_core::units::{Axis, GroupNumber, Taps};
use zerorate_core::wire::{AxisScan, FaultCounts, GroupReport, Refusal, ScanFlags, ScanReport};

use self::axis::AxisAtWork;
use self::continuity::Continuity;
use self::outbox::Outbox;
use self::scans::Came;
use self::temperature::Believable;
use crate::acquisition::{Acquisition, Timing, axis_samples};
use crate::trim_part::TrimPart;

pub use self::command::{Action, Scheduled};
pub use self::memory::Memory;
pub use self::report::{Outcome, Report, Status};

/// Commands that may wait for their group.
const MAX_WAITING: usize = 8;

/// Scans of the first group of a board that begins by itself: its wipers follow a tenth of a group after the start. Its mean
/// temperature is noisier than that of a group of 500 by three times: 0.4 counts rms by a sensor of 3, a hundredth of a kelvin,
/// which at the paper's steepest is a tenth of a count of drift.
const FIRST_GROUP: u16 = 50;

/// The compensator: an acquisition, a trim part, and both axes at work.
pub struct Compensator<A, P, M = Memory> {
    acquisition: A,
    part: P,
    memory: M,
    timing: Timing,
    /// Scans of the first set when the acquisition is started, until one has come.
    first_length: u16,
    board: BoardNumbers,
    axes: [AxisAtWork; 2],
    /// The group that is being filled, or the first that will be.
    group: GroupNumber,
    running: bool,
    continuity: Continuity,
    /// Sets lost since the acquisition was started.
    lost: u32,
    /// Sets that have arrived since start-up.
    sets: u32,
    waiting: Vec<Scheduled, MAX_WAITING>,
    faults: FaultCounts,
}

impl<A: Acquisition, P: TrimPart, M: borrow::BorrowMut<Memory>> Compensator<A, P, M> {
    /// A compensator at start-up: acquisition stopped, both wipers commanded to the middle tap, no calibration.
    #[must_use]
    pub fn new(acquisition: A, part: P, memory: M, timing: Timing) -> Self {
        let mut compensator = Self::holding(acquisition, part, memory, timing, [Taps::MIDDLE; 2]);
        compensator.rest();
        compensator
    }

    /// A compensator after a restart that nobody asked for: the wipers are left where they stand, which are the taps that
    /// the board has kept through it. With the first group each is written what it should have.
    #[must_use]
    pub fn holding(acquisition: A, part: P, memory: M, timing: Timing, taps: [Taps; 2]) -> Self {
        Self {
            acquisition,
            part,
            memory,
            timing,
            first_length: timing.set_length,
            board: BoardNumbers::PAPER,
            axes: Axis::BOTH.map(|axis| AxisAtWork::new(axis, taps[axis.index()])),
            group: GroupNumber(0),
            running: false,
            continuity: Continuity::beginning(true),
            lost: 0,
            sets: 0,
            waiting: Vec::new(),
            faults: FaultCounts::default(),
        }
    }

    /// Commands both wipers to the middle tap.
    pub fn rest(&mut self) {
        for axis in Axis::BOTH {
            // One that fails is counted; with the next group all are written again.
            let _ = self.write(axis, Taps::MIDDLE);
        }
    }

    /// What the task below may look at.
    #[must_use]
    pub fn status(&self) -> Status {
        let memory: &Memory = self.memory.borrow();
        let [AxisAtWork { state: x, .. }, AxisAtWork { state: y, .. }] = &self.axes;
        Status {
            group: self.group,
            running: self.running,
            sets: self.sets,
            taps: [x.tap(), y.tap()],
            modes: [x.mode(), y.mode()],
            faults: FaultCounts { dropped_uploads: memory.outbox.dropped, ..self.faults },
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
    pub fn install(&mut self, laws: &Laws) {
        let memory: &mut Memory = self.memory.borrow_mut();
        self.board = laws.board;
        for ((axis, law), place) in self.axes.iter_mut().zip(&laws.axes).zip(&mut memory.laws) {
            axis.install(law);
            place.clear();
            let _ = place.extend_from_slice(core::slice::from_ref(law));
        }
        memory.scans.replace(sample_corrections(&self.axes));
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
        let mut waits = self.running && self.read_set();
        while waits {
            waits = self.take_set();
        }
    }

    /// Closes the group of the set that was just read and lets the set go; whether another one has come in its place, which is
    /// then read.
    fn take_set(&mut self) -> bool {
        self.sets = self.sets.wrapping_add(1);
        let number = self.memory().set.number;
        let wants_samples = self.outbox().wants_samples();
        let before = wants_samples.then(|| sample_corrections(&self.axes));
        let report = self.close_group();
        // A wiper that was commanded waits no more than the law's, neither for samples, which take 6 ms on the bus, nor for the
        // set to be let go.
        let follows = match before {
            None => {
                self.outbox().group(report);
                self.run_commands();
                self.let_go(number)
            }
            Some(before) => {
                self.run_commands();
                self.complete_scans();
                // Scans that came one by one need not be read again. Where one was missed they are not read either: that takes
                // longer than two scans, which the next group would miss, and so on for ever.
                let (are_there, follows) = match self.memory().scans.came() {
                    Came::All => {
                        let follows = self.let_go(number);
                        (self.take_scans(number), follows)
                    }
                    Came::Some => {
                        self.outbox().samples_are_missing();
                        (false, self.let_go(number))
                    }
                    Came::None => self.read_scans(number),
                };
                let Memory { outbox, set, .. } = self.memory();
                if are_there {
                    outbox.group_and_samples(report, before, set.scans.len());
                } else {
                    outbox.group(report);
                }
                follows
            }
        };
        let corrections = sample_corrections(&self.axes);
        self.memory().scans.group_begins(number, corrections);
        if follows {
            self.outbox().set_goes();
        }
        follows
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
        let memory: &mut Memory = self.memory.borrow_mut();
        let corrected = memory.scans.correct(scan)?;
        let [lowest, highest] = self.board.reach();
        let axes = Axis::BOTH.map(|axis| {
            let (corrected, is_settling) = corrected[axis.index()];
            let (_, zro) = axis_samples(&scan.scan, axis);
            let flags = self.axes[axis.index()].flags(memory.law(axis).is_some());
            let flags = flags.with(ScanFlags::SETTLING, is_settling);
            let flags = flags.with(ScanFlags::SATURATED, zro <= lowest || zro >= highest);
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
            self.set_up_anew();
        }
    }

    /// Between ticks, as often as a home can tell whether data ready is high. It takes a set whose edge was served in vain before
    /// the tick does, and tries an acquisition that has never been reached yet: an FPGA may be configured later than the
    /// processor starts. Such a try is not counted; the tick's is.
    pub fn look(&mut self, set_waits: bool) {
        if self.running && self.continuity.is_awaited() {
            self.set_up_anew();
        }
        if set_waits {
            self.service();
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
        self.next_but_samples().or_else(|| {
            let Memory { outbox, set, .. } = self.memory();
            outbox.next_of_samples(&set.scans)
        })
    }

    /// The next of what there is to say but for samples, and for the group that follows them.
    pub fn next_but_samples(&mut self) -> Option<Report> {
        self.outbox().next()
    }

    fn memory(&mut self) -> &mut Memory {
        self.memory.borrow_mut()
    }

    fn outbox(&mut self) -> &mut Outbox {
        &mut self.memory().outbox
    }

    fn write(&mut self, axis: Axis, tap: Taps) -> Result<(), Refusal> {
        let memory: &Memory = self.memory.borrow();
        self.axes[axis.index()].write(&mut self.part, tap, memory.law(axis), &mut self.faults)
    }

    /// Reads the sums of the set that waits, which goes on waiting; `false` when there is none, or it cannot be read. A read that
    /// failed is tried once more.
    fn read_set(&mut self) -> bool {
        let memory: &mut Memory = self.memory.borrow_mut();
        let mut read = self.acquisition.read_set(&mut memory.set, true);
        if read.is_err() {
            self.faults.acquisition_errors += 1;
            memory.outbox.set_goes();
            read = self.acquisition.read_set(&mut memory.set, true);
            self.faults.acquisition_errors += u32::from(read.is_err());
        }
        let is_read = matches!(read, Ok(true));
        if is_read {
            memory.outbox.set_goes();
        }
        if is_read && self.continuity.is_known(&memory.set) {
            // It could not be let go.
            let number = memory.set.number;
            return self.let_go(number);
        }
        is_read
    }

    /// Reads the scans of the set whose group was just closed: law and wipers do not wait for them. Those that cannot be read
    /// are dropped, and the set is let go. Whether they are there, and whether another set has come in its place.
    fn read_scans(&mut self, number: u32) -> (bool, bool) {
        let memory: &mut Memory = self.memory.borrow_mut();
        let is_read = (0..2).any(|_| {
            let read = self.acquisition.read_scans(&mut memory.set);
            self.faults.acquisition_errors += u32::from(read.is_err());
            read.is_ok()
        });
        if is_read {
            return (true, false);
        }
        memory.outbox.samples_are_missing();
        (false, self.let_go(number))
    }

    /// A set may be served before its last scan was read: the port has that one still, and it is reported all the same.
    fn complete_scans(&mut self) {
        let scans = &mut self.memory.borrow_mut().scans;
        if let Some(number) = scans.lacked()
            && let Ok(Some(latest)) = self.acquisition.latest_scan()
            && latest.number == number
        {
            scans.complete(latest.scan);
        }
    }

    /// Takes the scans of the set whose group was just closed as they came one by one.
    fn take_scans(&mut self, number: u32) -> bool {
        let Memory { scans, set, outbox, .. } = self.memory();
        let are_its = scans.give(number, &mut set.scans);
        if !are_its {
            outbox.samples_are_missing();
        }
        are_its
    }

    /// Lets the set of a number go, which was read whole and still waits; whether another one has come in its place meanwhile: it
    /// was read then, for the port lets go what waits. Where this fails it is read once more, with the tick, and known.
    fn let_go(&mut self, number: u32) -> bool {
        let memory: &mut Memory = self.memory.borrow_mut();
        let released = self.acquisition.read_set(&mut memory.set, false);
        self.faults.acquisition_errors += u32::from(released.is_err());
        matches!(released, Ok(true)) && memory.set.number != number
    }

    /// Closes the group whose set was just read.
    fn close_group(&mut self) -> GroupReport {
        let memory: &Memory = self.memory.borrow();
        let (group, lost) = self.continuity.set_came(&memory.set);
        self.lost = lost;
        let missed = group.0.saturating_sub(self.group.0);
        self.faults.lost_sets += missed;
        for (axis, sums) in self.axes.iter_mut().zip(&memory.set.sums) {
            axis.lose(missed, sums.n);
        }
        self.first_length = self.timing.set_length;
        let believable = Believable { board: self.board, timing: self.timing, missed };
        let watches = self.axes.each_mut().map(|axis| &mut axis.temperature);
        let temperatures = temperature::check(watches, &memory.set.sums, believable);
        let reach = self.board.reach();
        let axes = Axis::BOTH.map(|axis| {
            let (sums, temperature) = (memory.set.sums[axis.index()], temperatures[axis.index()]);
            let law = memory.law(axis);
            self.axes[axis.index()].close(sums, temperature, reach, law, &mut self.part, &mut self.faults)
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
        let outcome = (self.group, result);
        self.outbox().answer(sequence, outcome);
    }

    fn act(&mut self, action: Action) -> Result<(), Refusal> {
        match action {
            Action::SetMode(axis, mode) => {
                let memory: &Memory = self.memory.borrow();
                self.axes[axis.index()].set_mode(mode, memory.law(axis))
            }
            Action::SetTap(axis, tap) => self.write(axis, tap),
            Action::StorePowerUpTap => self.part.store_power_up().map_err(|_| self.trim_failed()),
            Action::RecallPowerUpTap => {
                self.part.recall_power_up().map_err(|_| self.trim_failed())?;
                self.axes.iter_mut().for_each(AxisAtWork::recall);
                Ok(())
            }
            Action::SetAcquisition(run) => self.set_acquisition(run, self.timing.set_length),
            Action::SetSamples(window) => {
                self.outbox().set_window(window);
                Ok(())
            }
        }
    }

    fn trim_failed(&mut self) -> Refusal {
        self.faults.trim_errors += 1;
        Refusal::TrimPartFailed
    }

    fn set_up_anew(&mut self) {
        self.continuity.set_up_anew(self.group, self.lost, self.timing);
        let reached = self.start_acquisition().is_ok();
        self.continuity.started(reached);
    }

    /// Starts the acquisition anew at set 0, of which the scans are counted anew, too.
    fn start_acquisition(&mut self) -> Result<(), A::Error> {
        let corrections = sample_corrections(&self.axes);
        let (first, further) = (self.first_length, self.timing.set_length);
        self.memory().scans.begin(corrections, first, further);
        self.acquisition.start(self.timing, self.first_length)
    }

    /// Starts it with a first set of so many scans, or stops it.
    fn set_acquisition(&mut self, run: bool, first: u16) -> Result<(), Refusal> {
        self.first_length = first;
        let done = if run { self.start_acquisition() } else { self.acquisition.stop() };
        done.map_err(|_| Refusal::AcquisitionFailed)?;
        self.running = run;
        self.outbox().forget_samples();
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
