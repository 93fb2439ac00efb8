//! The host's end of the wire: commands out, answers and groups in.

use std::collections::VecDeque;

use zerorate_core::record::DeviceRecord;
use zerorate_core::units::{Axis, GroupNumber, Taps};
use zerorate_core::wire::frame::{self, Receiver};
use zerorate_core::wire::{
    Answer, CHUNK, Command, FaultCounts, GroupReport, Identity, Message, Refusal, Request, Sample, Upload, WIRE_VERSION,
};

use crate::link::{Link, LinkError};

/// A device on a line.
pub struct DeviceClient {
    link: Box<dyn Link>,
    receiver: Receiver,
    bytes: Vec<u8>,
    sequence: u16,
    next_upload: Option<u32>,
    groups: VecDeque<Group>,
    samples: [Vec<Sample>; 2],
    counts: LineCounts,
}

/// What the host noticed of the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LineCounts {
    /// Uploads whose numbers never came.
    pub lost_uploads: u32,
    /// Frames that could not be read.
    pub damaged_frames: u32,
}

/// A group as it arrived.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// The report.
    pub report: GroupReport,
    /// The samples of X and Y, where they were streamed.
    pub samples: [Vec<Sample>; 2],
}

/// Why a conversation with a device failed.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The line does not work.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The device will not do what it was asked.
    #[error("the device refused: {0}")]
    Refused(Refusal),
    /// The device speaks another version.
    #[error("the device speaks version {device} of the wire, this program {WIRE_VERSION}: update the older of the two")]
    Version {
        /// The device's version.
        device: u16,
    },
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

impl DeviceClient {
    /// A device on a line; nothing is said yet.
    #[must_use]
    pub fn new(link: Box<dyn Link>) -> Self {
        Self {
            link,
            receiver: Receiver::new(),
            bytes: Vec::new(),
            sequence: 0,
            next_upload: None,
            groups: VecDeque::new(),
            samples: [Vec::new(), Vec::new()],
            counts: LineCounts::default(),
        }
    }

    /// What the host noticed of the line.
    #[must_use]
    pub const fn counts(&self) -> LineCounts {
        self.counts
    }

    /// The device has lost its power and started anew: it counts uploads from 0 again, and what was under way is gone.
    pub fn restarted(&mut self) {
        self.receiver = Receiver::new();
        self.bytes.clear();
        self.next_upload = None;
        self.groups.clear();
        self.samples = [Vec::new(), Vec::new()];
    }

    /// Shakes hands: who is it, and does it speak this version?
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn identify(&mut self) -> Result<Identity, ClientError> {
        match self.ask(Request::Identity)? {
            Answer::Identity(identity) if identity.wire_version == WIRE_VERSION => Ok(identity),
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
        let sent = Axis::BOTH.map(|axis| self.send(Request::SetTap { axis, tap: taps[axis.index()] }));
        for sequence in sent {
            let (group, answer) = self.answer_to(sequence?)?;
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
        let sequence = self.send(request)?;
        let (group, answer) = self.answer_to(sequence)?;
        accepted(answer).map(|()| group)
    }

    /// Waits for the next group.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn next_group(&mut self) -> Result<Group, ClientError> {
        loop {
            if let Some(group) = self.groups.pop_front() {
                return Ok(group);
            }
            // An answer that comes meanwhile is one that nobody waits for any more.
            self.next_answer()?;
        }
    }

    /// Forgets the groups that have arrived and were not asked for.
    pub fn discard_groups(&mut self) {
        self.groups.clear();
        self.samples = [Vec::new(), Vec::new()];
    }

    fn ask(&mut self, request: Request) -> Result<Answer, ClientError> {
        let sequence = self.send(request)?;
        match self.answer_to(sequence)?.1 {
            Answer::Refused(refusal) => Err(ClientError::Refused(refusal)),
            answer => Ok(answer),
        }
    }

    fn send(&mut self, request: Request) -> Result<u16, ClientError> {
        self.sequence = self.sequence.wrapping_add(1);
        let command = Command { sequence: self.sequence, at: None, request };
        let frame = frame::encode(&command).map_err(|_| ClientError::Confused)?;
        self.link.send(&frame)?;
        Ok(self.sequence)
    }

    /// Waits for the answer to a command; groups that come meanwhile are kept.
    fn answer_to(&mut self, sequence: u16) -> Result<(GroupNumber, Answer), ClientError> {
        loop {
            match self.next_answer()? {
                Some((to, group, answer)) if to == sequence => return Ok((group, answer)),
                _ => {}
            }
        }
    }

    /// Takes the next upload: an answer is returned, a group kept.
    fn next_answer(&mut self) -> Result<Option<(u16, GroupNumber, Answer)>, ClientError> {
        let upload = self.next_upload()?;
        if let Some(expected) = self.next_upload {
            let lost = upload.sequence.wrapping_sub(expected);
            self.counts.lost_uploads = self.counts.lost_uploads.saturating_add(lost);
        }
        self.next_upload = Some(upload.sequence.wrapping_add(1));
        match upload.message {
            Message::Answer { to, group, answer } => return Ok(Some((to, group, answer))),
            Message::Samples(block) => self.samples[block.axis.index()].extend(block.samples),
            Message::Group(report) => {
                let samples = core::mem::take(&mut self.samples);
                self.groups.push_back(Group { report, samples });
            }
        }
        Ok(None)
    }

    fn next_upload(&mut self) -> Result<Upload, ClientError> {
        loop {
            let mut taken = 0;
            let mut found = None;
            for &byte in &self.bytes {
                taken += 1;
                found = self.receiver.push::<Upload>(byte);
                if found.is_some() {
                    break;
                }
            }
            self.bytes.drain(..taken);
            match found {
                Some(Ok(upload)) => return Ok(upload),
                Some(Err(_)) => self.counts.damaged_frames += 1,
                None => self.link.receive(&mut self.bytes)?,
            }
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
