//! A chamber led through a profile, second by second, by whoever's time it is.

use zerorate_cal::recording::{ChamberMoment, Phase};
use zerorate_core::units::{Celsius, Kelvins, Seconds};

use super::{Profile, Step};
use crate::error::BenchError;
use crate::instruments::{Chamber, InstrumentError};
use crate::soaking::{Gone, Held, Hold, Way};

/// How often the chamber is looked at.
const LOOK_EVERY: Seconds = Seconds(1.0);
/// A ramp's set point moves by so much at once: many a controller writes each of them to a memory that wears.
const RAMP_STEP: Kelvins = Kelvins(0.5);
/// A ramp waits for a chamber whose air is further behind its set point: it is too slow for the ramp.
const BEHIND: Kelvins = Kelvins(10.0);

/// Whose time passes.
pub trait Pace {
    /// Lets time pass, and says how much has passed since the last call: a machine may have slept.
    ///
    /// # Errors
    /// [`InstrumentError::Interrupted`] when somebody wants everything to stop.
    fn wait(&mut self, time: Seconds) -> Result<Seconds, InstrumentError>;
}

/// Who is told what happens.
pub trait Watcher {
    /// The step at this place of the profile begins.
    fn step(&mut self, place: usize);

    /// A second has gone by.
    ///
    /// # Errors
    /// When it cannot be kept.
    fn moment(&mut self, moment: &ChamberMoment) -> Result<(), BenchError>;

    /// Something that people should know at once.
    fn note(&mut self, text: &str);
}

/// Leads a chamber through a profile. What it is left at is the caller's to say ([`Chamber::rest`]).
///
/// # Errors
/// [`BenchError`]; what was seen until then was told.
pub fn drive(
    profile: &Profile,
    chamber: &mut dyn Chamber,
    pace: &mut dyn Pace,
    watcher: &mut dyn Watcher,
) -> Result<(), BenchError> {
    let mut drive = Drive { chamber, pace, watcher, elapsed: Seconds(0.0), place: 0 };
    for (place, step) in profile.steps.iter().enumerate() {
        drive.place = place;
        drive.watcher.step(place);
        match *step {
            Step::Soak { at, hold } => drive.soak(at, hold)?,
            Step::Ramp { to, k_per_min } => drive.ramp(to, k_per_min)?,
        }
    }
    Ok(())
}

struct Drive<'a> {
    chamber: &'a mut dyn Chamber,
    pace: &'a mut dyn Pace,
    watcher: &'a mut dyn Watcher,
    elapsed: Seconds,
    place: usize,
}

impl Drive<'_> {
    fn soak(&mut self, at: Celsius, time: Seconds) -> Result<(), BenchError> {
        let going = going(self.chamber.air()?, at);
        self.send(at, going)?;
        loop {
            self.arrive(at, going)?;
            let mut hold = Hold::at(at, time);
            loop {
                if hold.left().0 <= 0.0 {
                    return Ok(());
                }
                let (air, since) = self.look(Phase::Soak)?;
                match hold.held(air, since) {
                    Held::Enough => return Ok(()),
                    Held::On => {}
                    Held::Strayed => {
                        self.watcher.note(&hold.strayed(air));
                        break;
                    }
                }
            }
        }
    }

    /// Leads the set point, and waits at its end. While nobody knows where the air is, or it is far behind, the set point stays.
    fn ramp(&mut self, to: Celsius, k_per_min: f64) -> Result<(), BenchError> {
        let from = self.chamber.set_point();
        let (going, sign) = (going(from, to), (to - from).0.signum());
        let (mut led, mut was_told) = (Seconds(0.0), false);
        loop {
            let due = Kelvins((k_per_min / 60.0 * led.0).min((to - from).0.abs()));
            let set_point = Celsius(from.0 + sign * due.0);
            let is_last = due.0 >= (to - from).0.abs();
            if is_last {
                self.send(to, going)?;
                return self.arrive(to, going);
            }
            if (set_point - self.chamber.set_point()).0.abs() >= RAMP_STEP.0 {
                self.send(set_point, going)?;
            }
            let (air, since) = self.look(going)?;
            let behind = (self.chamber.set_point() - air).0 * sign;
            if behind <= BEHIND.0 {
                led = led + since;
            } else if !behind.is_nan() && !was_told {
                was_told = true;
                self.watcher.note(&format!(
                    "the chamber is {behind:.0} K behind its set point: it does not go at {k_per_min} K/min, and the ramp waits for it"
                ));
            }
        }
    }

    /// Waits until the air is there.
    fn arrive(&mut self, at: Celsius, going: Phase) -> Result<(), BenchError> {
        let mut way = Way::to(at);
        loop {
            let (air, since) = self.look(going)?;
            match way.goes_on(air, since)? {
                Gone::Arrived => return Ok(()),
                Gone::On => {}
                Gone::Told(text) | Gone::Stands(text) => self.watcher.note(&text),
            }
        }
    }

    /// Sends the chamber somewhere, as soon as it can be asked.
    fn send(&mut self, to: Celsius, going: Phase) -> Result<(), BenchError> {
        loop {
            match self.chamber.set(to) {
                Err(error) if error.may_pass() => drop(self.look(going)?),
                other => return Ok(other?),
            }
        }
    }

    /// Lets a second go by and looks where the air is; says how much time has passed, too.
    fn look(&mut self, phase: Phase) -> Result<(Celsius, Seconds), BenchError> {
        let passed = self.pace.wait(LOOK_EVERY)?;
        self.elapsed = self.elapsed + passed;
        let air = self.chamber.air();
        for note in self.chamber.take_notes() {
            self.watcher.note(&note);
        }
        let air = air?;
        let step = u32::try_from(self.place + 1).unwrap_or(u32::MAX);
        let set_c = self.chamber.set_point().0;
        self.watcher.moment(&ChamberMoment { t_s: self.elapsed.0, step, phase, set_c, air_c: air.0 })?;
        Ok((air, passed))
    }
}

/// The direction of a way.
fn going(from: Celsius, to: Celsius) -> Phase {
    if to.0 < from.0 { Phase::Cooling } else { Phase::Heating }
}

#[cfg(test)]
mod tests;
