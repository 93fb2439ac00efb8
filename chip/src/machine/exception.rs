//! An exception's beginning and end (ARMv7-M, B1.5.6 to B1.5.8), on the main stack alone: the image has no other.
//!
//! The float registers are stacked at once where they are in use. The chip puts that off; a program sees no difference.

use anyhow::{Result, ensure};
use unicorn_engine::RegisterARM;

use super::Machine;

/// R0 to R3, R12, LR, the return address and the program's status.
const FRAME: u32 = 8 * 4;
/// Besides: S0 to S15, the float unit's status, and a word that keeps the stack even.
const FLOAT_FRAME: u32 = 18 * 4;
const SAVED: [RegisterARM; 6] =
    [RegisterARM::R0, RegisterARM::R1, RegisterARM::R2, RegisterARM::R3, RegisterARM::R12, RegisterARM::LR];
/// xPSR: the stack was moved by a word to be even, and Thumb.
const MOVED: u32 = 1 << 9;
const THUMB: u32 = 1 << 24;
/// N, Z, C, V, Q and GE.
const FLAGS: u32 = 0xF80F_0000;

impl Machine {
    /// Takes an exception between two instructions.
    pub(super) fn enter(&mut self, exception: u32) -> Result<()> {
        let (stack, at) = (self.get(RegisterARM::SP)?, self.get(RegisterARM::PC)?);
        let interrupted = self.chip().nvic.current();
        let flags = self.get(RegisterARM::XPSR)? & FLAGS;
        let size = if self.float_used { FRAME + FLOAT_FRAME } else { FRAME };
        let moved = if stack & 4 == 0 { 0 } else { MOVED };
        let frame = (stack - size) & !7;
        // Nowhere to put it: the same holds for the fault that this is, and the core locks up.
        if self.word(frame).is_err() {
            (self.asleep, self.hung) = (true, true);
            return Ok(());
        }
        for (place, register) in (0..).zip(SAVED) {
            let word = self.get(register)?;
            self.set_word(frame + 4 * place, word)?;
        }
        self.set_word(frame + 24, at)?;
        self.set_word(frame + 28, flags | THUMB | moved | interrupted)?;
        let mut returns = if interrupted == 0 { 0xFFFF_FFF9 } else { 0xFFFF_FFF1 };
        if self.float_used {
            for (place, word) in (0..).zip(self.float).take(16) {
                self.set_word(frame + FRAME + 4 * place, word)?;
            }
            returns &= !0x10;
            self.float_used = false;
        }
        let vector = self.chip().system.vectors() + 4 * exception;
        let handler = self.word(vector)?;
        self.chip().nvic.enter(exception);
        self.set(RegisterARM::SP, frame)?;
        self.set(RegisterARM::LR, returns)?;
        let chip = self.chip();
        chip.clock += 12 * chip.instruction;
        self.set(RegisterARM::PC, handler | 1)
    }

    /// Returns from one: the program counter stands at an EXC_RETURN.
    pub(super) fn leave(&mut self, returns: u32) -> Result<()> {
        let frame = self.get(RegisterARM::SP)?;
        for (place, register) in (0..).zip(SAVED) {
            let word = self.word(frame + 4 * place)?;
            self.set(register, word)?;
        }
        let (at, status) = (self.word(frame + 24)?, self.word(frame + 28)?);
        let with_float = returns & 0x10 == 0;
        if with_float {
            for (place, index) in (0..).zip(0..16) {
                self.float[index] = self.word(frame + FRAME + 4 * place)?;
            }
        }
        self.float_used = with_float;
        let size = if with_float { FRAME + FLOAT_FRAME } else { FRAME };
        let moved = if status & MOVED == 0 { 0 } else { 4 };
        self.chip().nvic.leave();
        ensure!(status & 0x1FF == self.chip().nvic.current(), "a return to an exception that was not interrupted");
        self.set(RegisterARM::SP, frame + size + moved)?;
        self.set(RegisterARM::XPSR, status & FLAGS | THUMB)?;
        let chip = self.chip();
        chip.clock += 12 * chip.instruction;
        self.set(RegisterARM::PC, at | 1)
    }
}
