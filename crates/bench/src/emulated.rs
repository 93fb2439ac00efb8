//! The simulated bench with an emulated board on it: the firmware as it is built for the target, in QEMU, its buses
//! reaching the plant in lock-step and the host's protocol on its UART0.
//!
//! As on the native device, time passes only while the host waits: a set is given to the board when it has acted on all
//! that the host has sent and has nothing more to say. So both see the same plant at the same moment, and a run with
//! either gives the same bits.

mod bus;
mod choice;
mod emulator;

use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;

use zerorate_core::record::UnitSerial;
use zerorate_core::units::{Axis, Seconds, Taps};
use zerorate_lockstep::{Board, SERIAL_BYTES, VERSION};
use zerorate_sim::{Plant, SharedPlant, Truth};

pub use choice::{FirmwareMissing, find_firmware};
pub use emulator::EmulatorError;

use crate::client::DeviceClient;
use crate::instruments::{Bench, InstrumentError, Surroundings, Witness};
use crate::link::{Link, LinkError, MOST_UNHEARD};
use crate::setup::SetUp;
use crate::simulated::{SimulatedChamber, SimulatedSupply};
use crate::tick::Tick;
use bus::Buses;
use emulator::{Emulator, Event};

/// The emulated board, and the bytes on their way to the host.
struct EmulatedDevice {
    emulator: Emulator,
    buses: Buses,
    truths: Vec<Truth>,
    tick: Tick,
    group_period: Seconds,
}

impl EmulatedDevice {
    fn power_cycle(&mut self) -> Result<(), EmulatorError> {
        // The board loses its power first: nothing of it may reach the plant afterwards.
        self.emulator.stop();
        self.buses.plant.borrow_mut().power_cycle();
        self.emulator.start()?;
        self.until_idle()
    }

    /// Lets the board run until it has acted on all that it was sent.
    fn until_idle(&mut self) -> Result<(), EmulatorError> {
        while !self.emulator.is_idle() {
            self.step()?;
        }
        Ok(())
    }

    /// Lets the board run until it says something.
    fn until_heard(&mut self) -> Result<(), LinkError> {
        let mut unheard = 0;
        while !self.emulator.has_heard() {
            if self.emulator.is_idle() && self.emulator.has_heard_all() {
                if unheard == MOST_UNHEARD {
                    return Err(LinkError::Silent);
                }
                unheard += 1;
                self.pass_time()?;
            } else {
                self.step()?;
            }
        }
        Ok(())
    }

    /// Gives the waiting board a tick that is due, or lets the plant run until a set is full.
    fn pass_time(&mut self) -> Result<(), LinkError> {
        let plant = &self.buses.plant;
        if self.tick.is_due(plant.borrow().time()) {
            return Ok(self.emulator.give_second()?);
        }
        let was_ready = plant.borrow().data_ready();
        let Some(truth) = plant.borrow_mut().run_set() else {
            plant.borrow_mut().wait(self.group_period);
            return Err(LinkError::Silent);
        };
        self.truths.push(truth);
        // Where a set still waits the line does not rise.
        if !was_ready {
            self.emulator.give_set()?;
        }
        Ok(())
    }

    /// Waits for the board's next word, on either line, and answers it.
    fn step(&mut self) -> Result<(), EmulatorError> {
        match self.emulator.next()? {
            Event::Heard => Ok(()),
            Event::Asked => self.emulator.answer(&mut self.buses),
        }
    }
}

/// The line to an emulated device.
struct EmulatedLink(Rc<RefCell<EmulatedDevice>>);

impl Link for EmulatedLink {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        let mut device = self.0.borrow_mut();
        device.emulator.send(bytes)?;
        Ok(device.until_idle()?)
    }

    fn receive(&mut self, into: &mut Vec<u8>) -> Result<(), LinkError> {
        let mut device = self.0.borrow_mut();
        device.until_heard()?;
        device.emulator.take_heard(into);
        Ok(())
    }
}

struct EmulatedSurroundings(Rc<RefCell<EmulatedDevice>>);

impl Surroundings for EmulatedSurroundings {
    fn power_cycle(&mut self) -> Result<(), InstrumentError> {
        self.0.borrow_mut().power_cycle().map_err(|error| InstrumentError::Power(error.to_string()))
    }

    fn wait(&mut self, time: Seconds) -> Result<(), InstrumentError> {
        let mut device = self.0.borrow_mut();
        device.buses.plant.borrow_mut().wait(time);
        // As on the native device the ticks of a time that nobody looks at are left out.
        let now = device.buses.plant.borrow().time();
        device.tick = Tick::after(now, device.group_period);
        Ok(())
    }
}

struct EmulatedWitness(Rc<RefCell<EmulatedDevice>>);

impl Witness for EmulatedWitness {
    fn take(&mut self) -> Vec<Truth> {
        core::mem::take(&mut self.0.borrow_mut().truths)
    }

    fn tap_counts(&self, axis: Axis, tap: Taps) -> f64 {
        self.0.borrow().buses.plant.borrow().true_tap_counts(axis, tap)
    }
}

/// The simulated bench about a plant, its device the firmware `firmware` (an ELF for mps2-an386) in QEMU.
///
/// # Errors
/// [`EmulatorError`], when QEMU cannot be started or the firmware does not come up in it.
pub fn bench(plant: Plant, setup: &SetUp, unit: &UnitSerial, firmware: &Path) -> Result<Bench, EmulatorError> {
    let mut plant = plant;
    plant.scan_every(setup.acquisition.sample_period_us);
    let plant: SharedPlant = plant.share();
    let buses = Buses::new(&plant, board(setup, unit));
    let emulator = Emulator::new(firmware)?;
    let group_period = setup.group_period();
    let tick = Tick::after(plant.borrow().time(), group_period);
    let mut device = EmulatedDevice { emulator, buses, truths: Vec::new(), tick, group_period };
    device.until_idle()?;
    let device = Rc::new(RefCell::new(device));
    Ok(Bench {
        device: DeviceClient::new(Box::new(EmulatedLink(Rc::clone(&device)))),
        chamber: Box::new(SimulatedChamber::new(&plant)),
        supply: Box::new(SimulatedSupply(plant)),
        surroundings: Box::new(EmulatedSurroundings(Rc::clone(&device))),
        witness: Some(Box::new(EmulatedWitness(device))),
    })
}

/// What the board is told of itself.
fn board(setup: &SetUp, unit: &UnitSerial) -> Board {
    let mut serial = [0; SERIAL_BYTES];
    serial[..unit.len()].copy_from_slice(unit.as_bytes());
    let acquisition = &setup.acquisition;
    Board {
        version: VERSION,
        set_length: acquisition.group_length,
        scan_period_us: acquisition.sample_period_us,
        oversampling: acquisition.oversampling,
        serial,
    }
}
