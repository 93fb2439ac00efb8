//! The task below the interrupt: host messages and the store.
//!
//! Bytes come in one by one; frames go out through [`Transmit`]. What concerns groups is handed on to the compensator; what
//! only asks is answered at once.

mod calibration;
mod memory;

use core::borrow;

use zerorate_core::record::{Laws, UnitSerial};
use zerorate_core::units::GroupNumber;
use zerorate_core::wire::frame::{FrameError, Receiver, encode};
use zerorate_core::wire::{
    Answer, Command, FaultCounts, Health, Identity, Message, Refusal, Request, Upload, WIRE_VERSION,
};

pub use self::calibration::Buffer;
use self::calibration::Calibration;
use self::memory::Memory;
use crate::acquisition::Timing;
use crate::compensator::{Action, Report, Scheduled, Status};
use crate::restart::Started;
use crate::store::RecordStore;

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

/// The console: frames in and out, and the calibration on its way.
pub struct Console<S, B = Buffer> {
    timing: Timing,
    started: Started,
    calibration: Calibration<S, B>,
    receiver: Receiver,
    uploads: u32,
    with_groups: bool,
    memory: Memory,
    /// The console's part of the fault counters.
    faults: FaultCounts,
    /// The group that is being filled, as far as it is known here.
    group: GroupNumber,
    health: fn() -> Health,
}

impl<S: RecordStore, B: borrow::BorrowMut<Buffer>> Console<S, B> {
    /// A console at start-up, of the unit of a serial, or without one of a board that takes any record. The stored record, if
    /// it is whole and this unit's, waits in [`take_laws`](Self::take_laws); otherwise the device runs uncompensated, and
    /// keeps talking.
    #[must_use]
    pub fn new(
        unit: UnitSerial,
        timing: Timing,
        store: S,
        buffer: B,
        started: Started,
        health: fn() -> Health,
    ) -> Self {
        Self {
            timing,
            calibration: Calibration::stored(store, buffer, unit, started.set_aside),
            started,
            receiver: Receiver::new(),
            uploads: 0,
            with_groups: false,
            memory: Memory::new(),
            faults: FaultCounts::default(),
            group: GroupNumber(0),
            health,
        }
    }

    /// Whether a record is in use.
    pub fn is_calibrated(&self) -> bool {
        self.calibration.state().is_in_use()
    }

    /// Gives the laws that are to be taken into use now, once; to be asked after a command was obeyed and after a report was sent.
    pub fn take_laws<R>(&mut self, take: impl FnOnce(&Laws) -> R) -> Option<R> {
        self.calibration.take_laws(self.group, take)
    }

    /// Takes a byte from the host; the command that it ends, if it ends one.
    pub fn hear(&mut self, byte: u8) -> Option<Command> {
        match self.receiver.push(byte)? {
            Ok(command) => return Some(command),
            Err(FrameError::Content) => self.faults.unknown_frames += 1,
            Err(_) => self.faults.damaged_frames += 1,
        }
        None
    }

    /// Acts on the command that was heard last; what of it is the compensator's is returned.
    pub fn obey(&mut self, command: Command, status: &Status, line: &mut impl Transmit) -> Option<Scheduled> {
        let Command { sequence, at, request } = command;
        self.group = status.group;
        if let Some(answer) = self.answer_anew(&request, status) {
            self.answer(sequence, status.group, answer, line);
            return None;
        }
        let crc = self.receiver.crc();
        if let Some(outcome) = self.memory.find(sequence, crc) {
            self.faults.repeated_commands += 1;
            if let Some((group, result)) = outcome {
                self.answer(sequence, group, answer_of(result), line);
            }
            return None;
        }
        if let Request::CommitCalibration { length } = request {
            let group = at.map_or(status.group, |at| at.max(status.group));
            let result = self.calibration.commit(length, group);
            self.memory.done(sequence, crc, (group, result));
            self.answer(sequence, group, answer_of(result), line);
            return None;
        }
        let action = Action::of(&request)?;
        if !self.memory.wait(sequence, crc) {
            self.answer(sequence, status.group, Answer::Refused(Refusal::Busy), line);
            return None;
        }
        if let Request::SetStream { groups, .. } = request {
            self.with_groups = groups;
        }
        Some(Scheduled { sequence, at, action })
    }

    /// Sends what the compensator has to say.
    pub fn report(&mut self, report: Report, line: &mut impl Transmit) {
        match report {
            Report::Done(sequence, outcome @ (group, result)) => {
                self.memory.settle(sequence, outcome);
                self.answer(sequence, group, answer_of(result), line);
            }
            Report::Group(report) => {
                self.group = GroupNumber(report.group.0.wrapping_add(1));
                if self.with_groups {
                    self.send(Message::Group(report), line);
                }
            }
            Report::Samples(block) => self.send(Message::Samples(block), line),
        }
    }

    /// The answer to what only asks, or may be done twice.
    fn answer_anew(&mut self, request: &Request, status: &Status) -> Option<Answer> {
        Some(match request {
            Request::Identity => {
                self.memory.forget();
                Answer::Identity(self.identity(status))
            }
            Request::Faults => Answer::Faults(self.faults(status)),
            Request::Stop => Answer::Stop(self.started.stop.clone()),
            Request::Health => Answer::Health((self.health)()),
            Request::ReadCalibration { offset } => self.calibration.read(*offset),
            Request::WriteCalibration { offset, bytes } => answer_of(self.calibration.write(*offset, bytes)),
            _ => return None,
        })
    }

    /// Who the board is.
    pub(crate) fn identity(&self, status: &Status) -> Identity {
        Identity {
            wire_version: WIRE_VERSION,
            unit: self.calibration.unit().clone(),
            firmware: FIRMWARE,
            samples_per_group: self.timing.set_length,
            sample_period_us: self.timing.scan_period_us,
            calibration: self.calibration.state(),
            group: status.group,
            running: status.running,
            taps: status.taps,
            modes: status.modes,
            reset: self.started.reset,
        }
    }

    fn faults(&self, status: &Status) -> FaultCounts {
        let FaultCounts { damaged_frames, dropped_uploads, unknown_frames, repeated_commands, .. } = self.faults;
        let dropped_uploads = dropped_uploads.saturating_add(status.faults.dropped_uploads);
        let restarts = self.started.restarts;
        FaultCounts { damaged_frames, dropped_uploads, unknown_frames, repeated_commands, restarts, ..status.faults }
    }

    fn answer(&mut self, to: u16, group: GroupNumber, answer: Answer, line: &mut impl Transmit) {
        self.send(Message::Answer { to, group, answer }, line);
    }

    fn send(&mut self, message: Message, line: &mut impl Transmit) {
        let upload = Upload { sequence: self.uploads, message };
        // The number is spent even when the upload is dropped: so the host sees that one is missing.
        self.uploads = self.uploads.wrapping_add(1);
        let sent = encode(&upload).is_ok_and(|frame| line.transmit(&frame));
        self.faults.dropped_uploads += u32::from(!sent);
    }
}

fn answer_of(result: Result<(), Refusal>) -> Answer {
    result.map_or_else(Answer::Refused, |()| Answer::Done)
}

/// This crate's version is the firmware's: major, minor, patch.
const FIRMWARE: [u16; 3] = {
    const fn part(text: &str) -> u16 {
        match u16::from_str_radix(text, 10) {
            Ok(part) => part,
            Err(_) => 0,
        }
    }
    [
        part(env!("CARGO_PKG_VERSION_MAJOR")),
        part(env!("CARGO_PKG_VERSION_MINOR")),
        part(env!("CARGO_PKG_VERSION_PATCH")),
    ]
};

#[cfg(test)]
mod tests;
