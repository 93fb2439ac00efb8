//! The core: Unicorn's Cortex-M4 running the image, and what Unicorn leaves out: exceptions, sleep, resets.
//!
//! Time goes by instructions, a cycle each. The core runs until the chip's next alarm; what happens then happens between two
//! instructions. While it sleeps, or asks a flag again and again, time goes to the next alarm at once.

mod exception;
pub mod run;

use anyhow::{Result, anyhow};
use unicorn_engine::unicorn_const::{Arch, HookType, Mode, Prot, uc_error};
use unicorn_engine::{ArmCpuModel, RegisterARM, Unicorn};

use crate::chip::board::Board;
use crate::chip::memory::{self, Image};
use crate::chip::rcc::Reset;
use crate::chip::system::Fault;
use crate::chip::{Chip, flash, float};

/// Instructions that are done here, not by Unicorn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Special {
    None,
    /// WFI.
    Wait,
    /// A branch to itself: only an interrupt leads on.
    Spin,
    Float,
}

/// What happens to the program when it comes to an address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ambush {
    /// It loads from where nothing is: a hard fault.
    HardFault,
    /// It finds an index out of bounds: a panic.
    Panic,
    /// It goes round in a circle, where it is.
    Hang,
}

/// What Unicorn's hooks work with.
struct Core {
    chip: Chip,
    /// For every halfword of the program's flash.
    special: Vec<Special>,
    /// Something is pending that is masked: the masks are looked at with every instruction.
    masked: bool,
    /// Where the program is thrown off its way.
    ambush: Option<(u32, Ambush)>,
    /// The instruction that is being done.
    at: u32,
    /// An address that did not answer.
    refused: Option<u32>,
}

/// A chip with its image on a board.
pub struct Machine {
    unicorn: Unicorn<'static, Core>,
    image: Image,
    asleep: bool,
    /// Asleep, and no interrupt wakes it.
    hung: bool,
    float: [u32; 32],
    /// CONTROL.FPCA: float registers are in use.
    float_used: bool,
    /// Resets since power came to the bench, the latest last.
    pub resets: Vec<Reset>,
    /// The instructions that ended in a hard fault, and the addresses that did not answer.
    pub hard_faults: Vec<(u32, Option<u32>)>,
    /// A fault that is not the program's own is to come.
    expects_fault: bool,
}

/// The board's supply.
const NOMINAL_V: f64 = 3.3;

/// What Unicorn says, as an error.
fn said(error: uc_error) -> anyhow::Error {
    anyhow!("Unicorn: {error:?}")
}

impl Machine {
    /// A chip without power.
    ///
    /// # Errors
    /// When Unicorn cannot be set up.
    pub fn new(image: &Image, board: Board) -> Result<Self> {
        let core = Core {
            chip: Chip::new(board),
            special: specials(&image.flash),
            masked: false,
            ambush: None,
            at: 0,
            refused: None,
        };
        let mut unicorn = Unicorn::new_with_data(Arch::ARM, Mode::THUMB | Mode::MCLASS, core).map_err(said)?;
        unicorn.ctl_set_cpu_model(ArmCpuModel::CORTEX_M4 as i32).map_err(said)?;
        map(&mut unicorn, image).map_err(said)?;
        let mut machine = Self {
            unicorn,
            image: image.clone(),
            asleep: false,
            hung: false,
            float: [0; 32],
            float_used: false,
            resets: Vec::new(),
            hard_faults: Vec::new(),
            expects_fault: false,
        };
        machine.power_on()?;
        Ok(machine)
    }

    /// The chip about the core.
    pub fn chip(&mut self) -> &mut Chip {
        &mut self.unicorn.get_data_mut().chip
    }

    /// Whether the program sleeps, nothing waits to be served, and nothing is on the line.
    pub fn is_idle(&mut self) -> bool {
        self.asleep && self.chip().usart.is_quiet() && !self.chip().nvic.waits()
    }

    /// Power comes: memory holds anything.
    ///
    /// # Errors
    /// What Unicorn says.
    pub fn power_on(&mut self) -> Result<()> {
        let mut state = 0x2545_F491_4F6C_DD1D_u64;
        let mut junk = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            state.to_le_bytes()
        };
        for (address, bytes) in [(memory::RAM, memory::RAM_BYTES), (memory::COUPLED, memory::COUPLED_BYTES)] {
            let ram: Vec<u8> = (0..bytes / 8).flat_map(|_| junk()).collect();
            self.unicorn.mem_write(address.into(), &ram).map_err(said)?;
        }
        self.reset(Reset::Power)
    }

    /// The core begins at its reset vector; memory stays as it is.
    ///
    /// # Errors
    /// What Unicorn says.
    pub fn reset(&mut self, reset: Reset) -> Result<()> {
        self.resets.push(reset);
        self.chip().reset(reset);
        (self.asleep, self.hung, self.float_used) = (false, false, false);
        let stack = self.word(memory::FLASH)?;
        let begin = self.word(memory::FLASH + 4)?;
        self.set(RegisterARM::PRIMASK, 0)?;
        self.set(RegisterARM::BASEPRI, 0)?;
        self.set(RegisterARM::CONTROL, 0)?;
        self.set(RegisterARM::SP, stack)?;
        self.set(RegisterARM::LR, u32::MAX)?;
        self.set(RegisterARM::PC, begin | 1)
    }

    /// The supply dips to so many volts, and comes back.
    ///
    /// # Errors
    /// What Unicorn says.
    pub fn dip(&mut self, volts: f64) -> Result<()> {
        match self.chip().supply(volts) {
            Some(Reset::Power) => self.power_on()?,
            Some(reset) => self.reset(reset)?,
            None => {}
        }
        // It may have been low enough to reset, and is not now.
        let _ = self.chip().supply(NOMINAL_V);
        Ok(())
    }

    /// A fault that no handler of its own takes.
    fn fault(&mut self, at: u32, kind: Fault, address: Option<u32>) {
        self.hard_faults.push((at, address));
        if !std::mem::take(&mut self.expects_fault) {
            self.chip().wrong.push(format!("{kind:?} fault at {at:#010x}"));
        }
        let chip = self.chip();
        chip.system.fault(kind, address);
        chip.nvic.fault();
    }

    /// Throws the program off its way the next time that it begins to serve an interrupt.
    ///
    /// # Errors
    /// There is no such interrupt.
    pub fn ambush(&mut self, interrupt: usize, ambush: Ambush) -> Result<()> {
        let vector = memory::FLASH + 4 * (16 + u32::try_from(interrupt)?);
        let address = self.word(vector)? & !1;
        self.ambush_at(address, ambush);
        Ok(())
    }

    /// The same, when it comes to an address.
    pub fn ambush_at(&mut self, address: u32, ambush: Ambush) {
        self.unicorn.get_data_mut().ambush = Some((address, ambush));
    }

    fn get(&self, register: RegisterARM) -> Result<u32> {
        let word = self.unicorn.reg_read(register).map_err(said)?;
        Ok(u32::try_from(word & u64::from(u32::MAX))?)
    }

    fn set(&mut self, register: RegisterARM, word: u32) -> Result<()> {
        self.unicorn.reg_write(register, word.into()).map_err(said)
    }

    /// The bytes that wait for a probe, taken as it takes them: from where it was to where the program is, in the first channel of
    /// RTT's block.
    ///
    /// # Errors
    /// They do not lie in memory.
    pub fn probed(&mut self) -> Result<Vec<u8>> {
        const UP: u32 = 24;
        const READ: u32 = UP + 16;
        let block = self.image.probe;
        let [place, size, write] = [4, 8, 12].map(|offset| self.word(block + UP + offset));
        let (place, size, write, read) = (place?, size?, write?, self.word(block + READ)?);
        let mut bytes = self.bytes(place, size as usize)?;
        bytes.rotate_left(read as usize);
        bytes.truncate((write + size - read).checked_rem(size).unwrap_or(0) as usize);
        self.set_word(block + READ, write)?;
        Ok(bytes)
    }

    /// Leaves the program no place on its stack.
    ///
    /// # Errors
    /// What Unicorn says.
    pub fn end_the_stack(&mut self) -> Result<()> {
        self.set(RegisterARM::SP, memory::COUPLED + 8)
    }

    /// What memory holds.
    ///
    /// # Errors
    /// There is none.
    pub fn bytes(&self, address: u32, length: usize) -> Result<Vec<u8>> {
        let mut bytes = vec![0; length];
        self.unicorn.mem_read(address.into(), &mut bytes).map_err(said)?;
        Ok(bytes)
    }

    /// A word of memory.
    ///
    /// # Errors
    /// There is none.
    pub fn word(&self, address: u32) -> Result<u32> {
        let mut bytes = [0; 4];
        self.unicorn.mem_read(address.into(), &mut bytes).map_err(said)?;
        Ok(u32::from_le_bytes(bytes))
    }

    fn set_word(&mut self, address: u32, word: u32) -> Result<()> {
        self.unicorn.mem_write(address.into(), &word.to_le_bytes()).map_err(said)
    }
}

/// Which halfwords, executed, are instructions that are done here.
fn specials(flash: &[u8]) -> Vec<Special> {
    const WFI: u16 = 0xBF30;
    const BRANCH_TO_ITSELF: u16 = 0xE7FE;
    let halfword = |index: usize| {
        let bytes = flash.get(2 * index..2 * index + 2).unwrap_or(&[0, 0]);
        u16::from_le_bytes([bytes[0], bytes[1]])
    };
    let special = |index| match halfword(index) {
        WFI => Special::Wait,
        BRANCH_TO_ITSELF => Special::Spin,
        high if float::may_be(high, halfword(index + 1)) => Special::Float,
        _ => Special::None,
    };
    (0..flash.len() / 2).map(special).collect()
}

/// Maps memory and registers, and the hook that counts.
fn map(unicorn: &mut Unicorn<'static, Core>, image: &Image) -> Result<(), uc_error> {
    let ram = Prot::READ | Prot::WRITE;
    let records = (flash::RECORDS - memory::FLASH) as usize;
    for (begin, end) in [(0, records), (records + flash::RECORD_BYTES, memory::FLASH_BYTES)] {
        let address = u64::from(memory::FLASH) + begin as u64;
        unicorn.mem_map(address, (end - begin) as u64, Prot::READ | Prot::EXEC)?;
        unicorn.mem_write(address, &image.flash[begin..end])?;
    }
    unicorn.mem_map(memory::RAM.into(), memory::RAM_BYTES as u64, ram)?;
    unicorn.mem_map(memory::COUPLED.into(), memory::COUPLED_BYTES as u64, ram)?;
    unicorn.mem_map(memory::SIGNATURE.into(), 0x1000, Prot::READ)?;
    unicorn.mem_write(memory::FLASH_SIZE.into(), &memory::FLASH_KIB.to_le_bytes())?;
    unicorn.mem_map(memory::RETURN_PAGE.into(), 0x1000, Prot::READ | Prot::EXEC)?;

    unicorn.mmio_map(
        flash::RECORDS.into(),
        flash::RECORD_BYTES as u64,
        Some(|unicorn: &mut Unicorn<'_, Core>, offset, size| unicorn.get_data_mut().chip.flash.load(offset, size)),
        Some(|unicorn: &mut Unicorn<'_, Core>, offset, size, word| {
            let chip = &mut unicorn.get_data_mut().chip;
            chip.clock += chip.flash.store(offset, size, word);
            chip.alarm = 0;
        }),
    )?;
    unicorn.mmio_map(
        memory::PERIPHERALS.into(),
        memory::PERIPHERAL_BYTES.into(),
        Some(|unicorn: &mut Unicorn<'_, Core>, offset, _| {
            let address = memory::PERIPHERALS + low(offset);
            u64::from(unicorn.get_data_mut().chip.load(address & !3) >> (8 * (address & 3)))
        }),
        Some(|unicorn: &mut Unicorn<'_, Core>, offset, _, word| {
            unicorn.get_data_mut().chip.store(memory::PERIPHERALS + low(offset), low(word));
        }),
    )?;
    // Each word of the alias is a bit.
    unicorn.mmio_map(
        memory::BITS.into(),
        memory::BITS_BYTES.into(),
        Some(|unicorn: &mut Unicorn<'_, Core>, offset, _| {
            let (address, place) = bit_of(low(offset));
            u64::from(unicorn.get_data_mut().chip.load(address) >> place & 1)
        }),
        Some(|unicorn: &mut Unicorn<'_, Core>, offset, _, word| {
            let (address, place) = bit_of(low(offset));
            let chip = &mut unicorn.get_data_mut().chip;
            let rest = chip.load(address) & !(1 << place);
            chip.store(address, rest | (low(word) & 1) << place);
        }),
    )?;
    unicorn.mmio_map(
        memory::TRACE.into(),
        0x1000,
        Some(|unicorn: &mut Unicorn<'_, Core>, offset, _| unicorn.get_data_mut().chip.load_trace(low(offset)).into()),
        Some(|unicorn: &mut Unicorn<'_, Core>, offset, _, word| {
            unicorn.get_data_mut().chip.store_trace(low(offset), low(word));
        }),
    )?;
    unicorn.mmio_map(
        memory::CORE.into(),
        0x1000,
        Some(|unicorn: &mut Unicorn<'_, Core>, offset, _| {
            let offset = low(offset);
            u64::from(unicorn.get_data_mut().chip.load_core(offset & !3) >> (8 * (offset & 3)))
        }),
        Some(|unicorn: &mut Unicorn<'_, Core>, offset, size, word| {
            unicorn.get_data_mut().chip.store_core(low(offset), size, low(word));
        }),
    )?;
    unicorn.add_mem_hook(HookType::MEM_UNMAPPED, 0, u64::MAX, |unicorn, _, address, _, _| {
        unicorn.get_data_mut().refused = Some(low(address));
        false
    })?;
    unicorn.add_code_hook(0, u64::MAX, run::count)?;
    Ok(())
}

#[allow(clippy::cast_possible_truncation)] // Addresses and words of a 32-bit machine.
const fn low(word: u64) -> u32 {
    word as u32
}

/// The word and the place in it that a word of the alias is.
const fn bit_of(offset: u32) -> (u32, u32) {
    let byte = offset >> 5;
    (memory::PERIPHERALS + (byte & !3), (byte & 3) * 8 + (offset >> 2 & 7))
}
