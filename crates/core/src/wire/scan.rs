//! A scan, corrected, as it goes out on the second line while the next one is being awaited: always of one length, so that a
//! control loop need not read postcard. docs/scan-line.md has its bytes.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use super::frame::{CRC_BYTES, FrameError, encode_within};
use crate::compensate::{Mode, Q16};

/// Bytes of a report before its CRC: the number, and of each axis the reading and its flags.
const REPORT_BYTES: usize = 4 + 2 * (4 + 1);
/// Bytes of a report's frame: with the CRC, COBS's one byte and the zero.
pub const SCAN_FRAME_BYTES: usize = REPORT_BYTES + CRC_BYTES + 2;

/// A scan, corrected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct ScanReport {
    /// Its number since the acquisition was started, times the scan period its time: a gap is scans that were not read, or whose
    /// frames were lost; a step back is a new start.
    #[serde(with = "postcard::fixint::le")]
    pub scan: u32,
    /// X and Y.
    pub axes: [AxisScan; 2],
}

/// One axis of a [`ScanReport`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct AxisScan {
    /// The reading, corrected as its mode has it, in steps of 1/65536 count ([`Q16`]).
    #[serde(with = "postcard::fixint::le")]
    pub corrected_q16: i32,
    /// What is to be thought of it.
    pub flags: ScanFlags,
}

impl AxisScan {
    /// The corrected reading, counts.
    #[must_use]
    pub fn counts(&self) -> f64 {
        Q16(self.corrected_q16).to_counts()
    }
}

/// The mode of an axis and what is to be thought of its reading, a bit each.
#[derive(Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ScanFlags(u8);

impl ScanFlags {
    /// The law is in force: there is one, the mode is not off, and a temperature has been taken in.
    pub const AT_WORK: Self = Self(1 << 2);
    /// The temperature is not believed: tap and correction are those of the last one that was.
    pub const HELD: Self = Self(1 << 3);
    /// The temperature is outside the calibrated range: the correction is that of the range's end.
    pub const OUTSIDE: Self = Self(1 << 4);
    /// The correction leans on a history that has not been seen.
    pub const UNCERTAIN: Self = Self(1 << 5);
    /// More than a count of the wiper's last step is still on its way through the low-pass; a mode that corrects follows it.
    pub const SETTLING: Self = Self(1 << 6);
    /// The sample stands at an end of the converter.
    pub const SATURATED: Self = Self(1 << 7);

    /// The flags of an axis in a mode, none of them set.
    #[must_use]
    pub const fn of(mode: Mode) -> Self {
        Self(match mode {
            Mode::Off => 0,
            Mode::Trim => 1,
            Mode::Digital => 2,
            Mode::Hybrid => 3,
        })
    }

    /// These, and a flag where it applies.
    #[must_use]
    pub const fn with(self, flag: Self, applies: bool) -> Self {
        Self(if applies { self.0 | flag.0 } else { self.0 })
    }

    /// These, and all that are set in others.
    #[must_use]
    pub const fn and(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }

    /// Whether a flag is set.
    #[must_use]
    pub const fn has(self, flag: Self) -> bool {
        self.0 & flag.0 != 0
    }

    /// The mode.
    #[must_use]
    pub const fn mode(self) -> Mode {
        match self.0 & 3 {
            0 => Mode::Off,
            1 => Mode::Trim,
            2 => Mode::Digital,
            _ => Mode::Hybrid,
        }
    }
}

impl core::fmt::Debug for ScanFlags {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:#010b}", self.0)
    }
}

impl ScanReport {
    /// The report as the bytes of its frame; [`frame::Receiver`](super::frame::Receiver) reads it.
    ///
    /// # Errors
    /// None: every report has the same length.
    pub fn frame(&self) -> Result<Vec<u8, SCAN_FRAME_BYTES>, FrameError> {
        encode_within(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::frame::Receiver;
    use proptest::prelude::*;

    const REPORT: ScanReport = ScanReport {
        scan: 0x0001_0203,
        axes: [
            AxisScan { corrected_q16: 0x2008_4000, flags: ScanFlags(0b0000_0111) },
            AxisScan { corrected_q16: -2, flags: ScanFlags(0b1100_1010) },
        ],
    };

    /// By hand, as docs/scan-line.md has it: COBS stands in for the zeros at bytes 3 and 4. The CRC is zlib's:
    ///
    ///     python3 -c 'import zlib
    ///     print(zlib.crc32(bytes.fromhex("0302010000400820 07 feffffff ca")).to_bytes(4, "little").hex())'
    #[test]
    fn a_frame_has_the_bytes_of_its_page() {
        let frame = REPORT.frame().unwrap();
        assert_eq!(frame.len(), SCAN_FRAME_BYTES);
        assert_eq!(frame.as_slice(), GOLDEN);
        assert!((REPORT.axes[0].counts() - 8200.25).abs() < 1e-9);
    }

    const GOLDEN: [u8; SCAN_FRAME_BYTES] =
        [4, 3, 2, 1, 1, 14, 0x40, 8, 0x20, 7, 0xFE, 0xFF, 0xFF, 0xFF, 0xCA, 0x52, 0xBE, 0xE0, 0xF6, 0];

    #[test]
    fn the_flags_say_mode_and_each_bit_of_its_own() {
        for mode in [Mode::Off, Mode::Trim, Mode::Digital, Mode::Hybrid] {
            assert_eq!(ScanFlags::of(mode).with(ScanFlags::HELD, true).mode(), mode);
        }
        let all = [
            ScanFlags::AT_WORK,
            ScanFlags::HELD,
            ScanFlags::OUTSIDE,
            ScanFlags::UNCERTAIN,
            ScanFlags::SETTLING,
            ScanFlags::SATURATED,
        ];
        for flag in all {
            let set = ScanFlags::of(Mode::Hybrid).with(flag, true);
            assert_eq!(all.map(|other| set.has(other)), all.map(|other| other == flag));
        }
    }

    proptest! {
        #[test]
        fn every_report_is_read_back_from_a_frame_of_the_same_length_and_none_with_a_bit_flipped(
            scan: u32, x: i32, y: i32, flags: [u8; 2], bit in 0..8 * (SCAN_FRAME_BYTES - 1),
        ) {
            let [x_flags, y_flags] = flags.map(ScanFlags);
            let axes = [AxisScan { corrected_q16: x, flags: x_flags }, AxisScan { corrected_q16: y, flags: y_flags }];
            let report = ScanReport { scan, axes };
            let mut frame = report.frame().unwrap();
            prop_assert_eq!(frame.len(), SCAN_FRAME_BYTES);
            let mut receiver = Receiver::new();
            let mut read = |bytes: &[u8]| bytes.iter().filter_map(|&byte| receiver.push::<ScanReport>(byte)).last();
            prop_assert_eq!(read(&frame), Some(Ok(report)));
            frame[bit / 8] ^= 1 << (bit % 8);
            prop_assert!(!matches!(read(&frame), Some(Ok(_))));
        }
    }
}
