//! The way to a temperature and the time there, by a chamber that says where its air is.

use zerorate_core::units::{Axis, Celsius, Seconds};
use zerorate_core::wire::SampleWindow;

use super::{Phase, Recorder, Session, Taken};
use crate::error::BenchError;
use crate::soaking::{Gone, Held, Hold, Way};

/// How often the chamber is looked at on the way to a soak.
const LOOK_EVERY: Seconds = Seconds(10.0);

impl Session<'_> {
    /// Sends the chamber to a temperature and holds it there. Where time passes only while somebody waits the acquisition
    /// stands still meanwhile; on a real bench it tells the time, and nobody records it.
    ///
    /// # Errors
    /// [`NotReached`](crate::instruments::InstrumentError::NotReached) when it does not get there.
    pub fn soak(&mut self, what: &str, set_point: Celsius, hold: Seconds) -> Result<(), BenchError> {
        if !self.bench.chamber.is_seen() {
            return self.soak_by_reading(what, set_point, hold);
        }
        self.phase(what, 0);
        let on_the_boards_time = self.bench.clock.is_none();
        if on_the_boards_time {
            self.start(SampleWindow::NONE)?;
        }
        let nobody = &mut Recorder::discarding();
        self.patiently(Phase::Soak, nobody, |bench| bench.chamber.set(set_point))?;
        self.arrive(set_point, nobody)?;
        if !on_the_boards_time {
            self.wait(hold, nobody)?;
            let air = self.air()?;
            self.progress.step(air.0);
            return Ok(());
        }
        self.hold(set_point, hold, nobody)?;
        self.stop()
    }

    /// Sends the chamber off from where it was held. One that did not answer may have gone without a word: then it is sent back and
    /// held once more, for a ramp begins where everything inside is at one temperature.
    pub(super) fn leave(&mut self, to: Celsius, recorder: &mut Recorder) -> Result<(), BenchError> {
        let from = self.bench.chamber.set_point();
        let mut is_astray = self.was_astray(recorder)?;
        loop {
            if !is_astray {
                self.patiently(Phase::Soak, recorder, |bench| bench.chamber.set(to))?;
                if !self.was_astray(recorder)? {
                    return Ok(());
                }
            }
            self.warn(format!(
                "the chamber may have left {} C while it did not answer, before the ramp began: it is sent back and held there again",
                from.0
            ));
            self.patiently(Phase::Soak, recorder, |bench| bench.chamber.set(from))?;
            self.arrive(from, recorder)?;
            self.hold(from, Seconds(self.setup.chamber.soak_s), recorder)?;
            is_astray = false;
        }
    }

    /// Whether the chamber has gone where it was not to go, since that was last asked; it is waited for while it is away.
    pub(super) fn was_astray(&mut self, recorder: &mut Recorder) -> Result<bool, BenchError> {
        self.patiently(Phase::Soak, recorder, |bench| bench.chamber.take_astray())
    }

    /// Holds the board's own temperature against the chamber's air, which it follows where it lies in it.
    pub(super) fn follow(&mut self, taken: &Taken, air: Celsius) -> Result<(), BenchError> {
        if !self.bench.chamber.is_seen() {
            return Ok(());
        }
        let board = Axis::BOTH.map(|axis| self.setup.celsius(taken.temperature(axis)));
        self.following.see(self.elapsed, air, board).map_or(Ok(()), |left| Err(left.into()))
    }

    /// Waits until the air is at the set point.
    fn arrive(&mut self, set_point: Celsius, recorder: &mut Recorder) -> Result<(), BenchError> {
        let mut way = Way::to(set_point);
        loop {
            let air = self.air()?;
            self.progress.step(air.0);
            let gone = way.goes_on(air, LOOK_EVERY)?;
            match gone {
                Gone::Arrived => return Ok(()),
                Gone::Stands(text) => self.warn(text),
                // Where time passes only while somebody waits, nobody does.
                Gone::Told(text) if self.bench.clock.is_none() => self.progress.note(&text),
                Gone::Told(_) | Gone::On => {}
            }
            self.wait(LOOK_EVERY, recorder)?;
        }
    }

    /// Holds the chamber for so long, the time left out in which nobody knows where it is; anew if it has left its set point.
    fn hold(&mut self, set_point: Celsius, time: Seconds, recorder: &mut Recorder) -> Result<(), BenchError> {
        let mut hold = Hold::at(set_point, time);
        while hold.left().0 > 0.0 {
            let step = Seconds(LOOK_EVERY.0.min(hold.left().0));
            self.wait(step, recorder)?;
            let air = self.air()?;
            if hold.held(air, step) == Held::Strayed {
                self.warn(hold.strayed(air));
                self.arrive(set_point, recorder)?;
                hold = Hold::at(set_point, time);
            }
        }
        // What it did on its way and meanwhile is over: it was here for so long.
        self.was_astray(recorder).map(drop)
    }

    /// Lets time pass: the plant's, or that of the board's groups.
    fn wait(&mut self, time: Seconds, recorder: &mut Recorder) -> Result<(), BenchError> {
        if let Some(clock) = &mut self.bench.clock {
            clock.wait(time)?;
            self.elapsed = self.elapsed + time;
            return Ok(());
        }
        let until = self.elapsed + time;
        while self.elapsed.0 < until.0 {
            self.take(Phase::Soak, recorder)?;
        }
        Ok(())
    }
}
