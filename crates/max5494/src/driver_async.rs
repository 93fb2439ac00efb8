//! The driver for those who wait by `await`: one method a command, the frames those of the other.

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::spi::SpiDevice;

use crate::{frame, Channel, Channels, Position, NV_BUSY_MS};

/// A MAX5494 to MAX5499 on an asynchronous SPI bus: [`Max5494`](crate::Max5494) in all else.
///
/// A future that is dropped before it is done may have sent its frame or not. One of those that store may then leave the
/// part busy for [`NV_BUSY_MS`]: let that pass before the next command.
///
/// ```
/// use max5494::{Channel, Channels, Max5494Async, Position};
/// use embedded_hal_async::{delay::DelayNs, spi::SpiDevice};
///
/// async fn park<S: SpiDevice>(spi: S, delay: &mut impl DelayNs) -> Result<(), S::Error> {
///     let mut pot = Max5494Async::new(spi);
///     pot.write_wiper(Channel::One, Position::FIRST).await?;
///     pot.copy_wiper_to_nv(Channels::One, delay).await
/// }
/// ```
#[derive(Debug)]
pub struct Max5494Async<SPI> {
    spi: SPI,
}

impl<SPI: SpiDevice> Max5494Async<SPI> {
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

    /// Moves one wiper at once: [`Max5494::write_wiper`](crate::Max5494::write_wiper).
    ///
    /// # Errors
    /// The bus's.
    pub async fn write_wiper(&mut self, channel: Channel, position: Position) -> Result<(), SPI::Error> {
        self.spi.write(&frame::write_wiper(channel, position)).await
    }

    /// Sets where one wiper will stand after power-up, at the price of a store:
    /// [`Max5494::write_nv`](crate::Max5494::write_nv).
    ///
    /// # Errors
    /// The bus's, after the wait.
    pub async fn write_nv(
        &mut self,
        channel: Channel,
        position: Position,
        delay: &mut impl DelayNs,
    ) -> Result<(), SPI::Error> {
        self.store(&frame::write_nv(channel, position), delay).await
    }

    /// Makes the present position the one after power-up, at the price of a store of each:
    /// [`Max5494::copy_wiper_to_nv`](crate::Max5494::copy_wiper_to_nv).
    ///
    /// # Errors
    /// The bus's, after the wait.
    pub async fn copy_wiper_to_nv(
        &mut self,
        channels: impl Into<Channels>,
        delay: &mut impl DelayNs,
    ) -> Result<(), SPI::Error> {
        self.store(&frame::copy_wiper_to_nv(channels.into()), delay).await
    }

    /// Brings one wiper, or both, back to where power-up would put them:
    /// [`Max5494::copy_nv_to_wiper`](crate::Max5494::copy_nv_to_wiper).
    ///
    /// # Errors
    /// The bus's.
    pub async fn copy_nv_to_wiper(&mut self, channels: impl Into<Channels>) -> Result<(), SPI::Error> {
        self.spi.write(&frame::copy_nv_to_wiper(channels.into())).await
    }

    /// Sends a frame that writes the memory and waits until it is done, after a failure too.
    async fn store(&mut self, frame: &[u8], delay: &mut impl DelayNs) -> Result<(), SPI::Error> {
        let sent = self.spi.write(frame).await;
        delay.delay_ms(NV_BUSY_MS).await;
        sent
    }
}

#[cfg(test)]
mod tests;
