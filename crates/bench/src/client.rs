//! The host's end of the wire: commands out, answers and groups in.
//!
//! On a line in real time a command that is not answered is sent again with the same number, up to eight times in four
//! seconds: the device does it once and answers as often as it is asked. Groups that never came are named.

mod conversation;
pub(crate) mod wording;

use std::ops::RangeInclusive;
use std::time::{Duration, Instant};

use zerorate_core::record::{DeviceRecord, UNREADABLE, UnitSerial};
use zerorate_core::units::{Axis, GroupNumber, Taps};
use zerorate_core::wire::{
    Answer, CHUNK, FaultCounts, GroupReport, Health, Identity, Refusal, Request, Sample, Stop, WIRE_VERSION,
};

use self::conversation::Conversation;
use crate::link::{Link, LinkError};

/// How often a device that lost its power is looked for.
const LOOK_AGAIN: Duration = Duration::from_millis(300);

/// Opens the line again.
pub type Reopen = Box<dyn FnMut() -> Result<Box<dyn Link>, LinkError>>;

/// A device on a line.
pub struct DeviceClient {
    conversation: Conversation,
    reopen: Option<Reopen>,
}

/// What the host noticed of the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LineCounts {
    /// Uploads whose numbers never came.
    pub lost_uploads: u32,
    /// Frames that could not be read.
    pub damaged_frames: u32,
    /// Commands that were sent again because no answer came.
    pub sent_again: u32,
}

/// A group as it arrived.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// The report.
    pub report: GroupReport,
    /// The samples of X and Y, where they were streamed and all of them arrived.
    pub samples: [Vec<Sample>; 2],
}

/// Why a conversation with a device failed.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The line does not work.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The device will not do what it was asked.
    #[error("the device refused: {}", wording::of_refusal(.0))]
    Refused(Refusal),
    /// The device speaks another version.
    #[error("the device speaks version {device} of the wire, this program {WIRE_VERSION}: update {}", older(*device))]
    Version {
        /// The device's version.
        device: u16,
    },
    /// Whole frames arrive that say nothing this program knows.
    #[error(
        "the device speaks, and nothing of version {WIRE_VERSION} of the wire, which this program speaks: update the older of firmware and program"
    )]
    OtherTongue,
    /// Bytes arrive and no frame.
    #[error(
        "bytes arrive, but no message is whole: is this the board's port, and the rate right (serial:PATH@BAUD; the boards' is 115200)?"
    )]
    Noise,
    /// The device is there and does not answer.
    #[error(
        "the device does not answer although it was asked {what} {tries} times: the line to it damages too much, or it hangs; switch it off and on"
    )]
    Unanswered {
        /// What it was asked, as "to write a wiper".
        what: &'static str,
        /// How often.
        tries: u32,
    },
    /// The device answers and sends no groups.
    #[error(
        "the device answers and sends no groups: its acquisition stands still (`zerorate device faults` may say why)"
    )]
    NoGroups,
    /// The device began anew in the middle of something.
    #[error("the device has started anew in the middle of the run: it lost its power, or its watchdog restarted it")]
    Restarted,
    /// The device did not come back.
    #[error(
        "the device did not start anew within {waited_s} s of being asked for it: was its power switched off and on?"
    )]
    NoRestart {
        /// How long was waited, seconds.
        waited_s: u64,
    },
    /// There is no emulated board.
    #[error("{0}")]
    NotEmulated(String),
    /// The answer is of another kind than the question.
    #[error("the device gave an answer that does not belong to the question")]
    Confused,
    /// What was written is not what is read back.
    #[error(
        "the calibration read back from the device is not the one written: it was not taken into use everywhere, deploy it again"
    )]
    ReadBack,
    /// The record is longer than a message can say.
    #[error("the record cannot be sent: {0}")]
    Record(#[from] zerorate_core::record::RecordError),
}

const fn older(device: u16) -> &'static str {
    if device < WIRE_VERSION { "the device's firmware" } else { "this program" }
}

impl DeviceClient {
    /// A device on a line; nothing is said yet.
    #[must_use]
    pub fn new(link: Box<dyn Link>) -> Self {
        Self { conversation: Conversation::new(link), reopen: None }
    }

    /// How the line is opened again when it went with the device's power, as a USB port does.
    pub fn reopen_with(&mut self, reopen: Reopen) {
        self.reopen = Some(reopen);
    }

    /// What the host noticed of the line.
    #[must_use]
    pub const fn counts(&self) -> LineCounts {
        self.conversation.counts
    }

    /// The numbers of the groups that never came, since the last call.
    pub fn take_lost_groups(&mut self) -> Vec<RangeInclusive<u32>> {
        std::mem::take(&mut self.conversation.lost_groups)
    }

    /// The device has lost its power and started anew: it counts uploads from 0 again, and what was under way is gone.
    pub fn restarted(&mut self) {
        self.conversation.forget();
    }

    /// Waits until the device has lost its power and is back, up to `patience`; `look` is asked ten times a second
    /// whether to go on waiting.
    ///
    /// # Errors
    /// [`ClientError::NoRestart`]; whatever `look` says.
    pub fn await_restart<E: From<ClientError>>(
        &mut self,
        patience: Duration,
        mut look: impl FnMut() -> Result<(), E>,
    ) -> Result<Identity, E> {
        let began = Instant::now();
        let mut looked = began;
        let mut gone = false;
        while began.elapsed() < patience {
            look()?;
            // The question makes a device that is back say a number, and the number tells whether it began anew.
            if !gone && looked.elapsed() > LOOK_AGAIN {
                looked = Instant::now();
                gone = self.conversation.send(Request::Faults, None).is_err();
            }
            match self.conversation.next_answer() {
                Ok(_) => {}
                Err(ClientError::Restarted) => {
                    self.restarted();
                    return Ok(self.identify()?);
                }
                Err(_) => gone = true,
            }
            if gone {
                std::thread::sleep(LOOK_AGAIN);
                let Some(Ok(link)) = self.reopen.as_mut().map(|reopen| reopen()) else { continue };
                self.conversation.replace_link(link);
                if let Ok(identity) = self.identify() {
                    return Ok(identity);
                }
            }
        }
        Err(ClientError::NoRestart { waited_s: patience.as_secs() }.into())
    }

    /// Shakes hands: who is it, and does it speak this version?
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn identify(&mut self) -> Result<Identity, ClientError> {
        match self.ask(Request::Identity)? {
            Answer::Identity(mut identity) if identity.wire_version == WIRE_VERSION => {
                identity.unit = printable(&identity.unit);
                let period_us = u64::from(identity.samples_per_group) * u64::from(identity.sample_period_us);
                self.conversation.opened(Duration::from_micros(period_us), identity.running);
                Ok(identity)
            }
            Answer::Identity(identity) => Err(ClientError::Version { device: identity.wire_version }),
            _ => Err(ClientError::Confused),
        }
    }

    /// The device's fault counters.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn faults(&mut self) -> Result<FaultCounts, ClientError> {
        match self.ask(Request::Faults)? {
            Answer::Faults(faults) => Ok(faults),
            _ => Err(ClientError::Confused),
        }
    }

    /// Where the device's program stopped itself last since power came.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn stop(&mut self) -> Result<Option<Stop>, ClientError> {
        match self.ask(Request::Stop)? {
            Answer::Stop(stop) => Ok(stop),
            _ => Err(ClientError::Confused),
        }
    }

    /// How the device finds itself.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn health(&mut self) -> Result<Health, ClientError> {
        match self.ask(Request::Health)? {
            Answer::Health(health) => Ok(health),
            _ => Err(ClientError::Confused),
        }
    }

    /// Writes a record, commits it, reads it back and compares.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn deploy(&mut self, record: &DeviceRecord) -> Result<(), ClientError> {
        let mut buffer = [0; zerorate_core::record::MAX_RECORD_BYTES];
        let bytes = record.encode(&mut buffer)?;
        for (part, chunk) in bytes.chunks(CHUNK).enumerate() {
            let bytes = chunk.iter().copied().collect();
            self.order(Request::WriteCalibration { offset: offset(part * CHUNK)?, bytes })?;
        }
        self.order(Request::CommitCalibration { length: offset(bytes.len())? })?;
        if self.read_calibration()? == bytes { Ok(()) } else { Err(ClientError::ReadBack) }
    }

    /// The record that the device has stored; empty where there is none.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn read_calibration(&mut self) -> Result<Vec<u8>, ClientError> {
        let mut stored = Vec::new();
        loop {
            let Answer::Calibration { length, bytes, .. } =
                self.ask(Request::ReadCalibration { offset: offset(stored.len())? })?
            else {
                return Err(ClientError::Confused);
            };
            stored.extend_from_slice(&bytes);
            if stored.len() >= usize::from(length) || bytes.is_empty() {
                return Ok(stored);
            }
        }
    }

    /// Writes the wipers of both axes; returns the first group taken with them.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn set_taps(&mut self, taps: [Taps; 2]) -> Result<GroupNumber, ClientError> {
        let mut from = GroupNumber(0);
        let sent =
            Axis::BOTH.map(|axis| self.conversation.send(Request::SetTap { axis, tap: taps[axis.index()] }, None));
        for sent in sent {
            let (group, answer) = self.conversation.answer_to(&sent?)?;
            accepted(answer)?;
            from = from.max(group);
        }
        Ok(from)
    }

    /// Gives an order whose answer carries nothing; returns the first group for which it holds.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn order(&mut self, request: Request) -> Result<GroupNumber, ClientError> {
        self.order_at(request, None)
    }

    /// Gives an order that is to hold from a group on, the next one without it; returns the first group for which it
    /// does. The answer comes when that group is about to begin.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn order_at(&mut self, request: Request, at: Option<GroupNumber>) -> Result<GroupNumber, ClientError> {
        let (group, answer) = self.conversation.ask(request, at)?;
        accepted(answer).map(|()| group)
    }

    /// Waits for the next group.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn next_group(&mut self) -> Result<Group, ClientError> {
        self.group_within(self.conversation.too_late())?.ok_or(ClientError::NoGroups)
    }

    /// Waits for the next group, on a line in real time no longer than `patience`.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn group_within(&mut self, patience: Duration) -> Result<Option<Group>, ClientError> {
        self.conversation.group_before(self.conversation.now() + patience)
    }

    /// A group that has arrived already.
    pub(crate) fn arrived_group(&mut self) -> Option<Group> {
        self.conversation.arrived_group()
    }

    /// How long a group takes, as the device said when hands were shaken.
    #[must_use]
    pub const fn group_period(&self) -> Duration {
        self.conversation.group_period
    }

    /// Whether time passes on the device while nobody waits for it.
    #[must_use]
    pub fn in_real_time(&self) -> bool {
        self.conversation.in_real_time()
    }

    /// Forgets the groups that have arrived and were not asked for.
    pub fn discard_groups(&mut self) {
        self.conversation.discard_groups();
    }

    fn ask(&mut self, request: Request) -> Result<Answer, ClientError> {
        match self.conversation.ask(request, None)?.1 {
            Answer::Refused(refusal) => Err(ClientError::Refused(refusal)),
            answer => Ok(answer),
        }
    }
}

fn accepted(answer: Answer) -> Result<(), ClientError> {
    match answer {
        Answer::Done => Ok(()),
        Answer::Refused(refusal) => Err(ClientError::Refused(refusal)),
        _ => Err(ClientError::Confused),
    }
}

fn offset(bytes: usize) -> Result<u16, ClientError> {
    u16::try_from(bytes).map_err(|_| ClientError::Record(zerorate_core::record::RecordError::TooLong))
}

/// A serial as a screen and a file's name can have it. What a terminal would obey is to us what the board cannot read.
fn printable(serial: &UnitSerial) -> UnitSerial {
    serial.chars().map(|letter| if letter.is_control() { UNREADABLE } else { letter }).collect()
}
