//! Instruments by remote control behind chamber and supply: they are asked while groups come, and left safe at the end.
//!
//! One that does not answer is let alone for some seconds and asked again ([`Patience`]): groups do not wait behind it.

use std::thread;
use std::time::{Duration, Instant};

use zerorate_core::units::{Axis, Celsius, Volts};
pub use zerorate_instruments::address::Address;
use zerorate_instruments::controller::Controller;
use zerorate_instruments::fault::Fault;
use zerorate_instruments::patience::Patience;
use zerorate_instruments::supply::PowerSupply;

use crate::instruments::{Chamber, Cycled, InstrumentError, OnceMore, Power, Supply};
use crate::setup::SetUp;

/// How long after an instrument that is away was told to rest it is told again.
const REST_AGAIN: Duration = Duration::from_secs(1);
/// How often one that answers and does not rest is told.
const REST_TRIES: u32 = 3;

/// Why a remote instrument cannot stand on a bench.
#[derive(Debug, thiserror::Error)]
pub enum RemoteError {
    /// The set-up does not say how it is spoken to.
    #[error("{0}")]
    SetUp(String),
    /// It does not answer as it should.
    #[error(transparent)]
    Instrument(#[from] InstrumentError),
}

/// What was found when an instrument was asked for the first time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// A sentence.
    pub told: String,
    /// What a record says of it: where it is, and who it says it is.
    pub label: String,
}

/// What both instruments have: a name for sentences, patience, and what is to be told.
struct Contact {
    what: &'static str,
    name: String,
    patience: Patience,
    notes: Vec<String>,
}

impl Contact {
    fn with(what: &'static str, address: &Address) -> Self {
        let name = format!("the {what} at {address}");
        Self { what, name, patience: Patience::with(what), notes: Vec::new() }
    }

    fn error(&self, fault: Fault) -> InstrumentError {
        InstrumentError::Remote { what: self.name.clone(), fault }
    }

    /// Does something with the instrument, if it is to be asked now; says whether it had been silent before.
    fn attempt<T>(&mut self, act: impl FnOnce() -> Result<T, Fault>) -> Result<(T, bool), InstrumentError> {
        if !self.patience.may_ask(Instant::now()) {
            return Err(InstrumentError::Away(self.what));
        }
        match act() {
            Err(fault) if fault.may_pass() => {
                self.notes.extend(self.patience.silent(Instant::now(), &fault.to_string()));
                Err(self.error(fault))
            }
            Err(fault) => Err(self.error(fault)),
            Ok(value) => {
                let (was_silent, told) = self.patience.heard(Instant::now());
                self.notes.extend(told);
                Ok((value, was_silent))
            }
        }
    }

    /// Does what makes it safe, again and again where it is away.
    fn bring_to_rest(
        &self,
        once_more: OnceMore,
        mut act: impl FnMut() -> Result<(), Fault>,
    ) -> Result<(), InstrumentError> {
        let (began, mut not_done) = (Instant::now(), 0);
        loop {
            let Err(fault) = act() else { return Ok(()) };
            // What it does not do, though it answers, it may not have heard.
            not_done += u32::from(!fault.may_pass());
            let again = if fault.may_pass() { once_more(began.elapsed()) } else { not_done < REST_TRIES };
            if !again {
                return Err(InstrumentError::NotAtRest { what: self.name.clone(), fault });
            }
            thread::sleep(REST_AGAIN);
        }
    }
}

/// A chamber by remote control.
pub struct RemoteChamber {
    controller: Controller,
    contact: Contact,
    set_point: Celsius,
    /// Whether it was sent anywhere, and not brought to rest since.
    is_under_way: bool,
    /// Whether it is to be told once more where it was sent: it was away, or did not take it.
    is_owed: bool,
    /// How long it has not done as it was told, though it may answer.
    obedience: Patience,
    /// When it was last looked at whether it is where it was sent.
    looked: Instant,
    /// How often in a row it was elsewhere.
    strays: u32,
    is_astray: bool,
    /// Where its air was, when that was asked, and how long the answer took.
    last: Option<(Celsius, Instant, Duration)>,
}

/// No more than a quarter of the time goes by with asking where the air is: groups wait meanwhile, and where those come faster
/// than answers the last one stands for several.
const SHARE_OF_TIME: u32 = 4;
/// How often a chamber is looked at whether it is where it was sent.
const LOOK_EVERY: Duration = Duration::from_secs(5);
/// Each time that it is elsewhere again the next look comes twice as late, to five minutes: many a controller writes set points to a
/// memory that wears, and whatever else sets it will not give in.
const MOST_DOUBLED: u32 = 6;
/// From so many times on something else sets it.
const OFTEN: u32 = 3;

impl RemoteChamber {
    /// A chamber that was asked who it is and what it shows; it is not moved.
    ///
    /// # Errors
    /// [`RemoteError`].
    pub fn open(address: &Address, setup: &SetUp) -> Result<(Self, Found), RemoteError> {
        let Some(table) = &setup.chamber.controller else {
            return Err(RemoteError::SetUp(format!(
                "{address}: the set-up does not say which controller this is, and a set point in a wrong register does harm: put [chamber.controller] with preset = \"...\" into it (`zerorate setup --controller watlow-f4t` prints one)"
            )));
        };
        let limits = setup.chamber.limits_c.map(Celsius);
        let mut controller = Controller::new(address, table, limits).map_err(RemoteError::SetUp)?;
        let contact = Contact::with("chamber", address);
        let asked = (|| Ok((controller.identity()?, controller.actual()?, controller.set_point()?)))();
        let (identity, air, set_point) = asked.map_err(|fault| contact.error(fault))?;
        let who = identity.map_or_else(String::new, |identity| format!(" ({identity})"));
        let told = format!("{}{who} shows {:.1} C and is set to {:.1} C", contact.name, air.0, set_point.0);
        let found = Found { told, label: format!("{address}{who}") };
        let chamber = Self {
            controller,
            contact,
            set_point: air,
            is_under_way: false,
            is_owed: false,
            obedience: Patience::with("chamber"),
            looked: Instant::now(),
            strays: 0,
            is_astray: false,
            last: None,
        };
        Ok((chamber, found))
    }

    /// Looks now and then whether it is where it was sent, and at once where it was away: it may start anew between two answers.
    fn remind(&mut self) -> Result<(), InstrumentError> {
        if !self.is_owed && self.looked.elapsed() < LOOK_EVERY * 2_u32.pow(self.strays.min(MOST_DOUBLED)) {
            return Ok(());
        }
        match self.look() {
            // One that is busy is told again later.
            Err(error) if error.may_pass() => Ok(()),
            done => done,
        }
    }

    /// Looks whether it is where it was sent, and sends it there if not.
    fn look(&mut self) -> Result<(), InstrumentError> {
        if !self.is_under_way {
            return Ok(());
        }
        if !self.may_ask() {
            return Err(InstrumentError::Away(self.contact.what));
        }
        self.looked = Instant::now();
        let done = self.put_right();
        self.obeyed(&done);
        done.map_err(|fault| self.contact.error(fault))
    }

    fn may_ask(&self) -> bool {
        self.contact.patience.may_ask(Instant::now()) && self.obedience.may_ask(Instant::now())
    }

    /// Takes in whether it did as it was told.
    fn obeyed(&mut self, done: &Result<(), Fault>) {
        let now = Instant::now();
        self.is_owed = done.is_err();
        let told = match done {
            Ok(()) => self.obedience.heard(now).1,
            // It answers nothing: that is told, and it is let alone, once.
            Err(fault) if self.contact.patience.is_silent() => self.contact.patience.silent(now, &fault.to_string()),
            Err(fault) => self.obedience.silent(now, &fault.to_string()),
        };
        self.contact.notes.extend(told);
    }

    fn put_right(&mut self) -> Result<(), Fault> {
        let should = self.set_point;
        let strayed = self.controller.strayed_from(should)?;
        // Whether it is sent there or not: it was elsewhere.
        self.is_astray |= strayed.is_some();
        self.strays = if strayed.is_some() { self.strays + 1 } else { 0 };
        // After a silence with the same set point too: it may have come back without running, and not every one tells.
        if strayed.is_some() || self.is_owed {
            self.controller.send(should)?;
        }
        if let Some(strayed) = strayed {
            let by_another = match self.strays {
                ..OFTEN => "",
                _ => "; something else sets it too: another program, a person, or a programme of its own",
            };
            self.contact.notes.push(format!(
                "the chamber is {strayed}, and not where it was sent: it was sent to {:.1} C again{by_another}",
                should.0
            ));
        }
        Ok(())
    }
}

impl Chamber for RemoteChamber {
    fn set(&mut self, set_point: Celsius) -> Result<(), InstrumentError> {
        self.is_under_way = true;
        // Whether it took it or not: one that was away is sent there, and not back.
        self.set_point = set_point;
        if !self.may_ask() {
            return Err(InstrumentError::Away(self.contact.what));
        }
        let done = self.controller.send(set_point);
        self.is_astray |= done.is_err();
        self.obeyed(&done);
        done.map_err(|fault| self.contact.error(fault))
    }

    fn take_astray(&mut self) -> Result<bool, InstrumentError> {
        self.look()?;
        Ok(std::mem::take(&mut self.is_astray))
    }

    fn set_point(&self) -> Celsius {
        self.set_point
    }

    fn air(&mut self) -> Result<Celsius, InstrumentError> {
        if let Some((air, asked, took)) = self.last
            && asked.elapsed() < took * SHARE_OF_TIME
        {
            return Ok(air);
        }
        let asked = Instant::now();
        let controller = &mut self.controller;
        let answer = self.contact.attempt(|| controller.actual());
        self.last = answer.as_ref().ok().map(|(air, _)| (*air, asked, asked.elapsed()));
        match answer {
            Ok((air, was_away)) => {
                self.is_owed |= was_away;
                self.remind()?;
                Ok(air)
            }
            Err(error) if error.may_pass() => Ok(Celsius(f64::NAN)),
            Err(error) => Err(error),
        }
    }

    fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.contact.notes)
    }

    fn rest(&mut self, once_more: OnceMore) -> Result<(), InstrumentError> {
        if self.is_under_way {
            let controller = &mut self.controller;
            self.contact.bring_to_rest(once_more, || controller.rest())?;
            self.is_under_way = false;
            self.set_point = self.controller.safe();
        }
        Ok(())
    }
}

impl Drop for RemoteChamber {
    fn drop(&mut self) {
        // Whoever ends in order has seen the error of `rest`.
        let _ = self.rest(&|_| false);
    }
}

/// A supply by remote control.
pub struct RemoteSupply {
    supply: PowerSupply,
    contact: Contact,
    /// Whether it may be on.
    is_on: bool,
}

impl RemoteSupply {
    /// A supply that was asked who it is; nothing is fed.
    ///
    /// # Errors
    /// [`RemoteError`].
    pub fn open(address: &Address, setup: &SetUp) -> Result<(Self, Found), RemoteError> {
        let table = setup.supply.clone().unwrap_or_default();
        let mut supply = PowerSupply::new(address, &table).map_err(RemoteError::SetUp)?;
        let contact = Contact::with("supply", address);
        let asked = (|| Ok((supply.identity()?, supply.is_on()?, supply.try_voltmeters()?)))();
        let (identity, is_on, ()) = asked.map_err(|fault| contact.error(fault))?;
        let on = if is_on { "; its output is on, and is switched off before the run begins" } else { "" };
        let told = format!("{} is {identity}{on}", contact.name);
        Ok((Self { supply, contact, is_on: false }, Found { told, label: format!("{address} ({identity})") }))
    }

    /// Makes ready what others have left: nothing is fed, and what it complained of before is none of this run's.
    ///
    /// # Errors
    /// [`InstrumentError`].
    pub fn make_ready(&mut self) -> Result<(), InstrumentError> {
        let supply = &mut self.supply;
        self.contact.attempt(|| supply.forget_errors().and_then(|()| supply.off())).map(drop)
    }
}

impl Supply for RemoteSupply {
    fn feed(&mut self, volts: Volts) -> Result<(), InstrumentError> {
        self.is_on = true;
        let supply = &mut self.supply;
        self.contact.attempt(|| supply.feed(volts)).map(drop)
    }

    fn connect_gyros(&mut self) -> Result<(), InstrumentError> {
        let supply = &mut self.supply;
        self.contact.attempt(|| supply.off())?;
        self.is_on = false;
        Ok(())
    }

    fn hold(&mut self) -> Result<(), InstrumentError> {
        let supply = &mut self.supply;
        self.contact.attempt(|| supply.hold()).map(drop)
    }

    fn gyro_output(&mut self, axis: Axis) -> Result<Volts, InstrumentError> {
        let supply = &mut self.supply;
        self.contact.attempt(|| supply.gyro_output(axis)).map(|(volts, _)| volts)
    }

    fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.contact.notes)
    }

    fn rest(&mut self, once_more: OnceMore) -> Result<(), InstrumentError> {
        if self.is_on {
            let supply = &mut self.supply;
            self.contact.bring_to_rest(once_more, || supply.off())?;
            self.is_on = false;
        }
        Ok(())
    }
}

impl Drop for RemoteSupply {
    fn drop(&mut self) {
        // As the chamber's.
        let _ = self.rest(&|_| false);
    }
}

/// The power of a board that nobody switches: every run begins with a board that was told to rest.
pub struct LeftOn;

impl Power for LeftOn {
    fn cycle(&mut self) -> Result<Cycled, InstrumentError> {
        Ok(Cycled::LeftOn)
    }
}
