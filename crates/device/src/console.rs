//! The task below the interrupt: host messages and the store.
//!
//! Bytes come in one by one; frames go out through [`Transmit`]. What concerns groups is handed to the compensator by
//! a queue; what only asks is answered at once.

mod memory;

use heapless::Vec;
use heapless::spsc::{Consumer, Producer};
use zerorate_core::record::{Laws, MAX_RECORD_BYTES, RecordError, RecordRefused, UnitSerial, laws_for};
use zerorate_core::units::GroupNumber;
use zerorate_core::wire::frame::{FrameError, Receiver, encode};
use zerorate_core::wire::{
    Answer, CHUNK, CalibrationState, Command, FaultCounts, Identity, Message, Refusal, Request, ResetCause, Upload,
    WIRE_VERSION,
};

use self::memory::{Memory, Outcome};
use crate::acquisition::Timing;
use crate::compensator::{Action, Report, Scheduled, Status};
use crate::store::{RecordStore, Stored};

/// The line to the host.
pub trait Transmit {
    /// Sends bytes; `false` when the line cannot take them now, and they are dropped.
    fn transmit(&mut self, bytes: &[u8]) -> bool;
}

impl<F: FnMut(&[u8]) -> bool> Transmit for F {
    fn transmit(&mut self, bytes: &[u8]) -> bool {
        self(bytes)
    }
}

/// Who the device is, fixed at build or first set-up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeviceIdentity {
    /// The unit's serial; empty on a board that has not been given one, which takes any record.
    pub unit: UnitSerial,
    /// The firmware's version, major, minor, patch.
    pub firmware: [u16; 3],
}

/// The console: frames in and out, the calibration buffer, the store.
pub struct Console<S> {
    identity: DeviceIdentity,
    timing: Timing,
    store: S,
    receiver: Receiver,
    buffer: Vec<u8, MAX_RECORD_BYTES>,
    uploads: u32,
    with_groups: bool,
    memory: Memory,
    /// The console's part of the fault counters.
    faults: FaultCounts,
    reset: ResetCause,
    calibration: CalibrationState,
    /// The buffer holds a checked record that is to be taken into use from this group on.
    install: Option<GroupNumber>,
    /// The group that is being filled, as far as it is known here.
    group: GroupNumber,
}

impl<S: RecordStore> Console<S> {
    /// A console at start-up. The stored record, if it is whole and this unit's, waits in
    /// [`take_laws`](Self::take_laws); otherwise the device runs uncompensated, and keeps talking.
    #[must_use]
    pub fn new(identity: DeviceIdentity, timing: Timing, store: S) -> Self {
        let mut console = Self {
            identity,
            timing,
            store,
            receiver: Receiver::new(),
            buffer: Vec::new(),
            uploads: 0,
            with_groups: false,
            memory: Memory::new(),
            faults: FaultCounts::default(),
            reset: ResetCause::Power,
            calibration: CalibrationState::Blank,
            install: None,
            group: GroupNumber(0),
        };
        console.calibration = console.load();
        console.install = console.calibration.is_in_use().then_some(GroupNumber(0));
        console
    }

    /// Why the device started, and how often it has restarted itself since its power came: the board knows.
    pub const fn started(&mut self, reset: ResetCause, restarts: u32) {
        self.reset = reset;
        self.faults.restarts = restarts;
    }

    /// Whether a calibration is in use, and why not.
    pub const fn calibration(&self) -> CalibrationState {
        self.calibration
    }

    /// Reads the stored record into the buffer and checks it.
    fn load(&mut self) -> CalibrationState {
        let stored = self.store.stored();
        let length = usize::from(stored.length());
        self.buffer.clear();
        if self.buffer.resize_default(length).is_err() {
            return CalibrationState::Damaged;
        }
        if self.store.read(0, &mut self.buffer) != Ok(length) {
            return CalibrationState::Unreachable;
        }
        let in_use = match stored {
            Stored::Blank => return CalibrationState::Blank,
            Stored::Damaged => return CalibrationState::Damaged,
            Stored::Unreachable => return CalibrationState::Unreachable,
            Stored::Whole(_) => CalibrationState::InUse,
            Stored::Older(_) => CalibrationState::OlderInUse,
        };
        match self.laws(length) {
            Ok(_) => in_use,
            Err(RecordRefused::OtherUnit) => CalibrationState::OtherUnit,
            Err(RecordRefused::Law) => CalibrationState::LawRefused,
            Err(RecordRefused::Bytes(RecordError::UnknownVersion { found })) => {
                CalibrationState::UnknownVersion { found }
            }
            Err(RecordRefused::Bytes(_)) => CalibrationState::Damaged,
        }
    }

    /// The laws in the first bytes of the buffer.
    fn laws(&self, length: usize) -> Result<Laws, RecordRefused> {
        laws_for(self.serial(), &self.buffer[..length])
    }

    /// The serial whose records are taken; none on a board that has not been given one.
    fn serial(&self) -> Option<&[u8]> {
        Some(self.identity.unit.as_bytes()).filter(|serial| !serial.is_empty())
    }

    /// Where the record is kept.
    pub const fn store(&self) -> &S {
        &self.store
    }

    /// The laws that are to be taken into use now, once; to be asked after bytes were received and after reports were
    /// uploaded. They are made here, from the buffered record, so that they need not be kept twice.
    pub fn take_laws(&mut self) -> Option<Laws> {
        self.install.take_if(|from| *from <= self.group)?;
        let laws = self.laws(self.buffer.len()).ok();
        self.buffer.clear();
        laws
    }

    /// Takes a byte from the host; acts on it when it ends a frame. `true` when the compensator has work.
    pub fn receive(
        &mut self,
        byte: u8,
        status: &Status,
        commands: &mut Producer<'_, Scheduled>,
        line: &mut impl Transmit,
    ) -> bool {
        match self.receiver.push::<Command>(byte) {
            None => false,
            Some(Err(error)) => {
                let unknown = error == FrameError::Content;
                self.faults.unknown_frames += u32::from(unknown);
                self.faults.damaged_frames += u32::from(!unknown);
                false
            }
            Some(Ok(command)) => {
                self.group = status.group;
                self.obey(command, status, commands, line)
            }
        }
    }

    /// Sends what the compensator has reported.
    pub fn upload(&mut self, reports: &mut Consumer<'_, Report>, line: &mut impl Transmit) {
        while let Some(report) = reports.dequeue() {
            if let Report::Group(group) = &report {
                self.group = GroupNumber(group.group.0.wrapping_add(1));
            }
            let message = match report {
                Report::Group(_) if !self.with_groups => continue,
                Report::Group(group) => Message::Group(group),
                Report::Samples(block) => Message::Samples(block),
                Report::Done { sequence, group, result } => {
                    self.memory.settle(sequence, (group, result));
                    Message::Answer { to: sequence, group, answer: answer_of(result) }
                }
            };
            self.send(message, line);
        }
    }

    fn send(&mut self, message: Message, line: &mut impl Transmit) {
        let upload = Upload { sequence: self.uploads, message };
        // The number is spent even when the upload is dropped: so the host sees that one is missing.
        self.uploads = self.uploads.wrapping_add(1);
        let sent = encode(&upload).is_ok_and(|frame| line.transmit(&frame));
        self.faults.dropped_uploads += u32::from(!sent);
    }

    fn obey(
        &mut self,
        command: Command,
        status: &Status,
        commands: &mut Producer<'_, Scheduled>,
        line: &mut impl Transmit,
    ) -> bool {
        let Command { sequence, at, request } = command;
        // What only asks, and what may be done twice, is answered anew.
        let answer = match request {
            Request::Identity => {
                self.memory.forget();
                Some(Answer::Identity(self.identity(status)))
            }
            Request::Faults => Some(Answer::Faults(self.faults(status))),
            Request::ReadCalibration { offset } => Some(self.read_calibration(offset)),
            Request::WriteCalibration { offset, ref bytes } => Some(answer_of(self.write_calibration(offset, bytes))),
            _ => None,
        };
        if let Some(answer) = answer {
            self.answer(sequence, status.group, answer, line);
            return false;
        }
        let crc = self.receiver.crc();
        if let Some(outcome) = self.memory.find(sequence, crc) {
            self.faults.repeated_commands += 1;
            if let Some((group, result)) = outcome {
                self.answer(sequence, group, answer_of(result), line);
            }
            return false;
        }
        let action = match request {
            Request::CommitCalibration { length } => {
                let group = at.map_or(status.group, |at| at.max(status.group));
                let outcome: Outcome = (group, self.commit_calibration(length, group));
                self.memory.done(sequence, crc, outcome);
                self.answer(sequence, group, answer_of(outcome.1), line);
                return false;
            }
            Request::SetMode { axis, mode } => Action::SetMode(axis, mode),
            Request::SetTap { axis, tap } => Action::SetTap(axis, tap),
            Request::StorePowerUpTap => Action::StorePowerUpTap,
            Request::SetAcquisition { run } => Action::SetAcquisition(run),
            Request::SetStream { samples, .. } => Action::SetSamples(samples),
            // The others were answered.
            _ => return false,
        };
        if self.memory.wait(sequence, crc) {
            if commands.enqueue(Scheduled { sequence, at, action }).is_ok() {
                if let Request::SetStream { groups, .. } = request {
                    self.with_groups = groups;
                }
                return true;
            }
            self.memory.settle(sequence, (status.group, Err(Refusal::Busy)));
        }
        self.answer(sequence, status.group, Answer::Refused(Refusal::Busy), line);
        false
    }

    fn answer(&mut self, to: u16, group: GroupNumber, answer: Answer, line: &mut impl Transmit) {
        self.send(Message::Answer { to, group, answer }, line);
    }

    fn identity(&self, status: &Status) -> Identity {
        Identity {
            wire_version: WIRE_VERSION,
            unit: self.identity.unit.clone(),
            firmware: self.identity.firmware,
            samples_per_group: self.timing.set_length,
            sample_period_us: self.timing.scan_period_us,
            calibration: self.calibration,
            group: status.group,
            running: status.running,
            taps: status.taps,
            modes: status.modes,
            reset: self.reset,
        }
    }

    fn faults(&self, status: &Status) -> FaultCounts {
        let FaultCounts { damaged_frames, dropped_uploads, unknown_frames, repeated_commands, restarts, .. } =
            self.faults;
        let dropped_uploads = dropped_uploads.saturating_add(status.faults.dropped_uploads);
        FaultCounts { damaged_frames, dropped_uploads, unknown_frames, repeated_commands, restarts, ..status.faults }
    }

    fn read_calibration(&mut self, offset: u16) -> Answer {
        let mut bytes = Vec::<u8, CHUNK>::from_array([0; CHUNK]);
        match self.store.read(usize::from(offset), &mut bytes) {
            Ok(n) => {
                bytes.truncate(n);
                Answer::Calibration { length: self.store.stored().length(), offset, bytes }
            }
            Err(_) => Answer::Refused(Refusal::StoreFailed),
        }
    }

    fn write_calibration(&mut self, offset: u16, bytes: &[u8]) -> Result<(), Refusal> {
        if self.install.is_some() {
            // The buffer is still needed: the record in it waits for its group.
            return Err(Refusal::Busy);
        }
        let end = usize::from(offset) + bytes.len();
        if end > self.buffer.len() {
            self.buffer.resize_default(end).map_err(|_| Refusal::OutOfBuffer)?;
        }
        self.buffer[usize::from(offset)..end].copy_from_slice(bytes);
        Ok(())
    }

    /// Everything is checked before anything is stored: a record that cannot be run never replaces one that can.
    fn commit_calibration(&mut self, length: u16, from: GroupNumber) -> Result<(), Refusal> {
        let record = self.buffer.get(..usize::from(length)).ok_or(Refusal::OutOfBuffer)?;
        laws_for(self.serial(), record)?;
        self.store.commit(record).map_err(|_| Refusal::StoreFailed)?;
        self.buffer.truncate(usize::from(length));
        self.calibration = CalibrationState::InUse;
        self.install = Some(from);
        Ok(())
    }
}

fn answer_of(result: Result<(), Refusal>) -> Answer {
    result.map_or_else(Answer::Refused, |()| Answer::Done)
}

#[cfg(test)]
mod tests;
