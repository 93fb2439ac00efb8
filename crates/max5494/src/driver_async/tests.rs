//! Each command beside the blocking driver's: the same frames in one CS cycle each, and the same waits.

use core::future::Future;
use core::ops::AsyncFnOnce;
use core::pin::pin;
use core::task::{Context, Poll, Waker};

use embedded_hal_async::spi::{ErrorKind, ErrorType, Operation};
use embedded_hal_mock::eh1::delay::{CheckedDelay, Transaction as Wait};
use embedded_hal_mock::eh1::spi::{Mock, Transaction};

use super::*;
use crate::Max5494;

/// Mocks never have a future wait.
fn at_once<T>(future: impl Future<Output = T>) -> T {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(done) => done,
        Poll::Pending => panic!("a mock is always ready"),
    }
}

fn frame(bytes: &[u8]) -> [Transaction<u8>; 3] {
    [Transaction::transaction_start(), Transaction::write_vec(bytes.to_vec()), Transaction::transaction_end()]
}

/// Runs a command on a mock that must see exactly this frame, then exactly these milliseconds.
async fn awaited(
    bytes: &[u8],
    waits: &[u32],
    command: impl AsyncFnOnce(&mut Max5494Async<Mock<u8>>, &mut CheckedDelay) -> Result<(), ErrorKind>,
) {
    let waits: std::vec::Vec<Wait> = waits.iter().map(|&ms| Wait::async_delay_ms(ms)).collect();
    let (mut delay, mut pot) = (CheckedDelay::new(&waits), Max5494Async::new(Mock::new(&frame(bytes))));
    command(&mut pot, &mut delay).await.unwrap();
    pot.release().done();
    delay.done();
}

/// What the blocking driver sends for a command, by a mock that takes anything.
fn blocking(command: impl FnOnce(&mut Max5494<Recorder>)) -> std::vec::Vec<u8> {
    let mut pot = Max5494::new(Recorder::default());
    command(&mut pot);
    pot.release().0
}

#[derive(Default)]
struct Recorder(std::vec::Vec<u8>);

impl ErrorType for Recorder {
    type Error = ErrorKind;
}

impl embedded_hal::spi::SpiDevice for Recorder {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        for operation in operations {
            let Operation::Write(bytes) = operation else { panic!("the part is write-only") };
            self.0.extend_from_slice(bytes);
        }
        Ok(())
    }
}

#[test]
fn every_command_sends_the_blocking_drivers_frame_and_waits_as_it_does() {
    let mut none = embedded_hal_mock::eh1::delay::NoopDelay::new();
    let at = Position::new(511).unwrap();
    at_once(async {
        for channel in [Channel::One, Channel::Two] {
            let bytes = blocking(|pot| pot.write_wiper(channel, at).unwrap());
            awaited(&bytes, &[], async |pot, _| pot.write_wiper(channel, at).await).await;
            let bytes = blocking(|pot| pot.write_nv(channel, at, &mut none).unwrap());
            awaited(&bytes, &[NV_BUSY_MS], async |pot, delay| pot.write_nv(channel, at, delay).await).await;
        }
        for channels in [Channels::One, Channels::Two, Channels::Both] {
            let bytes = blocking(|pot| pot.copy_wiper_to_nv(channels, &mut none).unwrap());
            awaited(&bytes, &[NV_BUSY_MS], async |pot, delay| pot.copy_wiper_to_nv(channels, delay).await).await;
            let bytes = blocking(|pot| pot.copy_nv_to_wiper(channels).unwrap());
            awaited(&bytes, &[], async |pot, _| pot.copy_nv_to_wiper(channels).await).await;
        }
    });
}

/// A bus whose CS line is stuck: every frame fails.
struct StuckChipSelect;

impl ErrorType for StuckChipSelect {
    type Error = ErrorKind;
}

impl SpiDevice for StuckChipSelect {
    async fn transaction(&mut self, _: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        Err(ErrorKind::ChipSelectFault)
    }
}

#[test]
fn the_bus_error_reaches_the_caller_and_a_store_that_failed_waits_all_the_same() {
    let mut delay = CheckedDelay::new(&[Wait::async_delay_ms(NV_BUSY_MS)]);
    let mut pot = Max5494Async::new(StuckChipSelect);
    let fault = Err(ErrorKind::ChipSelectFault);
    assert_eq!(at_once(pot.write_wiper(Channel::One, Position::LAST)), fault);
    assert_eq!(at_once(pot.copy_nv_to_wiper(Channels::Both)), fault);
    assert_eq!(at_once(pot.copy_wiper_to_nv(Channels::Both, &mut delay)), fault);
    delay.done();
}
