//! A chamber's controller: where its air is, where it is sent, and that it takes what it is sent.
//!
//! Nothing is sent that is outside the limits; what was sent is read back; what no sensor gives is refused.

mod form;
mod presets;
mod registers;
mod table;
mod watlow;

use std::thread;
use std::time::Duration;

use zerorate_core::units::Celsius;

pub use self::table::ControllerTable;

use self::form::Degrees;
use self::registers::ByRegisters;
use self::watlow::ByScpi;
use crate::address::{Address, Protocol};
use crate::fault::Fault;
use crate::modbus::Modbus;
use crate::scpi::Scpi;

/// A reading beyond these is none of a chamber, degrees C: the coldest go to -100, the hottest to 300.
const COLDEST: f64 = -120.0;
const HOTTEST: f64 = 400.0;
/// How often a reading that cannot be is read before it is believed to be so, and a set point before it is not taken.
const LOOKS: u32 = 3;
/// How long between two of them: a controller takes some cycles of 100 ms to take a value up.
const LOOK_AGAIN: Duration = Duration::from_millis(250);

/// How a controller is spoken to, in its own degrees.
trait Speech: Send {
    fn actual(&mut self) -> Result<f64, Fault>;
    fn set_point(&mut self) -> Result<f64, Fault>;
    fn send(&mut self, value: f64) -> Result<(), Fault>;
    fn run(&mut self) -> Result<(), Fault>;
    fn stop(&mut self) -> Result<(), Fault>;
    /// Whether it says that it stands still, or that it runs; `None` of one that says neither.
    fn stopped(&mut self) -> Result<Option<bool>, Fault>;
    /// The least difference that it knows, degrees.
    fn resolution(&self) -> f64;
    fn identity(&mut self) -> Result<Option<String>, Fault>;
}

/// A chamber's controller.
pub struct Controller {
    speech: Box<dyn Speech>,
    degrees: Degrees,
    limits: [Celsius; 2],
    safe: Celsius,
}

impl Controller {
    /// A controller at an address, by its table; it is never sent beyond `limits`.
    ///
    /// # Errors
    /// A sentence that says what the table lacks.
    pub fn new(address: &Address, table: &ControllerTable, limits: [Celsius; 2]) -> Result<Self, String> {
        let (line, time_out) = (address.line(), table.time_out());
        let speech: Box<dyn Speech> = match address.protocol {
            Protocol::Scpi if table.preset == "watlow-f4t" => Box::new(ByScpi::new(Scpi::new(line, time_out))),
            Protocol::Scpi => {
                return Err(format!(
                    "chamber.controller.preset is \"{}\": by SCPI only watlow-f4t is spoken to; give a modbus address",
                    table.preset
                ));
            }
            protocol => {
                let modbus = Modbus::new(line, protocol, table.unit, time_out);
                Box::new(ByRegisters::new(modbus, table.registers()?))
            }
        };
        Ok(Self { speech, degrees: table.degrees(), limits, safe: Celsius(table.safe_c) })
    }

    /// Who it says that it is, where it can.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn identity(&mut self) -> Result<Option<String>, Fault> {
        self.speech.identity()
    }

    /// Where its air is.
    ///
    /// # Errors
    /// [`Fault::NoTemperature`] for what no sensor gives.
    pub fn actual(&mut self) -> Result<Celsius, Fault> {
        self.temperature("the air's temperature", |speech| speech.actual())
    }

    /// Where it says that it was sent.
    ///
    /// # Errors
    /// [`Fault::NoTemperature`] for what no set point is.
    pub fn set_point(&mut self) -> Result<Celsius, Fault> {
        self.temperature("the set point", |speech| speech.set_point())
    }

    /// Sends the chamber to a temperature and makes it run, if it is not out of its limits.
    ///
    /// # Errors
    /// [`Fault::OutsideLimits`] before anything is sent, [`Fault::NotTaken`] after it.
    pub fn send(&mut self, to: Celsius) -> Result<(), Fault> {
        self.write(to)?;
        self.speech.run()
    }

    /// Sends the chamber to its safe set point and stops it. Either is tried though the other has failed.
    ///
    /// # Errors
    /// [`Fault`]; then somebody has to go there.
    pub fn rest(&mut self) -> Result<(), Fault> {
        let written = self.write(self.safe);
        let stopped = self.speech.stop().and_then(|()| self.stands());
        written.and(stopped)
    }

    /// Looks whether it has stopped, if it tells.
    fn stands(&mut self) -> Result<(), Fault> {
        for _ in 0..LOOKS {
            if self.speech.stopped()? != Some(false) {
                return Ok(());
            }
            thread::sleep(LOOK_AGAIN);
        }
        Err(Fault::RunsOn)
    }

    /// What has become of a controller that was sent somewhere, where it is not on its way any more: a phrase.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn strayed_from(&mut self, to: Celsius) -> Result<Option<String>, Fault> {
        let is = self.set_point()?;
        if !self.is_same(is, to) {
            return Ok(Some(format!("set to {:.1} C", is.0)));
        }
        Ok((self.speech.stopped()? == Some(true)).then(|| "stopped".to_owned()))
    }

    /// Where it is sent at the end.
    #[must_use]
    pub const fn safe(&self) -> Celsius {
        self.safe
    }

    /// Whether two set points are one to it.
    fn is_same(&self, one: Celsius, other: Celsius) -> bool {
        // Half of the last digit is rounding, and a Fahrenheit's is smaller.
        (one - other).0.abs() <= 0.51 * self.speech.resolution() + 1e-3
    }

    fn write(&mut self, to: Celsius) -> Result<(), Fault> {
        let [least, most] = self.limits.map(|limit| limit.0);
        if !(least..=most).contains(&to.0) {
            return Err(Fault::OutsideLimits {
                what: "a set point (C) of",
                value: to.0,
                least,
                most,
                limit: "chamber.limits_c",
            });
        }
        self.speech.send(to_degrees(to, self.degrees))?;
        let mut looks = 1;
        loop {
            let read_back = self.set_point()?;
            if self.is_same(read_back, to) {
                return Ok(());
            }
            if looks == LOOKS {
                return Err(Fault::NotTaken { what: "a set point (C) of", sent: to.0, read_back: read_back.0 });
            }
            looks += 1;
            thread::sleep(LOOK_AGAIN);
        }
    }

    fn temperature(
        &mut self,
        what: &'static str,
        read: impl Fn(&mut dyn Speech) -> Result<f64, Fault>,
    ) -> Result<Celsius, Fault> {
        let mut looks = 1;
        loop {
            let raw = match read(&mut *self.speech) {
                Ok(value) => {
                    let celsius = from_degrees(value, self.degrees);
                    // NaN is in no range.
                    if (COLDEST..=HOTTEST).contains(&celsius.0) {
                        return Ok(celsius);
                    }
                    value.to_string()
                }
                Err(Fault::NoTemperature { raw, .. }) => raw,
                Err(other) => return Err(other),
            };
            if looks == LOOKS {
                return Err(Fault::NoTemperature { what, raw });
            }
            looks += 1;
            thread::sleep(LOOK_AGAIN);
        }
    }
}

fn to_degrees(celsius: Celsius, degrees: Degrees) -> f64 {
    match degrees {
        Degrees::C => celsius.0,
        Degrees::F => celsius.0 * 1.8 + 32.0,
    }
}

fn from_degrees(value: f64, degrees: Degrees) -> Celsius {
    Celsius(match degrees {
        Degrees::C => value,
        Degrees::F => (value - 32.0) / 1.8,
    })
}

#[cfg(test)]
mod tests;
