use std::vec::Vec;

use zerorate_core::compensate::{CurveNumbers, Mode};
use zerorate_core::record::MAX_RECORD_BYTES;
use zerorate_core::units::Axis;
use zerorate_core::wire::{CHUNK, CalibrationState, Health, frame};

use super::*;
use crate::store::{StoreFailed, Stored};
use crate::tests::{MemoryStore, idle, record};

/// A store that has worn out.
struct WornOut;

impl RecordStore for WornOut {
    fn stored(&self) -> Stored {
        Stored::Blank
    }

    fn read(&mut self, _: usize, _: &mut [u8]) -> Result<usize, StoreFailed> {
        Ok(0)
    }

    fn commit(&mut self, _: &[u8]) -> Result<(), StoreFailed> {
        Err(StoreFailed)
    }
}

fn console<S: RecordStore>(store: S) -> Console<S> {
    console_of("ZR-7", store)
}

fn console_of<S: RecordStore>(unit: &str, store: S) -> Console<S> {
    Console::new(
        UnitSerial::try_from(unit).unwrap(),
        Timing::PAPER,
        store,
        Buffer::new(),
        Started::POWER,
        Health::default,
    )
}

/// Sends one request, each with a number of its own, and returns the answer.
fn ask<S: RecordStore>(console: &mut Console<S>, request: Request) -> Option<Answer> {
    let sequence = u16::try_from(console.uploads).unwrap();
    let mut commands = Vec::new();
    say(console, &Command { sequence, at: None, request }, &mut commands).map(|(_, _, answer)| answer)
}

/// Takes a byte in and obeys the command that it may end.
fn hear<S: RecordStore>(console: &mut Console<S>, byte: u8, line: &mut impl Transmit) -> Option<Scheduled> {
    let command = console.hear(byte)?;
    console.obey(command, &idle(), line)
}

/// Sends a command and returns the answer: to which number, from which group on, what.
fn say<S: RecordStore>(
    console: &mut Console<S>,
    command: &Command,
    commands: &mut Vec<Scheduled>,
) -> Option<(u16, GroupNumber, Answer)> {
    let mut sent: Vec<u8> = Vec::new();
    let mut line = |bytes: &[u8]| {
        sent.extend_from_slice(bytes);
        true
    };
    let frame = frame::encode(command).unwrap();
    for &byte in &frame {
        commands.extend(hear(console, byte, &mut line));
    }
    let mut receiver = Receiver::new();
    let upload: Upload = sent.iter().find_map(|&byte| receiver.push(byte))?.unwrap();
    match upload.message {
        Message::Answer { to, group, answer } => Some((to, group, answer)),
        other => panic!("not an answer: {other:?}"),
    }
}

/// Reports that the compensator has done a command.
fn report_done<S: RecordStore>(console: &mut Console<S>, sequence: u16, group: u32, result: Result<(), Refusal>) {
    console.report(Report::Done(sequence, (GroupNumber(group), result)), &mut |_: &[u8]| true);
}

fn write<S: RecordStore>(console: &mut Console<S>, bytes: &[u8]) -> Option<Answer> {
    for (part, chunk) in bytes.chunks(CHUNK).enumerate() {
        let offset = u16::try_from(part * CHUNK).unwrap();
        let bytes = Vec::from(chunk).into_iter().collect();
        assert_eq!(ask(console, Request::WriteCalibration { offset, bytes }), Some(Answer::Done));
    }
    ask(console, Request::CommitCalibration { length: u16::try_from(bytes.len()).unwrap() })
}

fn stored<S: RecordStore>(console: &mut Console<S>) -> Vec<u8> {
    let mut bytes = [0; MAX_RECORD_BYTES];
    let n = console.calibration.store.read(0, &mut bytes).unwrap();
    bytes[..n].to_vec()
}

fn encoded(unit: &str) -> Vec<u8> {
    let mut buffer = [0; MAX_RECORD_BYTES];
    Vec::from(record(unit).encode(&mut buffer).unwrap())
}

#[test]
fn a_record_is_written_committed_read_back_and_taken_into_use() {
    let mut console = console(MemoryStore::default());
    let bytes = encoded("ZR-7");
    assert!(console.take_laws(Laws::clone).is_none());
    assert_eq!(write(&mut console, &bytes), Some(Answer::Done));
    assert!(console.take_laws(Laws::clone).is_some());
    assert!(console.take_laws(Laws::clone).is_none(), "once");
    let mut read = Vec::new();
    while read.len() < bytes.len() {
        let offset = u16::try_from(read.len()).unwrap();
        let Some(Answer::Calibration { bytes, .. }) = ask(&mut console, Request::ReadCalibration { offset }) else {
            panic!("a part of the record")
        };
        read.extend_from_slice(&bytes);
    }
    assert_eq!(read, bytes);
}

#[test]
fn a_stored_record_of_this_unit_is_in_use_at_start_up() {
    let mut store = MemoryStore::default();
    store.commit(&encoded("ZR-7")).unwrap();
    assert!(console(store).take_laws(Laws::clone).is_some());
    let mut store = MemoryStore::default();
    store.commit(&encoded("ZR-8")).unwrap();
    assert!(console(store).take_laws(Laws::clone).is_none(), "another unit's");
}

#[test]
fn a_record_that_cannot_be_run_never_replaces_one_that_can() {
    let mut console = console(MemoryStore::default());
    let good = encoded("ZR-7");
    write(&mut console, &good);
    assert_eq!(
        ask(&mut console, Request::WriteCalibration { offset: 0, bytes: heapless::Vec::new() }),
        Some(Answer::Refused(Refusal::Busy)),
        "until the record in the buffer is in use"
    );
    assert!(console.take_laws(Laws::clone).is_some());
    let mut damaged = good.clone();
    damaged[40] ^= 1;
    let refused = |refusal| Some(Answer::Refused(refusal));
    assert_eq!(write(&mut console, &encoded("ZR-8")), refused(Refusal::OtherUnit));
    assert_eq!(write(&mut console, &damaged), refused(Refusal::Record(zerorate_core::record::RecordError::Damaged)));
    assert_eq!(stored(&mut console), good);
    assert_eq!(ask(&mut console, Request::CommitCalibration { length: 6000 }), refused(Refusal::OutOfBuffer));
    assert_eq!(
        ask(
            &mut console,
            Request::WriteCalibration { offset: u16::MAX, bytes: heapless::Vec::from_slice(&[1]).unwrap() }
        ),
        refused(Refusal::OutOfBuffer)
    );
}

/// Its CRC is right: it was composed wrongly, not damaged on its way.
#[test]
fn a_record_whose_table_of_edges_is_not_its_laws_is_neither_stored_nor_run() {
    let mut wrong = record("ZR-7");
    let CurveNumbers::Polynomial(drift) = &mut wrong.axes[1].law.drift.curve else { panic!() };
    drift.coefficients[0] -= 3 << 16;
    let mut buffer = [0; MAX_RECORD_BYTES];
    let wrong = wrong.encode(&mut buffer).unwrap();
    let mut store = MemoryStore::default();
    store.commit(wrong).unwrap();
    assert_eq!(console(store).calibration.state(), CalibrationState::LawRefused);
    let mut console = console(MemoryStore::default());
    let good = encoded("ZR-7");
    write(&mut console, &good);
    assert!(console.take_laws(Laws::clone).is_some());
    assert_eq!(write(&mut console, wrong), Some(Answer::Refused(Refusal::LawRefused)));
    assert_eq!(stored(&mut console), good);
}

#[test]
fn a_store_that_fails_is_said_and_nothing_is_taken_into_use() {
    let mut console = console(WornOut);
    assert_eq!(write(&mut console, &encoded("ZR-7")), Some(Answer::Refused(Refusal::StoreFailed)));
    assert!(console.take_laws(Laws::clone).is_none());
}

#[test]
fn damaged_frames_are_counted_and_not_acted_on() {
    let mut console = console(MemoryStore::default());
    for byte in [7, 3, 200, 0] {
        assert!(console.hear(byte).is_none());
    }
    let Some(Answer::Faults(faults)) = ask(&mut console, Request::Faults) else { panic!("the faults") };
    assert_eq!(faults.damaged_frames, 1);
}

#[test]
fn the_device_says_who_it_is() {
    let mut console = console(MemoryStore::default());
    let Some(Answer::Identity(identity)) = ask(&mut console, Request::Identity) else { panic!("an identity") };
    assert_eq!(identity.unit.as_str(), "ZR-7");
    assert_eq!(
        std::format!("{:?}", identity.firmware),
        std::format!("[{}]", env!("CARGO_PKG_VERSION").replace('.', ", "))
    );
    assert_eq!((identity.samples_per_group, identity.sample_period_us), (500, 3000));
}

fn set_tap(sequence: u16, tap: u16) -> Command {
    let tap = zerorate_core::units::Taps::new(tap).unwrap();
    Command { sequence, at: None, request: Request::SetTap { axis: Axis::X, tap } }
}

#[test]
fn a_command_that_comes_again_is_answered_again_and_not_done_again() {
    let mut console = console(MemoryStore::default());
    let mut commands = Vec::new();
    assert_eq!(say(&mut console, &set_tap(70, 600), &mut commands), None);
    assert_eq!(say(&mut console, &set_tap(70, 600), &mut commands), None, "it still waits");
    assert_eq!(commands.len(), 1, "once");
    report_done(&mut console, 70, 12, Ok(()));
    let again = say(&mut console, &set_tap(70, 600), &mut commands);
    assert_eq!(again, Some((70, GroupNumber(12), Answer::Done)), "the group at which it was done");
    assert_eq!(commands.len(), 1);
    // The same number with another content is another command: a host that has begun anew.
    assert_eq!(say(&mut console, &set_tap(70, 601), &mut commands), None);
    assert_eq!(commands.len(), 2);
    let Some(Answer::Faults(faults)) = ask(&mut console, Request::Faults) else { panic!("the faults") };
    assert_eq!(faults.repeated_commands, 2);
}

#[test]
fn a_refusal_is_remembered_too_but_not_that_there_was_no_room() {
    let mut console = console(MemoryStore::default());
    let mut commands = Vec::new();
    say(&mut console, &set_tap(1, 600), &mut commands);
    report_done(&mut console, 1, 3, Err(Refusal::TrimPartFailed));
    let again = say(&mut console, &set_tap(1, 600), &mut commands);
    assert_eq!(again, Some((1, GroupNumber(3), Answer::Refused(Refusal::TrimPartFailed))));
    say(&mut console, &set_tap(2, 600), &mut commands);
    report_done(&mut console, 2, 3, Err(Refusal::Busy));
    commands.clear();
    assert_eq!(say(&mut console, &set_tap(2, 600), &mut commands), None);
    assert_eq!(commands.len(), 1, "tried again");
    // No more are remembered than sixteen.
    let answers: Vec<_> = (10..30).map(|k| say(&mut console, &set_tap(k, 600), &mut commands)).collect();
    assert!(answers[..15].iter().all(Option::is_none));
    assert!(answers[15..].iter().all(|answer| matches!(answer, Some((_, _, Answer::Refused(Refusal::Busy))))));
}

#[test]
fn an_identity_opens_a_conversation_and_forgets_the_one_before() {
    let mut console = console(MemoryStore::default());
    let mut commands = Vec::new();
    say(&mut console, &set_tap(5, 600), &mut commands);
    report_done(&mut console, 5, 1, Ok(()));
    let hello = Command { sequence: 4, at: None, request: Request::Identity };
    assert!(say(&mut console, &hello, &mut commands).is_some());
    assert!(say(&mut console, &hello, &mut commands).is_some(), "always anew");
    assert_eq!(say(&mut console, &set_tap(5, 600), &mut commands), None);
    assert_eq!(commands.len(), 2, "done, as another conversation's number is its own");
}

#[test]
fn a_commit_that_comes_again_stores_once() {
    let mut console = console(MemoryStore::default());
    let mut commands = Vec::new();
    let bytes = encoded("ZR-7");
    for (part, chunk) in bytes.chunks(CHUNK).enumerate() {
        let request = Request::WriteCalibration {
            offset: u16::try_from(part * CHUNK).unwrap(),
            bytes: chunk.iter().copied().collect(),
        };
        ask(&mut console, request);
    }
    let request = Request::CommitCalibration { length: u16::try_from(bytes.len()).unwrap() };
    let commit = Command { sequence: 900, at: Some(GroupNumber(40)), request };
    let done = Some((900, GroupNumber(40), Answer::Done));
    assert_eq!(say(&mut console, &commit, &mut commands), done);
    assert!(console.take_laws(Laws::clone).is_none(), "its group has not come");
    assert_eq!(say(&mut console, &commit, &mut commands), done);
    console.group = GroupNumber(40);
    assert!(console.take_laws(Laws::clone).is_some());
    assert_eq!(say(&mut console, &commit, &mut commands), done, "and the buffer is empty by now");
    assert_eq!(stored(&mut console), bytes);
}

#[test]
fn what_is_stored_is_named_when_it_cannot_be_used() {
    let with = |bytes: &[u8], unit: &str| {
        let mut store = MemoryStore::default();
        store.commit(bytes).unwrap();
        let mut console = console_of(unit, store);
        let Some(Answer::Identity(identity)) = ask(&mut console, Request::Identity) else { panic!("it keeps talking") };
        assert_eq!(console.take_laws(Laws::clone).is_some(), identity.calibration.is_in_use());
        identity.calibration
    };
    let good = encoded("ZR-7");
    assert_eq!(with(&good, "ZR-7"), CalibrationState::InUse);
    assert_eq!(with(&good, ""), CalibrationState::InUse, "a board without a serial takes any");
    assert_eq!(with(&good, "ZR-8"), CalibrationState::OtherUnit);
    let mut damaged = good.clone();
    damaged[60] ^= 4;
    assert_eq!(with(&damaged, "ZR-7"), CalibrationState::Damaged);
    let mut newer = good;
    newer[4..6].copy_from_slice(&99_u16.to_le_bytes());
    assert_eq!(with(&newer, "ZR-7"), CalibrationState::UnknownVersion { found: 99 });
}

#[test]
fn a_frame_that_is_whole_and_says_nothing_we_know_is_counted_apart() {
    let mut console = console(MemoryStore::default());
    // A request of a later version: a number that stands for none of ours.
    let frame = frame::encode(&(3_u16, None::<u32>, 200_u8)).unwrap();
    for &byte in &frame {
        assert!(console.hear(byte).is_none());
    }
    let Some(Answer::Faults(faults)) = ask(&mut console, Request::Faults) else { panic!("the faults") };
    assert_eq!((faults.unknown_frames, faults.damaged_frames), (1, 0));
}

mod noise;
