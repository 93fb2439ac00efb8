//! The board's buses as a processor sees them: `embedded-hal` handles on a shared plant. A byte takes its clock's time, and the
//! port scans on meanwhile.

use std::rc::Rc;

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::{Error, ErrorKind, ErrorType, Operation, SpiDevice};

use crate::fault::Bus;
use crate::plant::{Plant, SharedPlant};

/// The clock of each bus, Hz: what the firmware for the STM32F405 divides its own clocks to. The acquisition port takes up to
/// 10 MHz, the MAX5494 up to 7.
const CLOCK_HZ: u64 = 5_250_000;

/// What a byte takes on a bus, in nanoseconds: eight clocks, rounded.
pub const SPI_BYTE_NS: u64 = (8 * 1_000_000_000 + CLOCK_HZ / 2) / CLOCK_HZ;

/// A transfer that failed, because a [`crate::Fault`] was injected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BusFault;

impl core::fmt::Display for BusFault {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        formatter.write_str("the bench's SPI bus is dead")
    }
}

impl core::error::Error for BusFault {}

impl Error for BusFault {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

/// A part that hangs on SPI: what it does as chip select falls, in a clock, and as chip select rises.
trait Slave {
    const BUS: Bus;
    fn select(plant: &mut Plant);
    fn clock(plant: &mut Plant, bit: bool) -> bool;
    fn deselect(plant: &mut Plant);
}

/// A byte, most significant bit first, through whatever takes and gives a bit.
pub(crate) fn eight_clocks(byte: u8, mut clock: impl FnMut(bool) -> bool) -> u8 {
    (0..8).rev().fold(0, |sent, place| sent << 1 | u8::from(clock(byte >> place & 1 == 1)))
}

/// What a part does at its pins.
#[derive(Debug, Clone, Copy)]
struct SlavePins {
    bus: Bus,
    select: fn(&mut Plant),
    clock: fn(&mut Plant, bool) -> bool,
    deselect: fn(&mut Plant),
}

impl SlavePins {
    fn of<S: Slave>() -> Self {
        Self { bus: S::BUS, select: S::select, clock: S::clock, deselect: S::deselect }
    }
}

/// How a part answers while chip select is low.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Selected {
    Well,
    /// What it sends does not arrive.
    Mute,
    /// It does not hear.
    Deaf,
}

/// A part's pins, clocked in whoever clocks them's own time. A part that a fault keeps from hearing does nothing, and its line back stays low: whoever clocks it has no
/// other sign of it.
#[derive(Debug)]
pub struct Pins {
    plant: SharedPlant,
    slave: SlavePins,
    selected: Option<Selected>,
}

impl Pins {
    /// Chip select falls; nothing if it is low.
    pub fn select(&mut self) {
        if self.selected.is_some() {
            return;
        }
        let plant = &mut *self.plant.borrow_mut();
        let selected = match (plant.transfer_fails(self.slave.bus), plant.transfer_is_mute(self.slave.bus)) {
            (true, _) => Selected::Deaf,
            (false, true) => Selected::Mute,
            (false, false) => Selected::Well,
        };
        if selected != Selected::Deaf {
            (self.slave.select)(plant);
        }
        self.selected = Some(selected);
    }

    /// A clock: a bit in and a bit out.
    pub fn clock(&mut self, bit: bool) -> bool {
        let plant = &mut *self.plant.borrow_mut();
        match self.selected {
            Some(Selected::Well) => (self.slave.clock)(plant, bit),
            Some(Selected::Mute) => {
                _ = (self.slave.clock)(plant, bit);
                false
            }
            Some(Selected::Deaf) | None => false,
        }
    }

    /// Chip select rises; nothing if it is high.
    pub fn deselect(&mut self) {
        if self.selected.take().is_some_and(|selected| selected != Selected::Deaf) {
            (self.slave.deselect)(&mut self.plant.borrow_mut());
        }
    }
}

/// Does a transaction's operations. Bytes that are only read clock zeros in.
fn transact<S: Slave>(shared: &SharedPlant, operations: &mut [Operation<'_, u8>]) -> Result<(), BusFault> {
    let plant = &mut *shared.borrow_mut();
    if plant.transfer_fails(S::BUS) {
        return Err(BusFault);
    }
    let is_mute = plant.transfer_is_mute(S::BUS);
    // What the part does it does with a byte's last clock.
    let exchange = |plant: &mut Plant, byte| {
        plant.pass_ns(SPI_BYTE_NS);
        let word = eight_clocks(byte, |bit| S::clock(plant, bit));
        if is_mute { 0 } else { word }
    };
    S::select(plant);
    for operation in operations {
        match operation {
            Operation::Read(words) => words.iter_mut().for_each(|word| *word = exchange(plant, 0)),
            Operation::Write(words) => words.iter().for_each(|&word| _ = exchange(plant, word)),
            Operation::TransferInPlace(words) => {
                words.iter_mut().for_each(|word| *word = exchange(plant, *word));
            }
            Operation::Transfer(read, write) => {
                for place in 0..read.len().max(write.len()) {
                    let word = exchange(plant, write.get(place).copied().unwrap_or(0));
                    if let Some(slot) = read.get_mut(place) {
                        *slot = word;
                    }
                }
            }
            Operation::DelayNs(ns) => plant.pass_ns(u64::from(*ns)),
        }
    }
    S::deselect(plant);
    Ok(())
}

/// Defines a handle to a part.
macro_rules! spi_handle {
    ($(#[$doc:meta])* $name:ident, $slave:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone)]
        pub struct $name(SharedPlant);

        impl $name {
            /// A handle on a plant.
            #[must_use]
            pub fn new(plant: &SharedPlant) -> Self {
                Self(Rc::clone(plant))
            }

            /// The part's pins, for a processor that is emulated down to its own.
            #[must_use]
            pub fn pins(self) -> Pins {
                Pins { plant: self.0, slave: SlavePins::of::<$slave>(), selected: None }
            }
        }

        impl ErrorType for $name {
            type Error = BusFault;
        }

        impl SpiDevice for $name {
            fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), BusFault> {
                transact::<$slave>(&self.0, operations)
            }
        }
    };
}

spi_handle! {
    /// The acquisition port (`docs/acquisition-port.md`). Its data ready line is [`Self::data_ready`].
    PortSpi, PortSlave
}
spi_handle! {
    /// The MAX5494.
    PotentiometerSpi, PotentiometerSlave
}
spi_handle! {
    /// The AD7949, for a processor that drives the A/D itself; [`Plant::next_scan`] paces it.
    ConverterSpi, ConverterSlave
}

impl PortSpi {
    /// The data ready line: a set waits to be read.
    #[must_use]
    pub fn data_ready(&self) -> bool {
        self.0.borrow().data_ready()
    }
}

struct PortSlave;

impl Slave for PortSlave {
    const BUS: Bus = Bus::Port;

    fn select(plant: &mut Plant) {
        plant.port.select();
    }
    fn clock(plant: &mut Plant, bit: bool) -> bool {
        plant.port.clock(bit)
    }
    fn deselect(plant: &mut Plant) {
        plant.port.deselect();
        plant.port_written();
    }
}

struct PotentiometerSlave;

impl Slave for PotentiometerSlave {
    const BUS: Bus = Bus::Potentiometer;

    fn select(plant: &mut Plant) {
        plant.potentiometer.select();
    }
    /// The part is write-only: nothing drives the line back, which a pull-down keeps low.
    fn clock(plant: &mut Plant, bit: bool) -> bool {
        plant.potentiometer.clock(bit);
        false
    }
    fn deselect(plant: &mut Plant) {
        let now_ns = plant.now_ns();
        plant.potentiometer.deselect(now_ns);
        plant.wipers_written();
    }
}

struct ConverterSlave;

impl Slave for ConverterSlave {
    const BUS: Bus = Bus::Converter;

    fn select(plant: &mut Plant) {
        let now_ns = plant.now_ns();
        plant.ad7949.select(now_ns);
    }
    fn clock(plant: &mut Plant, bit: bool) -> bool {
        plant.ad7949.clock(bit)
    }
    fn deselect(plant: &mut Plant) {
        let (held, now_ns) = (plant.held(), plant.now_ns());
        plant.ad7949.deselect(&held, now_ns);
    }
}

/// The processor's delay: time passes on the bench, and the port scans on meanwhile.
#[derive(Debug, Clone)]
pub struct PlantDelay(SharedPlant);

impl PlantDelay {
    /// A delay on a plant's timeline.
    #[must_use]
    pub fn new(plant: &SharedPlant) -> Self {
        Self(Rc::clone(plant))
    }
}

impl DelayNs for PlantDelay {
    fn delay_ns(&mut self, ns: u32) {
        self.0.borrow_mut().pass_ns(u64::from(ns));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::Fault;
    use crate::parameters::PlantParameters;

    #[test]
    fn a_port_that_is_started_at_its_pins_scans_from_the_rise_of_chip_select_on() {
        let plant = Plant::new(PlantParameters::paper(), 1).share();
        plant.borrow_mut().pass_until_ns(7_000_000);
        let mut pins = PortSpi::new(&plant).pins();
        pins.select();
        // RESTART and RUN.
        for byte in [0x82, 0, 0, 0, 0, 3, 0xA4, 0xA2, 0xBA, 0x88] {
            _ = eight_clocks(byte, |bit| pins.clock(bit));
        }
        plant.borrow_mut().pass_until_ns(8_000_000);
        pins.deselect();
        assert_eq!(plant.borrow().next_scan_ns(), Some(11_000_000));
    }

    #[test]
    fn a_part_that_does_not_hear_or_is_not_selected_sends_zeros_and_does_nothing() {
        let plant = Plant::new(PlantParameters::paper(), 1).share();
        let mut pins = PortSpi::new(&plant).pins();
        let identity = |pins: &mut Pins| {
            pins.select();
            let sent = [0, 0, 0, 0, 0, 0].map(|byte| eight_clocks(byte, |bit| pins.clock(bit)));
            pins.deselect();
            (sent[2..] == *b"ZRAQ", sent == [0; 6])
        };
        plant.borrow_mut().inject(Fault::PortSpi { transfers: 1 });
        assert_eq!([identity(&mut pins), identity(&mut pins)], [(false, true), (true, false)]);
        assert_eq!(eight_clocks(0x10, |bit| pins.clock(bit)), 0);
        plant.borrow_mut().inject(Fault::MutePort { transfers: 1 });
        assert_eq!([identity(&mut pins), identity(&mut pins)], [(false, true), (true, false)]);
    }
}
