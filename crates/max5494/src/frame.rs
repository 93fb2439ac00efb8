//! The part's ten commands as the bytes that travel, most significant bit first.
//!
//! Public and `const`, for those who send frames by other means than a [`SpiDevice`](embedded_hal::spi::SpiDevice):
//! by DMA, from a table in flash, from another core.
//!
//! Source: Maxim 19-3562 Rev 1 (6/05), command decoding on p. 13. The command byte is `00 C1 C0 00 RA1 RA0`; C1 C0
//! says what to do, RA1 RA0 with which register:
//!
//! | C1 C0 | command          | clocks                          |
//! |-------|------------------|---------------------------------|
//! | 0 0   | write wiper      | 24: command, D9 to D0, 6 unused |
//! | 0 1   | write NV         | 24: the same                    |
//! | 1 0   | copy wiper to NV | 8: command                      |
//! | 1 1   | copy NV to wiper | 8: command                      |
//!
//! A copy may also take 24 clocks, of which the part ignores the last 16; the short form is what is built here.

use crate::{Channel, Channels, Position};

/// The frame that moves a wiper at once and leaves the non-volatile register as it is.
#[must_use]
pub const fn write_wiper(channel: Channel, position: Position) -> [u8; 3] {
    write(0b00, channel, position)
}

/// The frame that sets where a wiper will stand after power-up and does not move it now.
#[must_use]
pub const fn write_nv(channel: Channel, position: Position) -> [u8; 3] {
    write(0b01, channel, position)
}

/// The frame that makes the present position the one after power-up.
#[must_use]
pub const fn copy_wiper_to_nv(channels: Channels) -> [u8; 1] {
    [command(0b10, copied_registers(channels))]
}

/// The frame that brings a wiper back to where power-up would put it.
#[must_use]
pub const fn copy_nv_to_wiper(channels: Channels) -> [u8; 1] {
    [command(0b11, copied_registers(channels))]
}

/// A 24-clock write: the command, D9 to D2, then D1 D0 and six bits that the part does not look at.
const fn write(c1_c0: u8, channel: Channel, position: Position) -> [u8; 3] {
    let register = match channel {
        Channel::One => 0b01,
        Channel::Two => 0b10,
    };
    // Ten bits stand left-justified in sixteen, so the shift loses nothing.
    let [high, low] = (position.get() << 6).to_be_bytes();
    [command(c1_c0, register), high, low]
}

const fn copied_registers(channels: Channels) -> u8 {
    match channels {
        Channels::One => 0b01,
        Channels::Two => 0b10,
        Channels::Both => 0b11,
    }
}

const fn command(c1_c0: u8, ra1_ra0: u8) -> u8 {
    c1_c0 << 4 | ra1_ra0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_position_travels_as_command_shifted_by_16_or_code_shifted_by_6() {
        // The formula of an independent public driver for the family, against ours by fields.
        for code in 0..1024 {
            let position = Position::new(code).unwrap();
            for (frame, command) in [
                (write_wiper(Channel::One, position), 0x01_u32),
                (write_wiper(Channel::Two, position), 0x02),
                (write_nv(Channel::One, position), 0x11),
                (write_nv(Channel::Two, position), 0x12),
            ] {
                let [high, middle, low] = frame;
                assert_eq!(u32::from_be_bytes([0, high, middle, low]), command << 16 | u32::from(code) << 6);
            }
        }
    }

    #[test]
    fn the_unused_bits_of_a_write_are_zero_at_full_scale() {
        assert_eq!(write_wiper(Channel::Two, Position::LAST), [0x02, 0xFF, 0xC0]);
    }

    #[test]
    fn copies_are_the_six_command_bytes_of_the_data_sheet() {
        assert_eq!(copy_wiper_to_nv(Channels::One), [0x21]);
        assert_eq!(copy_wiper_to_nv(Channels::Two), [0x22]);
        assert_eq!(copy_wiper_to_nv(Channels::Both), [0x23]);
        assert_eq!(copy_nv_to_wiper(Channels::One), [0x31]);
        assert_eq!(copy_nv_to_wiper(Channels::Two), [0x32]);
        assert_eq!(copy_nv_to_wiper(Channels::Both), [0x33]);
    }

    #[test]
    fn a_frame_can_be_a_constant() {
        const PARK: [u8; 3] = write_wiper(Channel::One, Position::FIRST);
        assert_eq!(PARK, [0x01, 0x00, 0x00]);
    }
}
