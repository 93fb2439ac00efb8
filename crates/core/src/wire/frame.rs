//! Frames: postcard, then a CRC-32, then COBS, then a zero byte.
//!
//! A zero byte ends a frame and nothing else is zero, so a receiver that missed something is in step again at the next
//! frame. A frame that cannot be read is an error with a name; it is never acted on.

use heapless::Vec;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::checksum::CRC_32;

/// Bytes of a frame's CRC.
pub(super) const CRC_BYTES: usize = 4;

/// More bytes than any frame takes on the wire, its zero included.
const MAX_FRAME: usize = 512;

/// Why a frame was not made, or not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameError {
    /// Longer than any message.
    TooLong,
    /// Not COBS, shorter than its CRC, or the CRC-32 does not match.
    Damaged,
    /// The CRC-32 matches and the content is no message of this version.
    Content,
}

/// A message as the bytes of a frame, its zero included.
///
/// # Errors
/// [`FrameError::TooLong`].
pub fn encode(message: &impl Serialize) -> Result<Vec<u8, MAX_FRAME>, FrameError> {
    encode_within(message)
}

/// A message that takes no more than `N` bytes on the wire.
///
/// # Errors
/// [`FrameError::TooLong`].
pub(super) fn encode_within<const N: usize>(message: &impl Serialize) -> Result<Vec<u8, N>, FrameError> {
    let mut payload = [0; N];
    // What fits before COBS adds its byte in 254 and the zero ends the frame.
    let most = N - N / 254 - 2;
    let length = postcard::to_slice(message, &mut payload[..most - CRC_BYTES]).map_err(|_| FrameError::TooLong)?.len();
    let crc = CRC_32.checksum(&payload[..length]).to_le_bytes();
    payload[length..length + CRC_BYTES].copy_from_slice(&crc);
    let mut frame = Vec::new();
    frame.resize_default(N).map_err(|_| FrameError::TooLong)?;
    let stuffed = cobs::try_encode(&payload[..length + CRC_BYTES], &mut frame).map_err(|_| FrameError::TooLong)?;
    frame.truncate(stuffed);
    frame.push(0).map_err(|_| FrameError::TooLong)?;
    Ok(frame)
}

/// Reads the content of a frame, its zero left off, and its CRC; or what is wrong first.
fn decode<T: DeserializeOwned>(stuffed: &mut [u8]) -> Result<(T, u32), FrameError> {
    let length = cobs::decode_in_place(stuffed).map_err(|_| FrameError::Damaged)?;
    let payload = stuffed.get(..length).ok_or(FrameError::Damaged)?;
    let (content, crc) = payload.split_last_chunk::<CRC_BYTES>().ok_or(FrameError::Damaged)?;
    if CRC_32.checksum(content).to_le_bytes() != *crc {
        return Err(FrameError::Damaged);
    }
    let (message, rest) = postcard::take_from_bytes(content).map_err(|_| FrameError::Content)?;
    if rest.is_empty() { Ok((message, u32::from_le_bytes(*crc))) } else { Err(FrameError::Content) }
}

/// Collects bytes into frames.
#[derive(Debug, Clone, Default)]
pub struct Receiver {
    bytes: Vec<u8, MAX_FRAME>,
    overflowed: bool,
    crc: u32,
}

impl Receiver {
    /// An empty receiver.
    #[must_use]
    pub const fn new() -> Self {
        Self { bytes: Vec::new(), overflowed: false, crc: 0 }
    }

    /// The CRC-32 of the last message that was read: one that is sent again has the same.
    #[must_use]
    pub const fn crc(&self) -> u32 {
        self.crc
    }

    /// Takes one byte; when it ends a frame, what the frame says, or why it cannot be read. An empty frame is no
    /// frame: a zero byte may be sent at any time to get in step.
    pub fn push<T: DeserializeOwned>(&mut self, byte: u8) -> Option<Result<T, FrameError>> {
        if byte != 0 {
            self.overflowed |= self.bytes.push(byte).is_err();
            return None;
        }
        let overflowed = core::mem::take(&mut self.overflowed);
        let frame = if overflowed {
            Some(Err(FrameError::TooLong))
        } else if self.bytes.is_empty() {
            None
        } else {
            Some(decode(&mut self.bytes).map(|(message, crc)| {
                self.crc = crc;
                message
            }))
        };
        self.bytes.clear();
        frame
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drift::Coverage;
    use crate::group::GroupSums;
    use crate::units::{Axis, GroupNumber, Taps};
    use crate::wire::{
        AxisReport, CHUNK, Command, GroupReport, Message, Request, SAMPLES_PER_BLOCK, Sample, SampleBlock,
        TemperatureCheck, Upload,
    };
    use proptest::prelude::*;

    fn receive<T: DeserializeOwned>(receiver: &mut Receiver, bytes: &[u8]) -> std::vec::Vec<Result<T, FrameError>> {
        bytes.iter().filter_map(|&byte| receiver.push(byte)).collect()
    }

    fn set_tap() -> Command {
        let request = Request::SetTap { axis: Axis::Y, tap: Taps::MIDDLE };
        Command { sequence: 7, at: Some(GroupNumber(2400)), request }
    }

    /// The longest message of each kind, with every number at its longest.
    #[test]
    fn the_longest_messages_fit_a_frame() {
        let sums =
            GroupSums { n: u32::MAX, temperature: u64::MAX, temperature_sq: u64::MAX, zro: u64::MAX, zro_sq: u64::MAX };
        let axis = AxisReport {
            sums,
            tap: Taps::LAST,
            mode: crate::compensate::Mode::Hybrid,
            corrected_q16: i32::MIN,
            coverage: Coverage::Invalid,
            saturated: true,
            moved_to: Some(Taps::LAST),
            temperature: TemperatureCheck::Saturated,
            trim_failed: true,
        };
        let (group, many) = (GroupNumber(u32::MAX), u32::MAX);
        let group = GroupReport { group, lost: many, acquisition_errors: many, axes: [axis.clone(), axis] };
        let sample = Sample { temperature: u16::MAX, zro: u16::MAX, corrected_q16: i32::MIN };
        let mut samples = Vec::new();
        samples.resize(SAMPLES_PER_BLOCK, sample).unwrap();
        let block = SampleBlock { group: GroupNumber(u32::MAX), axis: Axis::Y, index: u16::MAX, samples };
        for message in [Message::Group(group), Message::Samples(block)] {
            let upload = Upload { sequence: u32::MAX, message };
            let frame = encode(&upload).unwrap();
            assert_eq!(receive(&mut Receiver::new(), &frame), [Ok(upload)]);
        }
        let mut bytes = Vec::new();
        bytes.resize(CHUNK, 0xFF).unwrap();
        let request = Request::WriteCalibration { offset: u16::MAX, bytes };
        assert!(encode(&Command { sequence: u16::MAX, at: None, request }).is_ok());
    }

    #[test]
    fn a_receiver_is_in_step_again_after_a_frame_too_long() {
        let mut receiver = Receiver::new();
        let mut bytes = std::vec![1_u8; 3 * MAX_FRAME];
        bytes.push(0);
        bytes.extend(encode(&set_tap()).unwrap());
        let got = receive(&mut receiver, &bytes);
        assert_eq!(got, [Err(FrameError::TooLong), Ok(set_tap())]);
    }

    proptest! {
        #[test]
        fn a_changed_byte_never_becomes_another_command(at in 0..40_usize, to in any::<u8>()) {
            let mut frame = encode(&set_tap()).unwrap();
            let at = at % frame.len();
            prop_assume!(frame[at] != to);
            frame[at] = to;
            let _ = frame.push(0);
            for got in receive::<Command>(&mut Receiver::new(), &frame) {
                prop_assert!(got.is_err());
            }
        }

        /// Behind a CRC-32 that fits: what a later version, or a program gone wrong, might send.
        #[test]
        fn any_content_behind_the_right_crc_is_a_message_or_an_error(content in prop::collection::vec(any::<u8>(), 0..300)) {
            let mut payload = content.clone();
            payload.extend(CRC_32.checksum(&content).to_le_bytes());
            let mut stuffed = [0; MAX_FRAME];
            let length = cobs::encode(&payload, &mut stuffed);
            let mut again = stuffed;
            if let Ok((command, _)) = decode::<Command>(&mut stuffed[..length]) {
                prop_assert!(encode(&command).is_ok());
            }
            if let Ok((upload, _)) = decode::<Upload>(&mut again[..length]) {
                prop_assert!(encode(&upload).is_ok());
            }
        }

        #[test]
        fn noise_is_neither_a_panic_nor_a_command(noise in prop::collection::vec(any::<u8>(), 0..2000)) {
            for got in receive::<Command>(&mut Receiver::new(), &noise) {
                prop_assert!(got.is_err());
            }
        }
    }
}
