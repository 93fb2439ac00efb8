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
    fn exchange(plant: &mut Plant, byte: u8) -> u8 {
        plant.port.exchange(byte)
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
