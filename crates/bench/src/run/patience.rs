//! What a session does with an instrument that does not answer: it waits until it is back, and takes groups meanwhile.

use std::thread;
use std::time::Duration;

use zerorate_core::units::Celsius;

use super::{Phase, Recorder, Session};
use crate::error::BenchError;
use crate::instruments::{Bench, InstrumentError};

/// How often it is looked for while no groups come.
const LOOK_EVERY: Duration = Duration::from_millis(100);

impl Session<'_> {
    /// Does something with an instrument, again and again while that is away. Groups that come meanwhile are recorded as of
    /// a phase.
    ///
    /// # Errors
    /// [`BenchError`], and [`InstrumentError::Interrupted`] when somebody does not want to wait.
    pub(crate) fn patiently<T>(
        &mut self,
        phase: Phase,
        recorder: &mut Recorder,
        mut act: impl FnMut(&mut Bench) -> Result<T, InstrumentError>,
    ) -> Result<T, BenchError> {
        loop {
            let done = act(self.bench);
            self.tell_notes();
            match done {
                Err(error) if error.may_pass() => {}
                done => return Ok(done?),
            }
            if self.progress.is_interrupted() {
                return Err(InstrumentError::Interrupted.into());
            }
            if self.acquiring {
                self.take(phase, recorder)?;
            } else {
                thread::sleep(LOOK_EVERY);
            }
        }
    }

    /// Where the chamber's air is; NaN while it is not known.
    pub(super) fn air(&mut self) -> Result<Celsius, BenchError> {
        let air = self.bench.chamber.air();
        self.tell_notes();
        Ok(air?)
    }

    fn tell_notes(&mut self) {
        let (chamber, supply) = (self.bench.chamber.take_notes(), self.bench.supply.take_notes());
        for note in chamber.into_iter().chain(supply) {
            self.warn(note);
        }
    }
}
