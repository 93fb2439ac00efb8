//! The chip as a board that goes step by step with its plant: the plant's time stands while the processor works, but for bytes on
//! the buses and for delays, and sets and seconds come when it is idle. So nothing depends on how long a processor takes.

use anyhow::{Result, ensure};
use zerorate_bench::stepped::SteppedBoard;
use zerorate_sim::{Plant, SharedPlant};

use crate::chip::board::Board;
use crate::chip::memory::Image;
use crate::chip::time::{SECOND, Ticks};
use crate::machine::Machine;

/// Longer than any command, a commit among them.
const PATIENCE: Ticks = 10 * SECOND;

/// The timer's overflows in a second.
const OVERFLOWS: u32 = 50;

/// The chip in turns with its plant.
pub struct ChipBoard {
    machine: Machine,
    plant: SharedPlant,
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
        let mut board = Self { machine: Machine::new(image, board)?, plant };
        board.until_idle()?;
        Ok(board)
    }
}

impl SteppedBoard for ChipBoard {
    type Error = anyhow::Error;

    fn plant(&self) -> &SharedPlant {
        &self.plant
    }

    fn power_cycle(&mut self) -> Result<()> {
        self.plant.borrow_mut().power_cycle();
        self.machine.chip().usart.heard.clear();
        self.machine.power_on()?;
        self.until_idle()
    }

    fn send(&mut self, bytes: &[u8]) -> Result<()> {
        let chip = self.machine.chip();
        chip.usart.send(bytes, chip.clock);
        Ok(())
    }

    /// What the program did that the chip would not have taken ends it, too.
    fn until_idle(&mut self) -> Result<()> {
        let until = self.machine.chip().clock + PATIENCE;
        ensure!(self.machine.run(until, Machine::is_idle)?, "the chip does not come to rest");
        let wrong = &self.machine.chip().wrong;
        ensure!(wrong.is_empty(), "the program: {}", wrong.join("; "));
        Ok(())
    }

    fn until_heard(&mut self) -> Result<bool> {
        self.until_idle()?;
        Ok(!self.machine.chip().usart.heard.is_empty())
    }

    fn take_heard(&mut self, into: &mut Vec<u8>) {
        into.append(&mut self.machine.chip().usart.heard);
    }

    /// The chip sees the line itself.
    fn give_set(&mut self) -> Result<()> {
        self.until_idle()
    }

    /// The timer overflows so often in it.
    fn give_second(&mut self) -> Result<()> {
        for _ in 0..OVERFLOWS {
            self.machine.chip().timer.overflow();
            self.until_idle()?;
        }
        Ok(())
    }
}
