//! The board's buses as a processor sees them: `embedded-hal` handles on a shared plant.

use std::rc::Rc;

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::{Error, ErrorKind, ErrorType, Operation, SpiDevice};

use crate::fault::Bus;
use crate::plant::{Plant, SharedPlant};

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

/// A part that hangs on SPI: what it does as chip select falls, in eight clocks, and as chip select rises.
trait Slave {
    const BUS: Bus;
    fn select(plant: &mut Plant);
    fn exchange(plant: &mut Plant, byte: u8) -> u8;
    fn deselect(plant: &mut Plant);
}

/// What a part does at its pins.
#[derive(Debug, Clone, Copy)]
struct SlavePins {
    bus: Bus,
    select: fn(&mut Plant),
    exchange: fn(&mut Plant, u8) -> u8,
    deselect: fn(&mut Plant),
}

impl SlavePins {
    fn of<S: Slave>() -> Self {
        Self { bus: S::BUS, select: S::select, exchange: S::exchange, deselect: S::deselect }
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

/// A part's pins. A part that a fault keeps from hearing does nothing, and its line back stays low: whoever clocks it has no
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

    /// Eight clocks: a byte in and a byte out.
    pub fn exchange(&mut self, byte: u8) -> u8 {
        let plant = &mut *self.plant.borrow_mut();
        match self.selected {
            Some(Selected::Well) => (self.slave.exchange)(plant, byte),
            Some(Selected::Mute) => {
                _ = (self.slave.exchange)(plant, byte);
                0
            }
            Some(Selected::Deaf) | None => 0,
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
    let exchange = |plant: &mut Plant, byte| {
        let word = S::exchange(plant, byte);
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
    /// A register takes its word with the last byte of it: from then on the port scans, whatever time chip select takes.
    fn exchange(plant: &mut Plant, byte: u8) -> u8 {
        let sent = plant.port.exchange(byte);
        plant.port_written();
        sent
    }
    fn deselect(plant: &mut Plant) {
        plant.port.deselect();
    }
}

struct PotentiometerSlave;

impl Slave for PotentiometerSlave {
    const BUS: Bus = Bus::Potentiometer;

    fn select(plant: &mut Plant) {
        plant.potentiometer.select();
    }
    /// The part is write-only: nothing drives the line back, which a pull-down keeps low.
    fn exchange(plant: &mut Plant, byte: u8) -> u8 {
        (0..8).rev().for_each(|place| plant.potentiometer.clock(byte >> place & 1 == 1));
        0
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
        plant.ad7949.select();
    }
    fn exchange(plant: &mut Plant, byte: u8) -> u8 {
        plant.ad7949.exchange(byte)
    }
    fn deselect(plant: &mut Plant) {
        let held = plant.held();
        plant.ad7949.deselect(&held);
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
    fn a_port_that_is_started_at_its_pins_scans_from_the_last_byte_on_however_long_chip_select_stays_low() {
        let plant = Plant::new(PlantParameters::paper(), 1).share();
        plant.borrow_mut().pass_until_ns(7_000_000);
        let mut pins = PortSpi::new(&plant).pins();
        pins.select();
        for byte in [0x82, 0, 0, 0, 0, 3] {
            _ = pins.exchange(byte);
        }
        plant.borrow_mut().pass_until_ns(8_000_000);
        pins.deselect();
        assert_eq!(plant.borrow().next_scan_ns(), Some(10_000_000));
    }

    #[test]
    fn a_part_that_does_not_hear_or_is_not_selected_sends_zeros_and_does_nothing() {
        let plant = Plant::new(PlantParameters::paper(), 1).share();
        let mut pins = PortSpi::new(&plant).pins();
        let identity = |pins: &mut Pins| {
            pins.select();
            let sent = [0, 0, 0, 0, 0, 0].map(|byte| pins.exchange(byte));
            pins.deselect();
            (sent[2..] == *b"ZRAQ", sent == [0; 6])
        };
        plant.borrow_mut().inject(Fault::PortSpi { transfers: 1 });
        assert_eq!([identity(&mut pins), identity(&mut pins)], [(false, true), (true, false)]);
        assert_eq!(pins.exchange(0x10), 0);
        plant.borrow_mut().inject(Fault::MutePort { transfers: 1 });
        assert_eq!([identity(&mut pins), identity(&mut pins)], [(false, true), (true, false)]);
    }
}
