//! The A/D when the processor drives it itself: AD7949, 14 bits, eight channels (Analog Devices, AD7949 data sheet).
//!
//! A frame of 16 clocks reads the result of the conversion before and writes the 14-bit configuration register, most
//! significant bit first. A configuration written in one frame takes effect for the conversion that starts at its end,
//! whose result is clocked out two frames later: a pipeline of two.

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::SpiDevice;

use crate::acquisition::Scan;

/// CFG bit 13: overwrite the configuration.
const OVERWRITE: u16 = 1 << 13;
/// CFG bits 12..10 = 111: unipolar, referred to ground.
const UNIPOLAR: u16 = 0b111 << 10;
/// CFG bits 9..7: the channel.
const CHANNEL_SHIFT: u32 = 7;
/// CFG bit 6: full bandwidth; the circuit has its own low-pass.
const FULL_BANDWIDTH: u16 = 1 << 6;
/// CFG bits 5..3 = 110: external reference, temperature sensor off, and the internal buffer off, for it would drive the pin
/// that the reference drives.
const EXTERNAL_REFERENCE: u16 = 0b110 << 3;
/// CFG bit 0: no read-back of the configuration after the result.
const NO_READ_BACK: u16 = 1;

/// t_CONV at most, with a supply below 4.5 V: until then the part must be left alone, or its result is disturbed.
const CONVERSION_NS: u32 = 3200;

/// The configuration that converts one channel.
const fn configuration(channel: u16) -> u16 {
    OVERWRITE | UNIPOLAR | (channel & 0b111) << CHANNEL_SHIFT | FULL_BANDWIDTH | EXTERNAL_REFERENCE | NO_READ_BACK
}

/// The four-channel scan on an AD7949.
pub struct Ad7949<SPI, DELAY> {
    spi: SPI,
    delay: DELAY,
}

impl<SPI: SpiDevice, DELAY: DelayNs> Ad7949<SPI, DELAY> {
    /// A driver on an SPI device in mode 0, up to 40 MHz, whose chip select is the part's CNV.
    #[must_use]
    pub const fn new(spi: SPI, delay: DELAY) -> Self {
        Self { spi, delay }
    }

    /// Converts channels 0 to 3 once, counts.
    ///
    /// Six frames: each asks for its own channel and brings the result of the one two before it; the last two ask
    /// for channel 0 again, only to bring out what is still in the pipeline. Each ends in a conversion, which is waited for.
    ///
    /// # Errors
    /// The SPI's.
    pub fn scan(&mut self) -> Result<Scan, SPI::Error> {
        let mut scan = [0; 4];
        for frame in 0..6_u16 {
            let channel = if frame < 4 { frame } else { 0 };
            // The 14 bits stand at the top of the frame's 16, both ways.
            let mut bytes = (configuration(channel) << 2).to_be_bytes();
            self.spi.transfer_in_place(&mut bytes)?;
            self.delay.delay_ns(CONVERSION_NS);
            if let Some(finished) = frame.checked_sub(2) {
                scan[usize::from(finished)] = u16::from_be_bytes(bytes) >> 2;
            }
        }
        Ok(scan)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal_mock::eh1::delay::NoopDelay;
    use embedded_hal_mock::eh1::spi::{Mock, Transaction};
    use std::vec::Vec;

    #[test]
    fn four_channels_come_through_a_pipeline_of_two() {
        // By the data sheet's table: 11 1100 0111 0001b is channel 0, + 1 << 7 a channel; shifted up by two.
        let frames: [(u16, u16); 6] =
            [(0xF1C4, 0x1111), (0xF3C4, 0x2222), (0xF5C4, 40), (0xF7C4, 44), (0xF1C4, 48), (0xF1C4, 65_532)];
        let expected: Vec<Transaction<u8>> = frames
            .iter()
            .flat_map(|(out, back)| {
                [
                    Transaction::transaction_start(),
                    Transaction::transfer_in_place(out.to_be_bytes().to_vec(), back.to_be_bytes().to_vec()),
                    Transaction::transaction_end(),
                ]
            })
            .collect();
        let mut spi = Mock::new(&expected);
        assert_eq!(Ad7949::new(&mut spi, NoopDelay).scan(), Ok([10, 11, 12, 16_383]));
        spi.done();
    }
}
