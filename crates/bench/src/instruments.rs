//! What stands on a bench beside the device: chamber, supply, power, and a simulated one's time.

use std::time::Duration;

use zerorate_core::units::{Axis, Celsius, Seconds, Volts};
use zerorate_instruments::fault::Fault;
use zerorate_sim::Truth;

use crate::client::DeviceClient;

/// Whether an instrument that is away is told to rest once more, after so long.
pub type OnceMore<'a> = &'a dyn Fn(Duration) -> bool;

/// How long an instrument that is away is told to rest where somebody waits for it, who has pressed Ctrl-C and can go there.
pub const REST_WATCHED: Duration = Duration::from_secs(30);
/// The same where nobody is there, as at night, when a line is cut for minutes.
const REST_ALONE: Duration = Duration::from_secs(600);

/// How long an instrument that is away is told to rest.
#[must_use]
pub fn rest_for(is_interrupted: bool) -> Duration {
    if is_interrupted { REST_WATCHED } else { REST_ALONE }
}

/// A temperature chamber.
pub trait Chamber {
    /// Sends the chamber to a temperature; it gets there in its own time.
    ///
    /// # Errors
    /// [`InstrumentError`].
    fn set(&mut self, set_point: Celsius) -> Result<(), InstrumentError>;

    /// Where it was sent.
    fn set_point(&self) -> Celsius;

    /// Where its air is; NaN while it is not known.
    ///
    /// # Errors
    /// [`InstrumentError`].
    fn air(&mut self) -> Result<Celsius, InstrumentError>;

    /// Whether it says where its air is. If not, the device's own temperature reading is watched, and
    /// [`air`](Self::air) is NaN.
    fn is_seen(&self) -> bool {
        true
    }

    /// Whether it may have gone where it was not to go, since the last call: it took a set point and its answer was lost, or it came
    /// back with another, or stopped. It is looked at for that.
    ///
    /// # Errors
    /// [`InstrumentError`], while it is away too.
    fn take_astray(&mut self) -> Result<bool, InstrumentError> {
        Ok(false)
    }

    /// What people should know of it, since the last call.
    fn take_notes(&mut self) -> Vec<String> {
        Vec::new()
    }

    /// Leaves it so that it may be left alone.
    ///
    /// # Errors
    /// [`InstrumentError`]; then somebody has to go there.
    fn rest(&mut self, _: OnceMore) -> Result<(), InstrumentError> {
        Ok(())
    }
}

/// A finely adjustable supply that can take the gyros' place, and a voltmeter on their outputs (paper, S8).
pub trait Supply {
    /// Takes the gyros off and feeds a voltage to both rate inputs.
    ///
    /// # Errors
    /// [`InstrumentError`].
    fn feed(&mut self, volts: Volts) -> Result<(), InstrumentError>;

    /// Puts the gyros back.
    ///
    /// # Errors
    /// [`InstrumentError`].
    fn connect_gyros(&mut self) -> Result<(), InstrumentError>;

    /// Looks whether what it feeds is what it fed.
    ///
    /// # Errors
    /// [`InstrumentError`].
    fn hold(&mut self) -> Result<(), InstrumentError> {
        Ok(())
    }

    /// What a voltmeter shows at a gyro's rate output.
    ///
    /// # Errors
    /// [`InstrumentError`].
    fn gyro_output(&mut self, axis: Axis) -> Result<Volts, InstrumentError>;

    /// What people should know of it, since the last call.
    fn take_notes(&mut self) -> Vec<String> {
        Vec::new()
    }

    /// Leaves it so that it may be left alone.
    ///
    /// # Errors
    /// [`InstrumentError`]; then somebody has to go there.
    fn rest(&mut self, _: OnceMore) -> Result<(), InstrumentError> {
        Ok(())
    }
}

/// What gyros and board get their power from.
pub trait Power {
    /// Switches gyros and board off and on again, or has it done.
    ///
    /// # Errors
    /// [`InstrumentError`].
    fn cycle(&mut self) -> Result<Cycled, InstrumentError>;

    /// Whether nobody has to come for it.
    fn obeys(&self) -> bool {
        true
    }
}

/// What became of the power.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cycled {
    /// It was off and on.
    Done,
    /// Somebody was asked to switch it off and on, and the device is seen to start anew.
    Asked,
    /// Nobody is there to do it: the board goes on.
    LeftOn,
}

/// A time that passes only while somebody waits: a simulated plant's.
pub trait Clock {
    /// Lets time pass while the acquisition stands still.
    ///
    /// # Errors
    /// [`InstrumentError`].
    fn wait(&mut self, time: Seconds) -> Result<(), InstrumentError>;
}

/// Someone who knows the plant's truth: the simulated bench. It speaks to reports only.
pub trait Witness {
    /// The truth of the sets taken since the last call, in order.
    fn take(&mut self) -> Vec<Truth>;

    /// What a tap really adds to the reading at the middle tap just now, counts.
    fn tap_counts(&self, axis: Axis, tap: zerorate_core::units::Taps) -> f64;
}

/// An instrument that does not do as it is told.
#[derive(Debug, thiserror::Error)]
pub enum InstrumentError {
    /// The chamber cannot go there.
    #[error("the chamber cannot go to {set_point_c} C: {reason}")]
    SetPoint {
        /// Where it was sent, degrees C.
        set_point_c: f64,
        /// Why not.
        reason: String,
    },
    /// The board does not come up.
    #[error("the board does not come up after its power was switched off and on: {0}")]
    Power(String),
    /// A person was asked, and stopped everything.
    #[error("stopped by Ctrl-C, or by a signal to end")]
    Interrupted,
    /// A person was asked, and there is none.
    #[error("standard input has ended, and nobody answers: a manual chamber and supply need somebody there")]
    NobodyThere,
    /// A remote instrument.
    #[error("{what}: {fault}")]
    Remote {
        /// Which, and where.
        what: String,
        /// Why.
        fault: Fault,
    },
    /// A remote instrument has not answered just now, and is let alone for some seconds.
    #[error("the {0} does not answer")]
    Away(&'static str),
    /// An instrument is needed by another board just now.
    #[error("the {0} is in use by another board")]
    InUse(&'static str),
    /// An instrument could not be left so that it may be left alone.
    #[error("{what} could not be brought to rest: {fault}. GO THERE AND SWITCH IT OFF BY HAND")]
    NotAtRest {
        /// Which, and where.
        what: String,
        /// Why.
        fault: Fault,
    },
    /// The chamber has not got where it was sent.
    #[error(
        "the chamber was sent to {set_point_c} C and is still at {air_c:.1} C after {waited_min:.0} min: check its door, its power and its limits"
    )]
    NotReached {
        /// Where it was sent, degrees C.
        set_point_c: f64,
        /// Where its air is, degrees C.
        air_c: f64,
        /// How long was waited, minutes.
        waited_min: f64,
    },
}

impl InstrumentError {
    /// Whether it may do it later: it does not answer, or is in use.
    #[must_use]
    pub const fn may_pass(&self) -> bool {
        match self {
            Self::Remote { fault, .. } => fault.may_pass(),
            Self::Away(_) | Self::InUse(_) => true,
            _ => false,
        }
    }
}

/// A device and the instruments about it.
pub struct Bench {
    /// The device.
    pub device: DeviceClient,
    /// The chamber.
    pub chamber: Box<dyn Chamber>,
    /// The supply.
    pub supply: Box<dyn Supply>,
    /// The power.
    pub power: Box<dyn Power>,
    /// The plant's time, on a simulated bench. A real one's is told by the board's groups.
    pub clock: Option<Box<dyn Clock>>,
    /// The truth, on a simulated bench.
    pub witness: Option<Box<dyn Witness>>,
}

impl Bench {
    /// Leaves chamber and supply so that they may be left alone; each though the other cannot be.
    ///
    /// # Errors
    /// [`InstrumentError::NotAtRest`].
    pub fn rest(&mut self, once_more: OnceMore) -> Result<(), InstrumentError> {
        // Each is told at once, before one that is away is waited for.
        let _ = self.chamber.rest(&|_| false);
        let _ = self.supply.rest(&|_| false);
        let chamber = self.chamber.rest(once_more);
        let supply = self.supply.rest(once_more);
        chamber.and(supply)
    }
}
