//! A board's second line, heard: each scan, corrected, as it comes. Nothing is ever said on it.

use std::collections::VecDeque;
use std::time::Duration;

use zerorate_core::wire::frame::Receiver;

pub use zerorate_core::wire::{ScanFlags, ScanReport};

use crate::choice::DeviceChoice;
use crate::link::{Link, LinkError};

/// A second line.
pub struct ScanLine {
    link: Box<dyn Link>,
    receiver: Receiver,
    bytes: VecDeque<u8>,
    /// The number of the last scan.
    last: Option<u32>,
    /// Frames that could not be read since the first that could.
    damaged: u32,
}

/// A scan as it was heard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HeardScan {
    /// What was said.
    pub report: ScanReport,
    /// Scans between the last one and this that were not heard; none where the acquisition was started anew.
    pub missed: u32,
}

impl ScanLine {
    /// Opens a board's second line; a serial port at that line's rate, 460 800 baud, unless another is named.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn open(choice: &DeviceChoice) -> Result<Self, LinkError> {
        Ok(Self::on(choice.scan_line()?))
    }

    /// The same on a line that is open.
    #[must_use]
    pub fn on(link: Box<dyn Link>) -> Self {
        Self { link, receiver: Receiver::new(), bytes: VecDeque::new(), last: None, damaged: 0 }
    }

    /// The next scan; `None` if none is heard for so long.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn next(&mut self, patience: Duration) -> Result<Option<HeardScan>, LinkError> {
        let until = self.link.now() + patience;
        loop {
            while let Some(byte) = self.bytes.pop_front() {
                match self.receiver.push::<ScanReport>(byte) {
                    Some(Ok(report)) => return Ok(Some(self.heard(report))),
                    // Half a frame, from before we listened, is no damage.
                    Some(Err(_)) => self.damaged += u32::from(self.last.is_some()),
                    None => {}
                }
            }
            if self.link.now() >= until {
                return Ok(None);
            }
            let mut heard = Vec::new();
            self.link.receive(&mut heard)?;
            self.bytes.extend(heard);
        }
    }

    fn heard(&mut self, report: ScanReport) -> HeardScan {
        let last = self.last.replace(report.scan);
        let missed = last.map_or(0, |last| report.scan.saturating_sub(last.saturating_add(1)));
        HeardScan { report, missed }
    }

    /// Frames that could not be read.
    #[must_use]
    pub const fn damaged(&self) -> u32 {
        self.damaged
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zerorate_core::compensate::Mode;
    use zerorate_core::wire::AxisScan;

    /// What is heard, some bytes at a time, and then nothing more.
    struct Said(VecDeque<Vec<u8>>);

    impl Link for Said {
        fn send(&mut self, _: &[u8]) -> Result<(), LinkError> {
            unreachable!("nobody speaks on it")
        }

        fn receive(&mut self, into: &mut Vec<u8>) -> Result<(), LinkError> {
            into.extend(self.0.pop_front().ok_or(LinkError::Silent)?);
            Ok(())
        }
    }

    fn report(scan: u32) -> ScanReport {
        let axis = AxisScan { corrected_q16: 8200 << 16, flags: ScanFlags::of(Mode::Hybrid) };
        ScanReport { scan, axes: [axis; 2] }
    }

    #[test]
    fn scans_are_told_with_how_many_were_missed_before_them_and_half_a_frame_at_first_is_no_damage() {
        let mut bytes: Vec<u8> = [7, 8, 9, 12, 0, 1].iter().flat_map(|&scan| report(scan).frame().unwrap()).collect();
        // We listen from the middle of scan 7 on; scan 9 is bent on its way.
        bytes.drain(..5);
        bytes[20 + 20] ^= 4;
        let mut line = ScanLine::on(Box::new(Said(bytes.chunks(13).map(<[u8]>::to_vec).collect())));
        let mut heard = Vec::new();
        while let Ok(Some(scan)) = line.next(Duration::from_secs(1)) {
            heard.push((scan.report.scan, scan.missed));
        }
        assert_eq!(heard, [(8, 0), (12, 3), (0, 0), (1, 0)]);
        assert_eq!(line.damaged(), 1);
    }
}
