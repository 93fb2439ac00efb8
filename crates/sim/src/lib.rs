#![doc = include_str!("../README.md")]

mod ad7949;
mod chamber;
mod channel;
mod circuit;
mod converter;
mod crc32;
mod divider;
mod fault;
mod gyro;
mod noise;
mod parameters;
mod plant;
mod population;
mod port;
mod potentiometer;
mod random;
mod sensor;
mod spi;
mod supply;
mod thermal;
mod truth;
mod typical;

pub use chamber::{ChamberParameters, SetPointOutside};
pub use channel::AxisParameters;
pub use circuit::CircuitParameters;
pub use converter::ConverterParameters;
pub use fault::Fault;
pub use gyro::GyroParameters;
pub use parameters::PlantParameters;
pub use plant::{Plant, SharedPlant};
pub use potentiometer::{Potentiometer, PotentiometerParameters};
pub use sensor::SensorParameters;
pub use spi::{BusFault, ConverterSpi, PlantDelay, PortSpi, PotentiometerSpi};
pub use supply::SupplyParameters;
pub use thermal::ThermalParameters;
pub use truth::{AxisTruth, Truth};
