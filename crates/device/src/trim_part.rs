//! The part that trims: a potentiometer today, a 16-bit DAC can follow.

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::SpiDevice;
use max5494::{Channel, Channels, Max5494, Position};
use zerorate_core::units::{Axis, Taps};

/// What the compensator asks of a trim part.
pub trait TrimPart {
    /// What can go wrong.
    type Error: core::fmt::Debug;

    /// Moves an axis's wiper, without wear.
    ///
    /// # Errors
    /// When the part cannot be reached; the wiper is then taken to be where it was.
    fn write(&mut self, axis: Axis, tap: Taps) -> Result<(), Self::Error>;

    /// Makes the present taps those of power-up. Wears the part.
    ///
    /// # Errors
    /// When the part cannot be reached.
    fn store_power_up(&mut self) -> Result<(), Self::Error>;

    /// Moves the wipers to where power-up would put them, without wear.
    ///
    /// # Errors
    /// When the part cannot be reached.
    fn recall_power_up(&mut self) -> Result<(), Self::Error>;
}

/// X on the potentiometer's first channel, Y on its second (paper, S2).
pub struct Max5494Trim<SPI, D> {
    potentiometer: Max5494<SPI>,
    delay: D,
}

impl<SPI: SpiDevice, D: DelayNs> Max5494Trim<SPI, D> {
    /// A trim part on the potentiometer's SPI device and a delay for its 12 ms stores.
    #[must_use]
    pub const fn new(spi: SPI, delay: D) -> Self {
        Self { potentiometer: Max5494::new(spi), delay }
    }
}

impl<SPI: SpiDevice, D: DelayNs> TrimPart for Max5494Trim<SPI, D>
where
    SPI::Error: core::fmt::Debug,
{
    type Error = SPI::Error;

    fn write(&mut self, axis: Axis, tap: Taps) -> Result<(), Self::Error> {
        let channel = match axis {
            Axis::X => Channel::One,
            Axis::Y => Channel::Two,
        };
        // Taps and Position have the same bounds, so the wiper cannot be sent elsewhere.
        let position = Position::new(tap.get()).unwrap_or(Position::LAST);
        self.potentiometer.write_wiper(channel, position)
    }

    fn store_power_up(&mut self) -> Result<(), Self::Error> {
        self.potentiometer.copy_wiper_to_nv(Channels::Both, &mut self.delay)
    }

    fn recall_power_up(&mut self) -> Result<(), Self::Error> {
        self.potentiometer.copy_nv_to_wiper(Channels::Both)
    }
}
