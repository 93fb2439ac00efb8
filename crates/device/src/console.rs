//! The task below the interrupt: host messages and the store.
//!
//! Bytes come in one by one; frames go out through [`Transmit`]. What concerns groups is handed to the compensator by
//! a queue; what only asks is answered at once.

use heapless::Vec;
use heapless::spsc::{Consumer, Producer};
use zerorate_core::compensate::{AxisLaw, Mode};
use zerorate_core::record::{DeviceRecord, MAX_RECORD_BYTES, RecordError, UnitSerial};
use zerorate_core::units::{Axis, GroupNumber};
use zerorate_core::wire::frame::{Receiver, encode};
use zerorate_core::wire::{
    Answer, CHUNK, CalibrationState, Command, Identity, Message, Refusal, Request, Upload, WIRE_VERSION,
};

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

/// A record taken into use: the laws of both axes, and what they do at start-up.
pub type Laws = ([AxisLaw; 2], [Mode; 2]);

/// The console: frames in and out, the calibration buffer, the store.
pub struct Console<S> {
    identity: DeviceIdentity,
    timing: Timing,
    store: S,
    receiver: Receiver,
    buffer: Vec<u8, MAX_RECORD_BYTES>,
    uploads: u32,
    with_groups: bool,
    damaged_frames: u32,
    dropped_uploads: u32,
    calibration: CalibrationState,
    /// The buffer holds a checked record that is to be taken into use.
    install: bool,
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
            damaged_frames: 0,
            dropped_uploads: 0,
            calibration: CalibrationState::Blank,
            install: false,
        };
        console.calibration = console.load();
        console.install = console.calibration.is_in_use();
        console
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
        match laws_of(&self.buffer, &self.identity.unit) {
            Ok(_) => in_use,
            Err(Refusal::OtherUnit) => CalibrationState::OtherUnit,
            Err(Refusal::LawRefused) => CalibrationState::LawRefused,
            Err(Refusal::Record(RecordError::UnknownVersion { found })) => CalibrationState::UnknownVersion { found },
            Err(_) => CalibrationState::Damaged,
        }
    }

    /// Where the record is kept.
    pub const fn store(&self) -> &S {
        &self.store
    }

    /// The laws that are to be taken into use, once. They are made here, from the buffered record, so that they need not
    /// be kept twice.
    pub fn take_laws(&mut self) -> Option<Laws> {
        if !core::mem::take(&mut self.install) {
            return None;
        }
        let laws = laws_of(&self.buffer, &self.identity.unit).ok();
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
            Some(Err(_)) => {
                self.damaged_frames += 1;
                false
            }
            Some(Ok(command)) => self.obey(command, status, commands, line),
        }
    }

    /// Sends what the compensator has reported.
    pub fn upload(&mut self, reports: &mut Consumer<'_, Report>, line: &mut impl Transmit) {
        while let Some(report) = reports.dequeue() {
            let message = match report {
                Report::Group(_) if !self.with_groups => continue,
                Report::Group(group) => Message::Group(group),
                Report::Samples(block) => Message::Samples(block),
                Report::Done { sequence, group, result } => {
                    let answer = result.map_or_else(Answer::Refused, |()| Answer::Done);
                    Message::Answer { to: sequence, group, answer }
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
        self.dropped_uploads += u32::from(!sent);
    }

    fn obey(
        &mut self,
        command: Command,
        status: &Status,
        commands: &mut Producer<'_, Scheduled>,
        line: &mut impl Transmit,
    ) -> bool {
        let Command { sequence, at, request } = command;
        let action = match request {
            Request::SetMode { axis, mode } => Some(Action::SetMode(axis, mode)),
            Request::SetTap { axis, tap } => Some(Action::SetTap(axis, tap)),
            Request::StorePowerUpTap => Some(Action::StorePowerUpTap),
            Request::SetAcquisition { run } => Some(Action::SetAcquisition(run)),
            Request::SetStream { groups, samples } => {
                self.with_groups = groups;
                Some(Action::SetSamples(samples))
            }
            _ => None,
        };
        if let Some(action) = action {
            if commands.enqueue(Scheduled { sequence, at, action }).is_ok() {
                return true;
            }
            self.answer(sequence, status.group, Answer::Refused(Refusal::Busy), line);
            return false;
        }
        let answer = match request {
            Request::Identity => Answer::Identity(self.identity(status)),
            Request::Faults => Answer::Faults(self.faults(status)),
            Request::ReadCalibration { offset } => self.read_calibration(offset),
            Request::WriteCalibration { offset, bytes } => done(self.write_calibration(offset, &bytes)),
            Request::CommitCalibration { length } => done(self.commit_calibration(length)),
            // The others went to the compensator.
            _ => return false,
        };
        self.answer(sequence, status.group, answer, line);
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
        }
    }

    fn faults(&self, status: &Status) -> zerorate_core::wire::FaultCounts {
        let mut faults = status.faults;
        faults.damaged_frames += self.damaged_frames;
        faults.dropped_uploads += self.dropped_uploads;
        faults
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
        let end = usize::from(offset) + bytes.len();
        if end > self.buffer.len() {
            self.buffer.resize_default(end).map_err(|_| Refusal::OutOfBuffer)?;
        }
        self.buffer[usize::from(offset)..end].copy_from_slice(bytes);
        Ok(())
    }

    /// Everything is checked before anything is stored: a record that cannot be run never replaces one that can.
    fn commit_calibration(&mut self, length: u16) -> Result<(), Refusal> {
        let record = self.buffer.get(..usize::from(length)).ok_or(Refusal::OutOfBuffer)?;
        laws_of(record, &self.identity.unit)?;
        self.store.commit(record).map_err(|_| Refusal::StoreFailed)?;
        self.buffer.truncate(usize::from(length));
        self.calibration = CalibrationState::InUse;
        self.install = true;
        Ok(())
    }
}

fn done(result: Result<(), Refusal>) -> Answer {
    result.map_or_else(Answer::Refused, |()| Answer::Done)
}

/// The laws in a record's bytes, checked in every respect, for a unit.
fn laws_of(bytes: &[u8], unit: &UnitSerial) -> Result<Laws, Refusal> {
    let record = DeviceRecord::decode(bytes).map_err(Refusal::Record)?;
    if !unit.is_empty() && record.unit != *unit {
        return Err(Refusal::OtherUnit);
    }
    let law = |axis| record.axis(axis).law(record.temperature_scale).map_err(|_| Refusal::LawRefused);
    let laws = [law(Axis::X)?, law(Axis::Y)?];
    Ok((laws, Axis::BOTH.map(|axis| record.axis(axis).start_up_mode)))
}

#[cfg(test)]
mod tests;
