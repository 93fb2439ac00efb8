//! A board and its plant in turns: the plant's time stands while the board works, but for bytes on the buses and for delays, and
//! a set comes when the board is idle. So nothing depends on how long a processor takes, and two boards see the same plant at
//! the same moment.

use anyhow::{Context, Result, ensure};
use zerorate_core::wire::Upload;
use zerorate_core::wire::frame::Receiver;
use zerorate_sim::{Plant, SharedPlant};

use crate::chip::board::Board;
use crate::chip::memory::Image;
use crate::chip::time::{MILLISECOND, SECOND, Ticks};
use crate::machine::Machine;

/// A group's time.
const GROUP: Ticks = 1500 * MILLISECOND;
/// Longer than any command, a commit among them.
const PATIENCE: Ticks = 10 * SECOND;

/// A board that a procedure works with.
pub trait LockStep {
    /// Its plant.
    fn plant(&self) -> SharedPlant;

    /// Sends a frame, and lets the board act on it.
    ///
    /// # Errors
    /// It does not come to an end.
    fn send(&mut self, frame: &[u8]) -> Result<()>;

    /// Lets a set become full, and the board act on it.
    ///
    /// # Errors
    /// None becomes full, or it does not come to an end.
    fn set(&mut self) -> Result<()>;

    /// Power goes, and comes again.
    ///
    /// # Errors
    /// The board does not start.
    fn power_cycle(&mut self) -> Result<()>;

    /// What it has said since this was last asked.
    fn said(&mut self) -> Vec<Upload>;
}

/// The chip in turns with its plant.
pub struct ChipBoard {
    machine: Machine,
    plant: SharedPlant,
    receiver: Receiver,
}

impl ChipBoard {
    /// A blank chip about a plant.
    ///
    /// # Errors
    /// It does not start.
    pub fn new(image: &Image, plant: Plant) -> Result<Self> {
        let plant = plant.share();
        let mut board = Board::new(&plant);
        board.plant_stands = true;
        let mut board = Self { machine: Machine::new(image, board)?, plant, receiver: Receiver::new() };
        board.until_idle()?;
        Ok(board)
    }

    fn until_idle(&mut self) -> Result<()> {
        let until = self.machine.chip().clock + PATIENCE;
        ensure!(self.machine.run(until, Machine::is_idle)?, "the chip does not come to rest");
        Ok(())
    }

    /// What the program did that the chip would not have taken.
    pub fn wrong(&mut self) -> &[String] {
        &self.machine.chip().wrong
    }
}

impl LockStep for ChipBoard {
    fn plant(&self) -> SharedPlant {
        SharedPlant::clone(&self.plant)
    }

    fn send(&mut self, frame: &[u8]) -> Result<()> {
        let chip = self.machine.chip();
        chip.usart.send(frame, chip.clock);
        self.until_idle()
    }

    fn set(&mut self) -> Result<()> {
        let full = self.machine.chip().clock + GROUP;
        self.machine.run_until(full)?;
        self.plant.borrow_mut().run_set().context("the chip's acquisition stands still")?;
        self.until_idle()
    }

    fn power_cycle(&mut self) -> Result<()> {
        self.plant.borrow_mut().power_cycle();
        self.receiver = Receiver::new();
        self.machine.power_on()?;
        self.until_idle()
    }

    fn said(&mut self) -> Vec<Upload> {
        let bytes = std::mem::take(&mut self.machine.chip().usart.heard);
        bytes.into_iter().filter_map(|byte| self.receiver.push::<Upload>(byte)?.ok()).collect()
    }
}
