//! The driver: one method a command.

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::SpiDevice;

use crate::{frame, Channel, Channels, Position};

/// How long the part is busy after a frame that writes its non-volatile memory, from the rise of CS: 12 ms at most.
/// No other command may reach it meanwhile.
///
/// Source: the data sheet of the sibling MAX5481 to MAX5484, p. 16, which has the same memory and commands.
pub const NV_BUSY_MS: u32 = 12;

/// A MAX5494 to MAX5499 on an SPI bus.
///
/// It keeps no record of the wipers' positions. The part cannot be read back, and a power dip or a copy from its
/// memory moves a wiper without the record: whoever commands the positions also knows when to doubt them.
///
/// Every method gives the bus's own error and no other, and then the part may or may not have obeyed. Each command
/// sets a state, so repeating it is safe, at the price of one more store for those that write the memory.
#[derive(Debug)]
pub struct Max5494<SPI> {
    spi: SPI,
}

impl<SPI: SpiDevice> Max5494<SPI> {
    /// A driver on `spi`: mode 0, most significant bit first, at most 7 MHz, CS held low through a frame.
    ///
    /// Nothing is sent. The wipers stand where power-up or an earlier command put them.
    pub const fn new(spi: SPI) -> Self {
        Self { spi }
    }

    /// Gives the SPI device back.
    pub fn release(self) -> SPI {
        self.spi
    }

    /// Moves one wiper at once. Volatile: it costs no store cycle and is the only command fit for tracking.
    ///
    /// # Errors
    /// The bus's.
    pub fn write_wiper(&mut self, channel: Channel, position: Position) -> Result<(), SPI::Error> {
        self.spi.write(&frame::write_wiper(channel, position))
    }

    /// Sets where one wiper will stand after power-up, without moving it now. Costs one of 50 000 store cycles, and
    /// waits [`NV_BUSY_MS`].
    ///
    /// # Errors
    /// The bus's, after the wait.
    pub fn write_nv(
        &mut self,
        channel: Channel,
        position: Position,
        delay: &mut impl DelayNs,
    ) -> Result<(), SPI::Error> {
        self.store(&frame::write_nv(channel, position), delay)
    }

    /// Makes the present position of one wiper, or of both, the one after power-up. Costs one of 50 000 store cycles
    /// of each, and waits [`NV_BUSY_MS`].
    ///
    /// # Errors
    /// The bus's, after the wait.
    pub fn copy_wiper_to_nv(
        &mut self,
        channels: impl Into<Channels>,
        delay: &mut impl DelayNs,
    ) -> Result<(), SPI::Error> {
        self.store(&frame::copy_wiper_to_nv(channels.into()), delay)
    }

    /// Brings one wiper, or both, back to where power-up would put them. Costs no store cycle.
    ///
    /// # Errors
    /// The bus's.
    pub fn copy_nv_to_wiper(&mut self, channels: impl Into<Channels>) -> Result<(), SPI::Error> {
        self.spi.write(&frame::copy_nv_to_wiper(channels.into()))
    }

    /// Sends a frame that writes the memory and waits until it is done.
    ///
    /// The wait comes after a failure too: a bus can fail at the rise of CS, which is when the part begins to store.
    fn store(&mut self, frame: &[u8], delay: &mut impl DelayNs) -> Result<(), SPI::Error> {
        let sent = self.spi.write(frame);
        delay.delay_ms(NV_BUSY_MS);
        sent
    }
}

#[cfg(test)]
mod tests;
