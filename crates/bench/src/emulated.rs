//! The simulated bench with an emulated board on it: the firmware as it is built for the target, in QEMU, its buses
//! reaching the plant in lock-step and the host's protocol on its UART0.

mod bus;
mod choice;
mod emulator;

use std::path::Path;

use zerorate_core::record::UnitSerial;
use zerorate_lockstep::{Board, SERIAL_BYTES, VERSION};
use zerorate_sim::{Plant, SharedPlant};

pub use choice::{FirmwareMissing, find_firmware};
pub use emulator::EmulatorError;

use crate::instruments::Bench;
use crate::setup::SetUp;
use crate::stepped::{self, SteppedBoard};
use bus::Buses;
use emulator::{Emulator, Event};

/// The emulated board and its buses.
struct EmulatedBoard {
    emulator: Emulator,
    buses: Buses,
}

impl EmulatedBoard {
    /// Waits for the board's next word, on either line, and answers it.
    fn step(&mut self) -> Result<(), EmulatorError> {
        match self.emulator.next()? {
            Event::Heard => Ok(()),
            Event::Asked => self.emulator.answer(&mut self.buses),
        }
    }
}

impl SteppedBoard for EmulatedBoard {
    type Error = EmulatorError;

    fn plant(&self) -> &SharedPlant {
        &self.buses.plant
    }

    fn power_cycle(&mut self) -> Result<(), EmulatorError> {
        // The board loses its power first: nothing of it may reach the plant afterwards.
        self.emulator.stop();
        self.buses.plant.borrow_mut().power_cycle();
        self.emulator.start()?;
        self.until_idle()
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), EmulatorError> {
        self.emulator.send(bytes)
    }

    fn until_idle(&mut self) -> Result<(), EmulatorError> {
        while !self.emulator.is_idle() {
            self.step()?;
        }
        Ok(())
    }

    fn until_heard(&mut self) -> Result<bool, EmulatorError> {
        while !self.emulator.has_heard() {
            if self.emulator.is_idle() && self.emulator.has_heard_all() {
                return Ok(false);
            }
            self.step()?;
        }
        Ok(true)
    }

    fn take_heard(&mut self, into: &mut Vec<u8>) {
        self.emulator.take_heard(into);
    }

    fn give_set(&mut self) -> Result<(), EmulatorError> {
        self.emulator.give_set()
    }

    fn give_second(&mut self) -> Result<(), EmulatorError> {
        self.emulator.give_second()
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
    let mut board = EmulatedBoard { emulator: Emulator::new(firmware)?, buses };
    board.until_idle()?;
    Ok(stepped::bench(board, setup))
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
