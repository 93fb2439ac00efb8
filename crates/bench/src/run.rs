//! Taking groups: the one loop that every procedure records with.

mod patience;
mod rest;
mod soak;
mod unseen;
mod warnings;

use serde::{Deserialize, Serialize};
pub use warnings::Warnings;
pub use zerorate_cal::recording::Phase;
use zerorate_cal::recording::{GroupRow, RecordingWriter, status};
use zerorate_core::drift::Coverage;
use zerorate_core::units::{Axis, Celsius, Counts, Seconds};
use zerorate_core::wire::{GroupReport, Request, SampleWindow, TemperatureCheck};
use zerorate_sim::Truth;

use crate::client::Group;
use crate::error::BenchError;
use crate::following::Following;
use crate::instruments::{Bench, InstrumentError};
use crate::manual::watch::ReadingScale;
use crate::plan::{Part, Plan};
use crate::setup::SetUp;
use crate::steps::StepWatch;

/// A group with what was about it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Taken {
    /// The group as the device reported it.
    pub report: GroupReport,
    /// Time since the recording began, to the group's end.
    pub time: Seconds,
    /// What the chamber was doing.
    pub phase: Phase,
    /// The largest jump of X's and Y's corrected samples in the group's first second, counts; NaN without samples.
    pub jumps: [f64; 2],
    /// The truth, on a simulated bench.
    #[serde(skip)]
    pub truth: Option<Truth>,
}

impl Taken {
    /// The corrected mean of an axis.
    #[must_use]
    pub fn corrected(&self, axis: Axis) -> Counts {
        self.report.axes[axis.index()].corrected()
    }

    /// The mean zero-rate output of an axis as read.
    #[must_use]
    pub fn zro(&self, axis: Axis) -> Counts {
        self.report.axes[axis.index()].sums.mean_zro()
    }

    /// The mean temperature reading of an axis.
    #[must_use]
    pub fn temperature(&self, axis: Axis) -> Counts {
        self.report.axes[axis.index()].sums.mean_temperature()
    }
}

/// Who is told how far things are.
pub trait Progress {
    /// A whole run is planned.
    fn plan(&mut self, plan: &Plan) {
        let _ = plan;
    }

    /// The part at this place of the plan begins.
    fn part(&mut self, plan: &Plan, place: usize) {
        let _ = (plan, place);
    }

    /// A phase begins that will take so many groups (0: no groups are taken in it).
    fn phase(&mut self, name: &str, groups: u32);

    /// A group was taken, or time passed; the chamber's air is at `air_c` degrees C.
    fn step(&mut self, air_c: f64);

    /// A group was taken, which ended so many seconds after the session began.
    fn group(&mut self, taken: &Taken, elapsed_s: f64) {
        let _ = (taken, elapsed_s);
    }

    /// Something that people should know at once.
    fn note(&mut self, text: &str) {
        let _ = text;
    }

    /// Whether somebody wants everything to stop.
    fn is_interrupted(&self) -> bool {
        false
    }
}

/// Nobody is told.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn phase(&mut self, _: &str, _: u32) {}
    fn step(&mut self, _: f64) {}
}

/// A bench at work on one unit.
pub struct Session<'b> {
    /// The bench.
    pub bench: &'b mut Bench,
    /// The set-up.
    pub setup: &'b SetUp,
    /// Who is told.
    pub progress: &'b mut dyn Progress,
    /// Time since the session began, as the bench counts it.
    pub elapsed: Seconds,
    /// What came to nothing on the way.
    pub warnings: Warnings,
    watches: [StepWatch; 2],
    taken: u32,
    acquiring: bool,
    /// Where the chamber was when the session began.
    at: Celsius,
    scale: Option<ReadingScale>,
    following: Following,
    doing: String,
    plan: Option<Plan>,
}

impl<'b> Session<'b> {
    /// A session on a bench.
    pub fn new(bench: &'b mut Bench, setup: &'b SetUp, progress: &'b mut dyn Progress) -> Self {
        let at = bench.chamber.set_point();
        Self {
            bench,
            setup,
            progress,
            at,
            elapsed: Seconds(0.0),
            warnings: Warnings::default(),
            watches: Default::default(),
            taken: 0,
            acquiring: false,
            scale: None,
            following: Following::new(Seconds(setup.chamber.soak_s)),
            doing: String::new(),
            plan: None,
        }
    }

    /// Tells of a whole run before it begins; `left` is how much of each part is still to do, 0 to 1.
    pub fn plan(&mut self, left: impl Fn(Part) -> f64) {
        let plan = Plan::of(self.setup).less_what_is_done(left);
        self.progress.plan(&plan);
        self.plan = Some(plan);
    }

    /// A part of the planned run begins.
    pub fn part(&mut self, part: Part) {
        if let Some(plan) = &self.plan
            && let Some(place) = plan.place(part)
        {
            self.progress.part(plan, place);
        }
    }

    /// A phase begins that will take so many groups.
    pub fn phase(&mut self, name: &str, groups: u32) {
        // What was lost before was lost of what was done then.
        self.name_the_lost();
        name.clone_into(&mut self.doing);
        self.progress.phase(name, groups);
    }

    /// Starts the acquisition at group 0.
    ///
    /// # Errors
    /// [`BenchError`].
    pub fn start(&mut self, samples: SampleWindow) -> Result<(), BenchError> {
        self.bench.device.order(Request::SetStream { groups: true, samples })?;
        self.bench.device.order(Request::SetAcquisition { run: true })?;
        self.acquiring = true;
        self.watches = Default::default();
        self.taken = 0;
        if let Some(witness) = &mut self.bench.witness {
            witness.take();
        }
        Ok(())
    }

    /// Samples in a group's first second.
    #[must_use]
    pub fn first_second(&self) -> usize {
        1_000_000 / self.setup.acquisition.sample_period_us.max(1) as usize
    }

    /// Stops the acquisition.
    ///
    /// # Errors
    /// [`BenchError`].
    pub fn stop(&mut self) -> Result<(), BenchError> {
        self.bench.device.order(Request::SetAcquisition { run: false })?;
        self.acquiring = false;
        self.bench.device.discard_groups();
        self.name_the_lost();
        Ok(())
    }

    /// Takes groups and records them, until so many have come since the acquisition started.
    ///
    /// # Errors
    /// [`BenchError`]; what was taken is in the recording.
    pub fn until(&mut self, groups: u32, phase: Phase, recorder: &mut Recorder) -> Result<Vec<Taken>, BenchError> {
        let mut taken = Vec::with_capacity(groups.saturating_sub(self.taken) as usize);
        while self.taken < groups {
            taken.push(self.take(phase, recorder)?);
        }
        Ok(taken)
    }

    /// Takes one group and records it.
    ///
    /// # Errors
    /// [`BenchError`]; what was taken is in the recording.
    pub fn take(&mut self, phase: Phase, recorder: &mut Recorder) -> Result<Taken, BenchError> {
        if self.progress.is_interrupted() {
            return Err(InstrumentError::Interrupted.into());
        }
        let group = self.bench.device.next_group()?;
        self.record(group, phase, recorder)
    }

    fn record(&mut self, group: Group, phase: Phase, recorder: &mut Recorder) -> Result<Taken, BenchError> {
        self.taken = group.report.group.0 + 1;
        let first_second = self.first_second();
        let jumps =
            Axis::BOTH.map(|axis| self.watches[axis.index()].largest_jump(&group.samples[axis.index()], first_second));
        let truth = self
            .bench
            .witness
            .as_mut()
            .and_then(|witness| witness.take().into_iter().find(|truth| truth.set == group.report.group.0));
        let air = self.air()?;
        // One that is never seen is as warm as the board, about; one that is away is nowhere.
        let about = if self.bench.chamber.is_seen() { air } else { self.warmth(&group) };
        self.progress.step(about.0);
        let period = self.setup.group_period();
        self.elapsed = self.elapsed + period;
        let time = period * f64::from(self.taken);
        let taken = Taken { report: group.report, time, phase, jumps, truth };
        self.progress.group(&taken, self.elapsed.0);
        recorder.record(&taken, self.bench.chamber.set_point(), air)?;
        self.follow(&taken, air)?;
        Ok(taken)
    }
}

/// Writes groups into a recording.
pub struct Recorder {
    /// `None`: nobody wants the recording.
    writer: Option<RecordingWriter>,
    /// Where this run's groups begin in the recording: each acquisition counts from 0, a recording goes on.
    offset: Extent,
    last: Extent,
}

/// How far a recording has got: groups, and seconds.
pub type Extent = (u32, f64);

impl Recorder {
    /// A recorder on a recording.
    #[must_use]
    pub const fn new(writer: RecordingWriter) -> Self {
        Self { writer: Some(writer), offset: (0, 0.0), last: (0, 0.0) }
    }

    /// A recorder on a recording that goes on after what it has.
    #[must_use]
    pub const fn after(writer: RecordingWriter, extent: Extent) -> Self {
        Self { writer: Some(writer), offset: extent, last: extent }
    }

    /// How far the recording has got.
    #[must_use]
    pub const fn extent(&self) -> Extent {
        self.last
    }

    /// A recorder that keeps nothing, for a study of many units.
    #[must_use]
    pub const fn discarding() -> Self {
        Self { writer: None, offset: (0, 0.0), last: (0, 0.0) }
    }

    /// The next groups belong to another run in the same recording.
    pub const fn next_run(&mut self) {
        self.offset = self.last;
    }

    /// Closes the recording: it becomes a Parquet file.
    ///
    /// # Errors
    /// [`BenchError`], when the disk is full, say; what was recorded is kept.
    pub fn finish(self) -> Result<(), BenchError> {
        if let Some(writer) = self.writer {
            writer.finish()?;
        }
        Ok(())
    }

    fn record(&mut self, taken: &Taken, chamber_set: Celsius, air: Celsius) -> Result<(), BenchError> {
        let group = self.offset.0 + taken.report.group.0;
        let time = self.offset.1 + taken.time.0;
        self.last = (group + 1, time);
        if let Some(writer) = &mut self.writer {
            writer.write_group(&Axis::BOTH.map(|axis| row(taken, axis, (group, time), chamber_set, air)))?;
        }
        Ok(())
    }
}

/// One axis of a group as a recording has it, with its number and time there.
#[must_use]
pub fn row(taken: &Taken, axis: Axis, (group, t_s): (u32, f64), chamber_set: Celsius, air: Celsius) -> GroupRow {
    let report = &taken.report.axes[axis.index()];
    let mut status_bits = match report.coverage {
        Coverage::Below => status::BELOW,
        Coverage::Above => status::ABOVE,
        Coverage::Inside | Coverage::Invalid => 0,
    };
    status_bits |= if report.saturated { status::SATURATED } else { 0 };
    status_bits |= if report.moved_to.is_some() { status::MOVED } else { 0 };
    status_bits |= match report.temperature {
        TemperatureCheck::Believed => 0,
        TemperatureCheck::Stuck => status::STUCK,
        TemperatureCheck::Jumped => status::JUMPED,
        TemperatureCheck::Saturated => status::TEMPERATURE_SATURATED,
    };
    status_bits |= if report.trim_failed { status::TRIM_FAILED } else { 0 };
    GroupRow {
        group,
        t_s,
        phase: taken.phase,
        axis,
        sums: report.sums,
        corrected_counts: taken.corrected(axis).0,
        tap: report.tap.get(),
        mode: report.mode,
        chamber_set_c: chamber_set.0,
        chamber_c: air.0,
        status_bits,
    }
}
