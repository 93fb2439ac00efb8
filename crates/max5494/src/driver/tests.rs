use embedded_hal::spi::{ErrorKind, ErrorType, Operation};
use embedded_hal_mock::eh1::delay::{CheckedDelay, Transaction as Wait};
use embedded_hal_mock::eh1::spi::{Mock, Transaction};

use super::*;

/// Runs `command` on a mock that must see exactly one frame, in one CS cycle, then exactly these waits.
fn sends(frame: &[u8], waits: &[Wait], command: impl FnOnce(&mut Max5494<Mock<u8>>, &mut CheckedDelay)) {
    let spi = Mock::new(&[
        Transaction::transaction_start(),
        Transaction::write_vec(frame.to_vec()),
        Transaction::transaction_end(),
    ]);
    let mut delay = CheckedDelay::new(waits);
    let mut pot = Max5494::new(spi);
    command(&mut pot, &mut delay);
    pot.release().done();
    delay.done();
}

fn at(taps: u16) -> Position {
    Position::new(taps).unwrap()
}

#[test]
fn a_wiper_write_is_24_clocks_and_waits_for_nothing() {
    sends(&[0x01, 0x7F, 0xC0], &[], |pot, _| pot.write_wiper(Channel::One, at(511)).unwrap());
    sends(&[0x02, 0x80, 0x00], &[], |pot, _| pot.write_wiper(Channel::Two, at(512)).unwrap());
}

#[test]
fn a_write_to_the_memory_is_24_clocks_and_waits_until_it_is_stored() {
    let busy = [Wait::delay_ms(NV_BUSY_MS)];
    sends(&[0x11, 0x00, 0x40], &busy, |pot, delay| pot.write_nv(Channel::One, at(1), delay).unwrap());
    sends(&[0x12, 0xFF, 0x80], &busy, |pot, delay| pot.write_nv(Channel::Two, at(1022), delay).unwrap());
}

#[test]
fn a_copy_to_the_memory_is_8_clocks_and_waits_until_it_is_stored() {
    let busy = [Wait::delay_ms(NV_BUSY_MS)];
    sends(&[0x21], &busy, |pot, delay| pot.copy_wiper_to_nv(Channel::One, delay).unwrap());
    sends(&[0x22], &busy, |pot, delay| pot.copy_wiper_to_nv(Channel::Two, delay).unwrap());
    sends(&[0x23], &busy, |pot, delay| pot.copy_wiper_to_nv(Channels::Both, delay).unwrap());
}

#[test]
fn a_copy_from_the_memory_is_8_clocks_and_waits_for_nothing() {
    sends(&[0x31], &[], |pot, _| pot.copy_nv_to_wiper(Channel::One).unwrap());
    sends(&[0x32], &[], |pot, _| pot.copy_nv_to_wiper(Channel::Two).unwrap());
    sends(&[0x33], &[], |pot, _| pot.copy_nv_to_wiper(Channels::Both).unwrap());
}

#[test]
fn a_new_driver_and_its_release_send_nothing() {
    Max5494::new(Mock::<u8>::new(&[])).release().done();
}

/// A bus whose CS line is stuck: every frame fails.
struct StuckChipSelect;

impl ErrorType for StuckChipSelect {
    type Error = ErrorKind;
}

impl SpiDevice for StuckChipSelect {
    fn transaction(&mut self, _: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        Err(ErrorKind::ChipSelectFault)
    }
}

#[test]
fn the_bus_error_of_every_command_reaches_the_caller() {
    let mut pot = Max5494::new(StuckChipSelect);
    let mut delay = embedded_hal_mock::eh1::delay::NoopDelay::new();
    let fault = Err(ErrorKind::ChipSelectFault);
    for channel in [Channel::One, Channel::Two] {
        assert_eq!(pot.write_wiper(channel, at(511)), fault);
        assert_eq!(pot.write_nv(channel, at(511), &mut delay), fault);
    }
    for channels in [Channels::One, Channels::Two, Channels::Both] {
        assert_eq!(pot.copy_wiper_to_nv(channels, &mut delay), fault);
        assert_eq!(pot.copy_nv_to_wiper(channels), fault);
    }
}

#[test]
fn a_store_that_failed_on_the_bus_waits_all_the_same() {
    let mut delay = CheckedDelay::new(&[Wait::delay_ms(NV_BUSY_MS)]);
    let stored = Max5494::new(StuckChipSelect).copy_wiper_to_nv(Channels::Both, &mut delay);
    assert_eq!(stored, Err(ErrorKind::ChipSelectFault));
    delay.done();
}
