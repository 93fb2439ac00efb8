//! Runs the core from alarm to alarm.

use anyhow::{Context, Result, bail};
use unicorn_engine::unicorn_const::uc_error;
use unicorn_engine::{RegisterARM, Unicorn};

use super::{Ambush, Core, Machine, Special};
use crate::chip::float;
use crate::chip::memory;
use crate::chip::nvic::Masks;
use crate::chip::system::Fault;
use crate::chip::time::Ticks;

/// Where an EXC_RETURN begins.
const RETURNS: u64 = 0xFFFF_FFE0;
/// Nothing is there.
pub const NOTHING: u32 = 0xBAD0_0000;
/// No program ends here.
const NOWHERE: u64 = memory::RETURN_PAGE as u64;

/// Called before every instruction: counts it, or stops before it.
pub(super) fn count(unicorn: &mut Unicorn<'_, Core>, address: u64, _: u32) {
    let core = unicorn.get_data_mut();
    core.at = super::low(address);
    let index = address.wrapping_sub(memory::FLASH.into()) / 2;
    let special = usize::try_from(index).ok().and_then(|index| core.special.get(index)).copied();
    let stops = core.chip.clock >= core.chip.alarm
        || special != Some(Special::None)
        || core.ambush.is_some_and(|(at, _)| u64::from(at) == address);
    if stops || core.masked && is_unmasked(unicorn) {
        // It may be asked for in vain in an IT block: then it comes after the block.
        let _ = unicorn.emu_stop();
        return;
    }
    let chip = &mut unicorn.get_data_mut().chip;
    chip.clock += chip.instruction;
}

fn masks(unicorn: &Unicorn<'_, Core>) -> Masks {
    let read = |register| unicorn.reg_read(register).unwrap_or(0);
    Masks { primask: read(RegisterARM::PRIMASK) & 1 == 1, basepri: (read(RegisterARM::BASEPRI) & 0xFF) as u8 }
}

fn is_unmasked(unicorn: &Unicorn<'_, Core>) -> bool {
    unicorn.get_data().chip.nvic.next(masks(unicorn)).is_some()
}

impl Machine {
    /// Runs up to an instant.
    ///
    /// # Errors
    /// The program did what cannot be gone on from.
    pub fn run_until(&mut self, until: Ticks) -> Result<()> {
        self.run(until, |_| false).map(drop)
    }

    /// Runs until something holds, looked at whenever the core is looked after; `false` if it did not up to an instant.
    ///
    /// # Errors
    /// The program did what cannot be gone on from.
    pub fn run(&mut self, until: Ticks, mut holds: impl FnMut(&mut Self) -> bool) -> Result<bool> {
        loop {
            if let Some(reset) = self.chip().settle() {
                self.reset(reset)?;
                continue;
            }
            if holds(self) {
                return Ok(true);
            }
            if self.chip().clock >= until {
                return Ok(false);
            }
            let masks = masks(&self.unicorn);
            if let Some(exception) = self.chip().nvic.next(masks).filter(|_| !self.hung) {
                self.asleep = false;
                self.enter(exception)?;
            }
            let core = self.unicorn.get_data_mut();
            core.masked = core.chip.nvic.waits();
            core.chip.alarm = core.chip.due().min(until);
            if self.asleep {
                core.chip.clock = core.chip.clock.max(core.chip.alarm);
                continue;
            }
            let from = self.get(RegisterARM::PC)?;
            let ended = self.unicorn.emu_start(u64::from(from) | 1, NOWHERE, 0, 0);
            self.stopped(ended)?;
        }
    }

    /// What the core stopped at.
    fn stopped(&mut self, ended: Result<(), uc_error>) -> Result<()> {
        let at = self.get(RegisterARM::PC)?;
        // No program can run there: Unicorn says so, or is stopped before it.
        if u64::from(at) >= RETURNS {
            return self.leave(at);
        }
        if let Err(error) = ended {
            // Of the program: the handlers of single kinds are off. The instruction is not done.
            let core = self.unicorn.get_data_mut();
            let (at, refused) = (core.at, core.refused.take());
            self.set(RegisterARM::PC, at | 1)?;
            let fetched = matches!(error, uc_error::FETCH_UNMAPPED | uc_error::FETCH_PROT);
            let kind = match refused {
                Some(_) if !fetched => Fault::Data,
                _ if fetched => Fault::Fetch,
                _ => Fault::Instruction,
            };
            self.fault(at, kind, refused.filter(|_| kind == Fault::Data));
            return Ok(());
        }
        if let Some((_, ambush)) = self.unicorn.get_data().ambush.filter(|&(address, _)| address == at) {
            self.unicorn.get_data_mut().ambush = None;
            return self.fall_into(ambush);
        }
        let index = at.wrapping_sub(memory::FLASH) as usize / 2;
        let special = self.unicorn.get_data().special.get(index).copied();
        // An alarm came first: it is seen to, and then this instruction.
        if self.chip().alarm <= self.chip().clock {
            return Ok(());
        }
        match special {
            Some(Special::Wait) => {
                self.asleep = true;
                self.pass_over(at, 2)
            }
            Some(Special::Spin) => {
                self.asleep = true;
                Ok(())
            }
            Some(Special::Float) => self.move_floats(at),
            Some(Special::None) => Ok(()),
            None => bail!("the program counter is at {at:#010x}, where there is no program"),
        }
    }

    fn fall_into(&mut self, ambush: Ambush) -> Result<()> {
        match ambush {
            Ambush::HardFault => {
                self.expects_fault = true;
                self.set(RegisterARM::R0, NOTHING)?;
                self.set(RegisterARM::PC, self.image.load | 1)?;
            }
            Ambush::Panic => self.set(RegisterARM::PC, self.image.panic.code | 1)?,
            Ambush::Hang => (self.asleep, self.hung) = (true, true),
        }
        Ok(())
    }

    fn pass_over(&mut self, at: u32, bytes: u32) -> Result<()> {
        let chip = self.chip();
        chip.clock += chip.instruction;
        self.set(RegisterARM::PC, (at + bytes) | 1)
    }

    /// A load or store of float registers.
    fn move_floats(&mut self, at: u32) -> Result<()> {
        let word = self.word(at)?;
        let (high, low) = ((word & 0xFFFF) as u16, (word >> 16) as u16);
        let transfer = float::decode(high, low)
            .with_context(|| format!("{high:04x} {low:04x} at {at:#010x}: a float instruction that is not modelled"))?;
        if !self.chip().system.has_float() {
            self.fault(at, Fault::Instruction, None);
            return Ok(());
        }
        self.float_used = true;
        let base = core_register(transfer.base)?;
        // A literal's address counts from the next word.
        let address = if transfer.base == 15 { (at + 4) & !3 } else { self.get(base)? };
        let begin = address.wrapping_add_signed(transfer.offset);
        for index in 0..transfer.count {
            let place = begin + 4 * u32::try_from(index)?;
            if transfer.load {
                self.float[transfer.first + index] = self.word(place)?;
            } else {
                self.set_word(place, self.float[transfer.first + index])?;
            }
        }
        if transfer.write_back != 0 {
            self.set(base, address.wrapping_add_signed(transfer.write_back))?;
        }
        self.pass_over(at, 4)
    }
}

fn core_register(number: u32) -> Result<RegisterARM> {
    const REGISTERS: [RegisterARM; 16] = [
        RegisterARM::R0,
        RegisterARM::R1,
        RegisterARM::R2,
        RegisterARM::R3,
        RegisterARM::R4,
        RegisterARM::R5,
        RegisterARM::R6,
        RegisterARM::R7,
        RegisterARM::R8,
        RegisterARM::R9,
        RegisterARM::R10,
        RegisterARM::R11,
        RegisterARM::R12,
        RegisterARM::SP,
        RegisterARM::LR,
        RegisterARM::PC,
    ];
    REGISTERS.get(number as usize).copied().context("no register of the core")
}
