//! The way to a temperature and the time there, by a chamber that says where its air is.

use zerorate_core::units::{Celsius, Seconds};
use zerorate_core::wire::SampleWindow;

use super::{AT_SET_POINT, Phase, Recorder, Session};
use crate::error::BenchError;
use crate::instruments::InstrumentError;

/// How often the chamber is looked at on the way to a soak.
const LOOK_EVERY: Seconds = Seconds(10.0);
/// A chamber slower than this on the way to a soak has failed: twenty hours a hundred kelvins.
const SLOWEST_KELVINS_PER_SECOND: f64 = 100.0 / 72_000.0;

impl Session<'_> {
    /// Sends the chamber to a temperature and holds it there. Where time passes only while somebody waits the acquisition
    /// stands still meanwhile; on a real bench it tells the time, and nobody records it.
    ///
    /// # Errors
    /// [`InstrumentError::NotReached`] when it does not get there.
    pub fn soak(&mut self, what: &str, set_point: Celsius, hold: Seconds) -> Result<(), BenchError> {
        if !self.bench.chamber.is_seen() {
            return self.soak_by_reading(what, set_point, hold);
        }
        self.phase(what, 0);
        if self.bench.clock.is_some() {
            self.bench.chamber.set(set_point)?;
            return self.arrive_and_hold(set_point, hold);
        }
        self.start(SampleWindow::NONE)?;
        self.bench.chamber.set(set_point)?;
        self.arrive_and_hold(set_point, hold)?;
        self.stop()
    }

    fn arrive_and_hold(&mut self, set_point: Celsius, hold: Seconds) -> Result<(), BenchError> {
        let mut air = self.bench.chamber.air()?;
        let patience = 3600.0 + (set_point - air).0.abs() / SLOWEST_KELVINS_PER_SECOND;
        let mut waited = 0.0;
        while (air - set_point).0.abs() > AT_SET_POINT.0 {
            if waited > patience {
                return Err(InstrumentError::NotReached {
                    set_point_c: set_point.0,
                    air_c: air.0,
                    waited_min: waited / 60.0,
                }
                .into());
            }
            self.wait(LOOK_EVERY)?;
            waited += LOOK_EVERY.0;
            air = self.bench.chamber.air()?;
            self.progress.step(air.0);
        }
        self.wait(hold)?;
        self.progress.step(self.bench.chamber.air()?.0);
        Ok(())
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
