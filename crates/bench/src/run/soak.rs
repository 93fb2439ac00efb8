//! The way to a temperature and the time there, by a chamber that says where its air is.

use zerorate_core::units::{Celsius, Seconds};
use zerorate_core::wire::SampleWindow;

use super::{Phase, Recorder, Session};
use crate::error::BenchError;
use crate::soaking::{Held, Hold, Way};

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
        self.patiently(Phase::Soak, &mut Recorder::discarding(), |bench| bench.chamber.set(set_point))?;
        self.arrive(set_point)?;
        if !on_the_boards_time {
            self.wait(hold)?;
            let air = self.air()?;
            self.progress.step(air.0);
            return Ok(());
        }
        while !self.hold(set_point, hold)? {
            self.arrive(set_point)?;
        }
        self.stop()
    }

    /// Waits until the air is at the set point.
    fn arrive(&mut self, set_point: Celsius) -> Result<(), BenchError> {
        let mut way = Way::to(set_point);
        let mut air = self.air()?;
        while !way.has_ended(air, LOOK_EVERY)? {
            self.wait(LOOK_EVERY)?;
            air = self.air()?;
            self.progress.step(air.0);
        }
        Ok(())
    }

    /// Holds the chamber for so long, the time left out in which nobody knows where it is; `false` if it has left its set point.
    fn hold(&mut self, set_point: Celsius, time: Seconds) -> Result<bool, BenchError> {
        let mut hold = Hold::at(set_point, time);
        while hold.left().0 > 0.0 {
            let step = Seconds(LOOK_EVERY.0.min(hold.left().0));
            self.wait(step)?;
            let air = self.air()?;
            if hold.held(air, step) == Held::Strayed {
                self.warn(hold.strayed(air));
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Lets time pass: the plant's, or that of the board's groups.
    fn wait(&mut self, time: Seconds) -> Result<(), BenchError> {
        if let Some(clock) = &mut self.bench.clock {
            clock.wait(time)?;
            self.elapsed = self.elapsed + time;
            return Ok(());
        }
        let until = self.elapsed + time;
        while self.elapsed.0 < until.0 {
            self.take(Phase::Soak, &mut Recorder::discarding())?;
        }
        Ok(())
    }
}
