//! What a session does with instruments that obey a person: it watches the device's own reading.

use std::time::{Duration, Instant};

use zerorate_core::units::{Axis, Celsius, Counts, Seconds};
use zerorate_core::wire::SampleWindow;

use super::{Phase, Recorder, Session, Taken};
use crate::client::Group;
use crate::error::BenchError;
use crate::instruments::InstrumentError;
use crate::manual::watch::{RampWatch, ReadingScale, Seen, SoakWatch};

/// How long a person may be away before a run gives up waiting for the switch.
const AWAY: Duration = Duration::from_secs(24 * 3600);
/// A ramp is longer than what a chamber's air is held to, kelvin.
const FAR: Celsius = Celsius(5.0);
/// How often they are reminded of it.
const REMIND: Duration = Duration::from_secs(120);

impl Session<'_> {
    /// Sends the chamber to a temperature and takes the groups of the ramp there, `groups` at most: the chamber's that is
    /// seen from the moment it is sent; otherwise from when the device's reading begins to move until it has settled.
    ///
    /// # Errors
    /// [`BenchError`]; what was taken is in the recording.
    pub fn ramp(
        &mut self,
        set_point: Celsius,
        groups: u32,
        phase: Phase,
        recorder: &mut Recorder,
    ) -> Result<Vec<Taken>, BenchError> {
        let from = self.bench.chamber.set_point();
        self.leave(set_point, recorder)?;
        if self.bench.chamber.is_seen() {
            let last = self.taken + groups;
            let mut taken = vec![self.take(phase, recorder)?];
            self.see_it_leave(from, set_point)?;
            taken.extend(self.until(last, phase, recorder)?);
            return if self.was_astray(recorder)? { Err(BenchError::OffCourse) } else { Ok(taken) };
        }
        let period = self.setup.group_period();
        let mut watch = RampWatch::new(from, set_point, period * f64::from(groups), period);
        let mut taken = Vec::new();
        let mut begun = false;
        let began = self.elapsed;
        while taken.len() < groups as usize {
            let group = self.take(if begun { phase } else { Phase::Soak }, recorder)?;
            let reading = self.celsius(mean_reading(&group));
            if begun {
                taken.push(group);
            }
            match watch.see(self.elapsed - began, reading) {
                Seen::Nothing => {}
                Seen::Warning(text) => self.warn(text),
                Seen::Begun => {
                    begun = true;
                    self.progress.note(&format!("the ramp has begun; at most {groups} groups of it are taken"));
                }
                Seen::Settled => {
                    self.progress.note(&format!("the ramp has ended after {} groups", taken.len()));
                    break;
                }
            }
        }
        Ok(taken)
    }

    /// Warns of air that is where the ramp ends when it has hardly begun: what is read is a set point, or does not move.
    fn see_it_leave(&mut self, from: Celsius, to: Celsius) -> Result<(), BenchError> {
        let air = self.air()?;
        let (way, left) = ((to - from).0.abs(), (to - air).0.abs());
        if way > FAR.0 && left < 0.1 * way {
            self.warn(format!(
                "the chamber's air is told to be at {:.1} C as soon as it was sent from {:.1} to {:.1} C: see whether the air is read, and not a set point or a value that stands",
                air.0, from.0, to.0
            ));
        }
        Ok(())
    }

    /// Has the chamber sent to a temperature, and watches until the device is as warm and was held there.
    pub(super) fn soak_by_reading(&mut self, what: &str, set_point: Celsius, hold: Seconds) -> Result<(), BenchError> {
        self.phase(what, 0);
        let from = self.bench.chamber.set_point();
        self.bench.chamber.set(set_point)?;
        self.start(SampleWindow::NONE)?;
        let period = self.setup.group_period();
        let mut watch = SoakWatch::new(from, set_point, hold, period);
        let began = self.elapsed;
        loop {
            let group = self.take(Phase::Soak, &mut Recorder::discarding())?;
            let reading = self.celsius(mean_reading(&group));
            match watch.see(self.elapsed - began, reading) {
                Seen::Nothing | Seen::Begun => {}
                Seen::Warning(text) => self.warn(text),
                Seen::Settled => {
                    watch.oddity(reading).into_iter().for_each(|text| self.warn(text));
                    self.progress.note(&format!("settled, about {:+.1} C", reading.0));
                    return self.stop();
                }
            }
        }
    }

    /// Waits until the device has started anew.
    pub(super) fn await_power(&mut self) -> Result<(), BenchError> {
        let progress = &mut *self.progress;
        let mut reminded = Instant::now();
        let look = || {
            if progress.is_interrupted() {
                return Err(BenchError::from(InstrumentError::Interrupted));
            }
            if reminded.elapsed() > REMIND {
                reminded = Instant::now();
                progress.note("still waiting for the power to go off and on");
            }
            Ok(())
        };
        self.bench.device.await_restart(AWAY, look)?;
        self.progress.note("the device has started anew");
        Ok(())
    }

    /// Records the groups that have arrived although nobody waits for them any more.
    ///
    /// # Errors
    /// [`BenchError`], when they cannot be recorded.
    pub fn record_the_rest(&mut self, phase: Phase, recorder: &mut Recorder) -> Result<(), BenchError> {
        while let Some(group) = self.bench.device.arrived_group() {
            self.record(group, phase, recorder)?;
        }
        Ok(())
    }

    /// Names the groups that never came.
    pub(super) fn name_the_lost(&mut self) {
        let lost = self.bench.device.take_lost_groups();
        if lost.is_empty() {
            return;
        }
        let which: Vec<String> = lost
            .into_iter()
            .map(|range| match range.into_inner() {
                (first, last) if first == last => first.to_string(),
                (first, last) => format!("{first} to {last}"),
            })
            .collect();
        let told = self.warnings.add(format!("{}: groups that did not arrive: {}", self.doing, which.join(", ")));
        self.progress.note(&told);
    }

    pub(super) fn warn(&mut self, text: String) {
        let told = self.warnings.remind(text);
        self.progress.note(&told);
    }

    /// How warm a group says that it is, about.
    pub(super) fn warmth(&mut self, group: &Group) -> Celsius {
        let [x, y] = Axis::BOTH.map(|axis| group.report.axes[axis.index()].sums.mean_temperature().0);
        self.celsius(Counts(f64::midpoint(x, y)))
    }

    /// A reading in degrees C. The first one of a session is what the chamber was at then. No set point is an anchor: where the
    /// chamber was ordered to is no measurement of where it is.
    fn celsius(&mut self, reading: Counts) -> Celsius {
        let counts_per_celsius = self.setup.board.counts_per_celsius;
        let first = ReadingScale { counts_per_celsius, anchor: (reading, self.at) };
        self.scale.get_or_insert(first).celsius(reading)
    }
}

fn mean_reading(taken: &Taken) -> Counts {
    let [x, y] = Axis::BOTH.map(|axis| taken.temperature(axis).0);
    Counts(f64::midpoint(x, y))
}
