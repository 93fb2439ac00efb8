//! The simulated bench with a board on it that goes step by step with its plant: an emulator's, down to the processor.
//!
//! As on the native device, time passes only while the host waits, and for what takes time on a bus or in a delay: a set or a
//! second is given to the board when it has acted on all that the host has sent and has nothing more to say. So all see the same
//! plant at the same moment, and a run with any of them gives the same bits.

use std::cell::RefCell;
use std::error::Error;
use std::fmt::Display;
use std::io;
use std::rc::Rc;

use zerorate_core::units::{Axis, Seconds, Taps};
use zerorate_sim::{SharedPlant, Truth};

use crate::client::DeviceClient;
use crate::instruments::{Bench, Clock, Cycled, InstrumentError, Power, Witness};
use crate::link::{Link, LinkError, MOST_UNHEARD};
use crate::setup::SetUp;
use crate::simulated::{SimulatedChamber, SimulatedSupply};
use crate::tick::Tick;

/// A board that goes step by step with its plant.
pub trait SteppedBoard {
    /// Why it does not go on.
    type Error: Display + Into<Box<dyn Error + Send + Sync>>;

    /// What it stands on.
    fn plant(&self) -> &SharedPlant;

    /// Its power goes, with the plant's, and comes again.
    ///
    /// # Errors
    /// It does not start.
    fn power_cycle(&mut self) -> Result<(), Self::Error>;

    /// Puts the host's bytes on its line.
    ///
    /// # Errors
    /// The line is gone.
    fn send(&mut self, bytes: &[u8]) -> Result<(), Self::Error>;

    /// Lets it run until it has acted on all that it was sent.
    ///
    /// # Errors
    /// It does not come to an end.
    fn until_idle(&mut self) -> Result<(), Self::Error>;

    /// Lets it run until it has said something; `false` if it rests and has nothing to say.
    ///
    /// # Errors
    /// It does not come to an end.
    fn until_heard(&mut self) -> Result<bool, Self::Error>;

    /// Hands out what it has said.
    fn take_heard(&mut self, into: &mut Vec<u8>);

    /// Tells it, as it rests, that data ready has risen.
    ///
    /// # Errors
    /// It does not answer.
    fn give_set(&mut self) -> Result<(), Self::Error>;

    /// Tells it, as it rests, that a second has gone by.
    ///
    /// # Errors
    /// It does not answer.
    fn give_second(&mut self) -> Result<(), Self::Error>;
}

fn gone(error: impl Into<Box<dyn Error + Send + Sync>>) -> LinkError {
    LinkError::Gone(io::Error::other(error))
}

/// A board, its seconds, and what its plant knows of its sets.
struct Stepped<B> {
    board: B,
    truths: Vec<Truth>,
    tick: Tick,
    group_period: Seconds,
}

impl<B: SteppedBoard> Stepped<B> {
    fn until_heard(&mut self) -> Result<(), LinkError> {
        let mut unheard = 0;
        while !self.board.until_heard().map_err(gone)? {
            if unheard == MOST_UNHEARD {
                return Err(LinkError::Silent);
            }
            unheard += 1;
            self.pass_time()?;
        }
        Ok(())
    }

    /// Gives the waiting board a tick that is due, or lets the plant run until a set is full.
    fn pass_time(&mut self) -> Result<(), LinkError> {
        let plant = self.board.plant();
        if self.tick.is_due(plant.borrow().time()) {
            return self.board.give_second().map_err(gone);
        }
        let was_ready = plant.borrow().data_ready();
        let Some(truth) = plant.borrow_mut().run_set() else {
            plant.borrow_mut().wait(self.group_period);
            return Err(LinkError::Silent);
        };
        self.truths.push(truth);
        // Where a set still waits the line does not rise.
        if was_ready { Ok(()) } else { self.board.give_set().map_err(gone) }
    }
}

/// The line to it.
struct SteppedLink<B>(Rc<RefCell<Stepped<B>>>);

impl<B: SteppedBoard> Link for SteppedLink<B> {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        let board = &mut self.0.borrow_mut().board;
        board.send(bytes).and_then(|()| board.until_idle()).map_err(gone)
    }

    fn receive(&mut self, into: &mut Vec<u8>) -> Result<(), LinkError> {
        let mut stepped = self.0.borrow_mut();
        stepped.until_heard()?;
        stepped.board.take_heard(into);
        Ok(())
    }
}

struct SteppedPower<B>(Rc<RefCell<Stepped<B>>>);

impl<B: SteppedBoard> Power for SteppedPower<B> {
    fn cycle(&mut self) -> Result<Cycled, InstrumentError> {
        let board = &mut self.0.borrow_mut().board;
        board.power_cycle().map(|()| Cycled::Done).map_err(|error| InstrumentError::Power(error.to_string()))
    }
}

struct SteppedClock<B>(Rc<RefCell<Stepped<B>>>);

impl<B: SteppedBoard> Clock for SteppedClock<B> {
    fn wait(&mut self, time: Seconds) -> Result<(), InstrumentError> {
        let mut stepped = self.0.borrow_mut();
        stepped.board.plant().borrow_mut().wait(time);
        // As on the native device the ticks of a time that nobody looks at are left out.
        let now = stepped.board.plant().borrow().time();
        stepped.tick = Tick::after(now, stepped.group_period);
        Ok(())
    }
}

struct SteppedWitness<B>(Rc<RefCell<Stepped<B>>>);

impl<B: SteppedBoard> Witness for SteppedWitness<B> {
    fn take(&mut self) -> Vec<Truth> {
        core::mem::take(&mut self.0.borrow_mut().truths)
    }

    fn tap_counts(&self, axis: Axis, tap: Taps) -> f64 {
        self.0.borrow().board.plant().borrow().true_tap_counts(axis, tap)
    }
}

/// The simulated bench with a board on it that has started.
#[must_use]
pub fn bench<B: SteppedBoard + 'static>(board: B, setup: &SetUp) -> Bench {
    let plant = Rc::clone(board.plant());
    let group_period = setup.group_period();
    let tick = Tick::after(plant.borrow().time(), group_period);
    let stepped = Rc::new(RefCell::new(Stepped { board, truths: Vec::new(), tick, group_period }));
    Bench {
        device: DeviceClient::new(Box::new(SteppedLink(Rc::clone(&stepped)))),
        chamber: Box::new(SimulatedChamber::new(&plant)),
        supply: Box::new(SimulatedSupply(plant)),
        power: Box::new(SteppedPower(Rc::clone(&stepped))),
        clock: Some(Box::new(SteppedClock(Rc::clone(&stepped)))),
        witness: Some(Box::new(SteppedWitness(stepped))),
    }
}
