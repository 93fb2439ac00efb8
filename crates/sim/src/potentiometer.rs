//! The MAX5494's logic: a shift register, two wiper registers, two non-volatile ones.
//!
//! Read from the facts of Maxim 19-3562 Rev 1, table and timing of page 13, and of its siblings' sheets: `00 C1 C0 00
//! RA1 RA0`, most significant bit first, taken on the rising clock, decoded when chip select rises.

use zerorate_core::units::{Axis, Taps};

/// The potentiometer's constants.
#[derive(Debug, Clone, PartialEq)]
pub struct PotentiometerParameters {
    /// The voltage across the strings. Default 5.0 (data sheet: 2.7 to 5.25 V).
    pub supply_v: f64,
    /// Spread of the steps in LSB rms. Default 0.06 (the sheet promises +-1 LSB, which is no typical part; assumed).
    pub dnl_lsb: f64,
    /// The divider's relative change per kelvin. Default 5e-6 (data sheet: 5 ppm/C ratiometric).
    pub ratiometric_tempco_per_k: f64,
    /// How long a store to non-volatile memory takes, in microseconds. Default 12 000 (MAX5487 sheet p. 16: at most
    /// 12 ms). Frames meanwhile are ignored.
    pub nv_busy_us: u32,
    /// What the non-volatile registers hold when the part comes from its maker. Default 512, mid-scale (open; 511 is what
    /// the bench stores).
    pub factory_tap: Taps,
}

impl Default for PotentiometerParameters {
    fn default() -> Self {
        Self {
            supply_v: 5.0,
            dnl_lsb: 0.06,
            ratiometric_tempco_per_k: 5e-6,
            nv_busy_us: 12_000,
            factory_tap: const { Taps::new(512).expect("below 1024") },
        }
    }
}

/// What a whole frame asks for. The channels are a mask: bit 0 wiper 1, bit 1 wiper 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Command {
    WriteWiper { channels: u8, tap: Taps },
    WriteMemory { channels: u8, tap: Taps },
    WiperToMemory { channels: u8 },
    MemoryToWiper { channels: u8 },
}

/// The potentiometer's registers and what has happened to them.
#[derive(Debug, Clone)]
pub struct Potentiometer {
    nv_busy_ns: u64,
    wipers: [Taps; 2],
    memory: [Taps; 2],
    /// The bits of the frame, last one lowest; more than 32 fall out at the top, but are counted.
    shift: u32,
    clocks: u32,
    busy_until_ns: u64,
    stores: [u32; 2],
    ignored_illegal: u32,
    ignored_busy: u32,
    worn: bool,
}

impl Potentiometer {
    /// A new part, just powered: the wipers load what the maker stored.
    pub(crate) fn new(parameters: &PotentiometerParameters) -> Self {
        let taps = [parameters.factory_tap; 2];
        Self {
            nv_busy_ns: u64::from(parameters.nv_busy_us) * 1000,
            wipers: taps,
            memory: taps,
            shift: 0,
            clocks: 0,
            busy_until_ns: 0,
            stores: [0; 2],
            ignored_illegal: 0,
            ignored_busy: 0,
            worn: false,
        }
    }

    /// Whether the non-volatile registers take nothing any more.
    pub(crate) fn wear(&mut self, worn: bool) {
        self.worn = worn;
    }

    /// Where an axis's wiper is: X is wiper 1, Y is wiper 2.
    #[must_use]
    pub fn wiper(&self, axis: Axis) -> Taps {
        self.wipers[axis.index()]
    }

    /// What an axis's non-volatile register holds: the wiper's place after the next power-up.
    #[must_use]
    pub fn stored(&self, axis: Axis) -> Taps {
        self.memory[axis.index()]
    }

    /// How often an axis's non-volatile register was written. The part is good for 50 000 (data sheet).
    #[must_use]
    pub fn stores(&self, axis: Axis) -> u32 {
        self.stores[axis.index()]
    }

    /// Frames that were no command: a wrong length, reserved bits set, a write to no wiper or to both.
    #[must_use]
    pub fn ignored_illegal(&self) -> u32 {
        self.ignored_illegal
    }

    /// Frames that came while a store was going on.
    #[must_use]
    pub fn ignored_busy(&self) -> u32 {
        self.ignored_busy
    }

    /// Chip select falls.
    pub(crate) fn select(&mut self) {
        self.shift = 0;
        self.clocks = 0;
    }

    /// One rising clock edge with its data bit.
    pub(crate) fn clock(&mut self, bit: bool) {
        self.shift = self.shift << 1 | u32::from(bit);
        self.clocks += 1;
    }

    /// Chip select rises: the frame is decoded and done, or ignored.
    pub(crate) fn deselect(&mut self, now_ns: u64) {
        if now_ns < self.busy_until_ns {
            self.ignored_busy += 1;
            return;
        }
        match decode(self.shift, self.clocks) {
            Some(command) => self.execute(command, now_ns),
            None => self.ignored_illegal += 1,
        }
    }

    /// Power off and on: the wipers load their non-volatile registers. A store that was going on is taken as done.
    pub(crate) fn power_cycle(&mut self) {
        self.wipers = self.memory;
        self.busy_until_ns = 0;
        self.select();
    }

    fn execute(&mut self, command: Command, now_ns: u64) {
        let (Command::WriteWiper { channels, .. }
        | Command::WriteMemory { channels, .. }
        | Command::WiperToMemory { channels }
        | Command::MemoryToWiper { channels }) = command;
        for index in (0..2).filter(|index| channels >> index & 1 == 1) {
            match command {
                Command::WriteWiper { tap, .. } => self.wipers[index] = tap,
                Command::WriteMemory { tap, .. } => self.store(index, tap, now_ns),
                Command::WiperToMemory { .. } => self.store(index, self.wipers[index], now_ns),
                Command::MemoryToWiper { .. } => self.wipers[index] = self.memory[index],
            }
        }
    }

    fn store(&mut self, index: usize, tap: Taps, now_ns: u64) {
        if !self.worn {
            self.memory[index] = tap;
        }
        self.stores[index] += 1;
        self.busy_until_ns = now_ns + self.nv_busy_ns;
    }
}

/// A frame's command. Writes take 24 clocks: command, D9 to D0, six bits that do not matter. Copies take 8 clocks, or 24
/// of which 16 do not matter.
fn decode(shift: u32, clocks: u32) -> Option<Command> {
    let (command, data) = match clocks {
        8 => (shift & 0xFF, None),
        24 => (shift >> 16 & 0xFF, Some(shift >> 6 & 0x3FF)),
        _ => return None,
    };
    let (operation, channels) = (command >> 4, (command & 0x0F) as u8);
    if !(1..=3).contains(&channels) {
        return None;
    }
    // Ten bits cannot be past the last tap.
    let written = data.filter(|_| channels != 3).and_then(|data| Taps::new(u16::try_from(data).ok()?));
    match operation {
        0 => written.map(|tap| Command::WriteWiper { channels, tap }),
        1 => written.map(|tap| Command::WriteMemory { channels, tap }),
        2 => Some(Command::WiperToMemory { channels }),
        3 => Some(Command::MemoryToWiper { channels }),
        _ => None,
    }
}

#[cfg(test)]
#[path = "potentiometer_tests.rs"]
mod tests;
