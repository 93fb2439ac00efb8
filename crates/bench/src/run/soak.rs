//! The way to a temperature and the time there, by a chamber that says where its air is.

use zerorate_core::units::{Celsius, Kelvins, Seconds};
use zerorate_core::wire::SampleWindow;

use super::{AT_SET_POINT, Phase, Recorder, Session};
use crate::error::BenchError;
use crate::instruments::InstrumentError;

/// A chamber that is held stays nearer than this: its regulation's ripple and overshoot are half of it.
const STRAYED: Kelvins = Kelvins(2.0);
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
        let mut air = self.air()?;
        let mut way = None;
        let mut waited = 0.0;
        // A chamber that is away is nowhere.
        while air.0.is_nan() || (air - set_point).0.abs() > AT_SET_POINT.0 {
            if !air.0.is_nan() {
                let way = *way.get_or_insert((set_point - air).0.abs());
                if waited > 3600.0 + way / SLOWEST_KELVINS_PER_SECOND {
                    let waited_min = waited / 60.0;
                    return Err(
                        InstrumentError::NotReached { set_point_c: set_point.0, air_c: air.0, waited_min }.into()
                    );
                }
                waited += LOOK_EVERY.0;
            }
            self.wait(LOOK_EVERY)?;
            air = self.air()?;
            self.progress.step(air.0);
        }
        Ok(())
    }

    /// Holds the chamber for so long, the time left out in which nobody knows where it is; `false` if it has left its set point.
    fn hold(&mut self, set_point: Celsius, hold: Seconds) -> Result<bool, BenchError> {
        let mut held = 0.0;
        while held < hold.0 {
            let step = LOOK_EVERY.0.min(hold.0 - held);
            self.wait(Seconds(step))?;
            let air = self.air()?;
            if air.0.is_nan() {
                continue;
            }
            if (air - set_point).0.abs() > STRAYED.0 {
                self.warn(format!(
                    "the chamber has left its set point of {} C and is at {:.1} C: the soak begins anew once it is back",
                    set_point.0, air.0
                ));
                return Ok(false);
            }
            held += step;
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
