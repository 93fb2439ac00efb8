//! A bench without remote control: a person at the chamber, the supply and the switch, told what to do.
//!
//! What a person does is seen in the device's own temperature reading ([`watch`]) and in the device's starting anew; only
//! what leaves no trace is asked for with Enter.

pub mod watch;

use std::cell::RefCell;
use std::rc::Rc;

use zerorate_core::units::{Axis, Celsius, Volts};

use crate::instruments::{Chamber, Cycled, InstrumentError, Power, Supply};

/// A voltage beyond this is none that a gyro's output or a bench's supply has.
const MOST_VOLTS: f64 = 100.0;

/// A person.
pub trait Operator {
    /// Tells what to do; returns at once.
    fn tell(&mut self, what: &str);

    /// Tells what to do and waits until it is said to be done.
    ///
    /// # Errors
    /// [`InstrumentError::Interrupted`], [`InstrumentError::NobodyThere`].
    fn ask_done(&mut self, what: &str) -> Result<(), InstrumentError>;

    /// Asks for a number.
    ///
    /// # Errors
    /// [`InstrumentError::Interrupted`], [`InstrumentError::NobodyThere`].
    fn ask_number(&mut self, what: &str) -> Result<f64, InstrumentError>;
}

/// A person whom everything manual asks.
pub type Person = Rc<RefCell<dyn Operator>>;

/// A chamber that a person sets, who is asked what it shows now.
///
/// # Errors
/// [`InstrumentError`], when nobody says.
pub fn chamber(operator: &Person) -> Result<Box<dyn Chamber>, InstrumentError> {
    let now = operator.borrow_mut().ask_number("what does the chamber show now, in degrees C")?;
    Ok(Box::new(ManualChamber { operator: Rc::clone(operator), set_point: Celsius(now) }))
}

/// A supply that a person sets.
#[must_use]
pub fn supply(operator: &Person) -> Box<dyn Supply> {
    Box::new(ManualSupply(Rc::clone(operator)))
}

/// A switch that a person turns.
#[must_use]
pub fn power(operator: &Person) -> Box<dyn Power> {
    Box::new(ManualSwitch(Rc::clone(operator)))
}

struct ManualChamber {
    operator: Person,
    set_point: Celsius,
}

impl Chamber for ManualChamber {
    fn set(&mut self, set_point: Celsius) -> Result<(), InstrumentError> {
        self.set_point = set_point;
        self.operator.borrow_mut().tell(&format!("set the chamber to {:+.1} C", set_point.0));
        Ok(())
    }

    fn set_point(&self) -> Celsius {
        self.set_point
    }

    fn air(&mut self) -> Result<Celsius, InstrumentError> {
        Ok(Celsius(f64::NAN))
    }

    fn is_seen(&self) -> bool {
        false
    }
}

struct ManualSupply(Person);

impl Supply for ManualSupply {
    fn feed(&mut self, volts: Volts) -> Result<(), InstrumentError> {
        self.0.borrow_mut().ask_done(&format!("feed {:.4} V to both rate inputs in the gyros' place", volts.0))
    }

    fn connect_gyros(&mut self) -> Result<(), InstrumentError> {
        self.0.borrow_mut().ask_done("take the supply off and connect the gyros again")
    }

    fn gyro_output(&mut self, axis: Axis) -> Result<Volts, InstrumentError> {
        let name = axis.name().to_uppercase();
        loop {
            let volts =
                self.0.borrow_mut().ask_number(&format!("how many volts are at the {name} gyro's rate output"))?;
            if volts.abs() < MOST_VOLTS {
                return Ok(Volts(volts));
            }
            self.0.borrow_mut().tell("that is no output's voltage: read the voltmeter again, in volts");
        }
    }
}

struct ManualSwitch(Person);

impl Power for ManualSwitch {
    fn cycle(&mut self) -> Result<Cycled, InstrumentError> {
        self.0.borrow_mut().tell("switch gyros and board off, and on again");
        Ok(Cycled::Asked)
    }

    fn obeys(&self) -> bool {
        false
    }
}
