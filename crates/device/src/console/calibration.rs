//! A calibration on its way: from the store, or from the host through a buffer, into use.

use core::borrow;

use heapless::Vec;
use zerorate_core::record::{Laws, MAX_RECORD_BYTES, RecordError, RecordRefused, UnitSerial, laws_for};
use zerorate_core::units::GroupNumber;
use zerorate_core::wire::{Answer, CHUNK, CalibrationState, Refusal};

use crate::store::{RecordStore, Stored};

/// Where a record is put together, from the store or from what the host sends.
pub type Buffer = Vec<u8, MAX_RECORD_BYTES>;

/// The store, and the buffer before it.
pub(super) struct Calibration<S, B> {
    pub(super) store: S,
    unit: UnitSerial,
    buffer: B,
    state: CalibrationState,
    /// The buffer holds a checked record that is to be taken into use from this group on.
    install: Option<GroupNumber>,
}

impl<S: RecordStore, B: borrow::BorrowMut<Buffer>> Calibration<S, B> {
    /// What the store holds, to be taken into use at once if it is whole and the unit's, and not to be `set_aside`.
    pub(super) fn stored(store: S, buffer: B, unit: UnitSerial, set_aside: bool) -> Self {
        let mut calibration = Self { store, unit, buffer, state: CalibrationState::Blank, install: None };
        calibration.state = calibration.load(set_aside);
        calibration.install = calibration.state.is_in_use().then_some(GroupNumber(0));
        calibration
    }

    /// Reads the stored record into the buffer and checks it; one that is set aside is not looked into.
    fn load(&mut self, set_aside: bool) -> CalibrationState {
        let stored = self.store.stored();
        let length = usize::from(stored.length());
        let buffer: &mut Buffer = self.buffer.borrow_mut();
        buffer.clear();
        if buffer.resize_default(length).is_err() {
            return CalibrationState::Damaged;
        }
        if self.store.read(0, buffer) != Ok(length) {
            return CalibrationState::Unreachable;
        }
        let in_use = match stored {
            Stored::Blank => return CalibrationState::Blank,
            Stored::Damaged => return CalibrationState::Damaged,
            Stored::Unreachable => return CalibrationState::Unreachable,
            Stored::Whole(_) | Stored::Older(_) if set_aside => return CalibrationState::SetAside,
            Stored::Whole(_) => CalibrationState::InUse,
            Stored::Older(_) => CalibrationState::OlderInUse,
        };
        match self.check(self.buffer.borrow()) {
            Ok(()) => in_use,
            Err(RecordRefused::OtherUnit) => CalibrationState::OtherUnit,
            Err(RecordRefused::Law) => CalibrationState::LawRefused,
            Err(RecordRefused::Bytes(RecordError::UnknownVersion { found })) => {
                CalibrationState::UnknownVersion { found }
            }
            Err(RecordRefused::Bytes(_)) => CalibrationState::Damaged,
        }
    }

    /// A record's laws, if the unit may run them. A board that has not been given a serial takes any unit's.
    fn laws(&self, record: &[u8]) -> Result<Laws, RecordRefused> {
        laws_for(Some(self.unit.as_bytes()).filter(|serial| !serial.is_empty()), record)
    }

    /// Whether the unit may run them. The laws are not returned: they would stand on the stack of whoever asks.
    #[inline(never)]
    fn check(&self, record: &[u8]) -> Result<(), RecordRefused> {
        self.laws(record).map(drop)
    }

    /// Whether one is in use, and why not.
    pub(super) const fn state(&self) -> CalibrationState {
        self.state
    }

    /// The unit's serial.
    pub(super) const fn unit(&self) -> &UnitSerial {
        &self.unit
    }

    /// Gives the laws that are to be taken into use from a group on, once. They are made here, from the buffered record, so that
    /// they need not be kept twice, and lent, for they are too large to be handed on over a board's stack.
    pub(super) fn take_laws<R>(&mut self, group: GroupNumber, take: impl FnOnce(&Laws) -> R) -> Option<R> {
        self.install.take_if(|from| *from <= group)?;
        let buffer: &Buffer = self.buffer.borrow();
        let taken = self.laws(buffer).as_ref().ok().map(take);
        self.buffer.borrow_mut().clear();
        taken
    }

    /// A part of the stored record.
    pub(super) fn read(&mut self, offset: u16) -> Answer {
        let mut bytes = Vec::<u8, CHUNK>::from_array([0; CHUNK]);
        match self.store.read(usize::from(offset), &mut bytes) {
            Ok(n) => {
                bytes.truncate(n);
                Answer::Calibration { length: self.store.stored().length(), offset, bytes }
            }
            Err(_) => Answer::Refused(Refusal::StoreFailed),
        }
    }

    /// Puts a part of a record in the buffer.
    pub(super) fn write(&mut self, offset: u16, bytes: &[u8]) -> Result<(), Refusal> {
        if self.install.is_some() {
            // The buffer is still needed: the record in it waits for its group.
            return Err(Refusal::Busy);
        }
        let end = usize::from(offset) + bytes.len();
        let buffer: &mut Buffer = self.buffer.borrow_mut();
        if end > buffer.len() {
            buffer.resize_default(end).map_err(|_| Refusal::OutOfBuffer)?;
        }
        buffer[usize::from(offset)..end].copy_from_slice(bytes);
        Ok(())
    }

    /// Stores the buffered record, to be taken into use from a group on. Everything is checked before anything is stored: a
    /// record that cannot be run never replaces one that can.
    pub(super) fn commit(&mut self, length: u16, from: GroupNumber) -> Result<(), Refusal> {
        let buffer: &Buffer = self.buffer.borrow();
        let record = buffer.get(..usize::from(length)).ok_or(Refusal::OutOfBuffer)?;
        self.check(record)?;
        self.store.commit(record).map_err(|_| Refusal::StoreFailed)?;
        self.buffer.borrow_mut().truncate(usize::from(length));
        self.state = CalibrationState::InUse;
        self.install = Some(from);
        Ok(())
    }
}
