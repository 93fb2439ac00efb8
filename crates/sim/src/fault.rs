//! What can be broken on purpose.

use zerorate_core::units::Axis;

/// A fault of the bench, for [`crate::Plant::inject`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// An axis's temperature channel repeats its last sample.
    StuckTemperature(Axis),
    /// An axis's amplifier stands at its upper rail: the zero-rate channel reads 16 383.
    SaturatedInput(Axis),
    /// Every SPI transfer fails with [`crate::BusFault`].
    DeadSpi,
}
