//! The second line: a scan's frame, a byte with each interrupt of its USART. Nothing waits for it.

use heapless::Vec;
use stm32f4xx_hal::pac::USART1;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::serial::{Tx, TxListen};
use zerorate_core::wire::SCAN_FRAME_BYTES;

/// A frame, as the line takes it.
type Frame = Vec<u8, SCAN_FRAME_BYTES>;

/// The second line.
pub struct ScanLine {
    sending: Tx<USART1>,
    frame: Frame,
    /// Bytes of it that have gone.
    gone: usize,
}

impl ScanLine {
    /// A line on which nothing is under way.
    pub const fn new(sending: Tx<USART1>) -> Self {
        Self { sending, frame: Frame::new(), gone: 0 }
    }

    /// A frame is to go out. While the one before is still under way, which takes scans that come faster than frames do, it is
    /// left out: a gap in the scans' numbers.
    pub fn begin(&mut self, frame: Frame) {
        if self.gone >= self.frame.len() {
            (self.frame, self.gone) = (frame, 0);
            self.sending.listen();
        }
    }

    /// The line takes a byte.
    pub fn go_on(&mut self) {
        match self.frame.get(self.gone) {
            Some(&byte) => self.gone += usize::from(self.sending.write(byte).is_ok()),
            None => self.sending.unlisten(),
        }
    }
}
