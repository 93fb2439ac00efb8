use std::vec::Vec;

use heapless::spsc::Queue;
use zerorate_core::wire::frame;

use super::*;
use crate::store::{MemoryStore, StoreFailed, Stored};
use crate::tests::record;

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
    let identity = DeviceIdentity { unit: UnitSerial::try_from("ZR-7").unwrap(), firmware: [1, 2, 3] };
    Console::new(identity, Timing::PAPER, store)
}

/// Sends one request and returns the answer.
fn ask<S: RecordStore>(console: &mut Console<S>, request: Request) -> Option<Answer> {
    let mut commands: Queue<Scheduled, 8> = Queue::new();
    let mut sent: Vec<u8> = Vec::new();
    let mut line = |bytes: &[u8]| {
        sent.extend_from_slice(bytes);
        true
    };
    let command = frame::encode(&Command { sequence: 9, at: None, request }).unwrap();
    for &byte in &command {
        console.receive(byte, &Status::default(), &mut commands.split().0, &mut line);
    }
    let mut receiver = Receiver::new();
    let upload: Upload = sent.iter().find_map(|&byte| receiver.push(byte))?.unwrap();
    match upload.message {
        Message::Answer { to: 9, answer, .. } => Some(answer),
        other => panic!("not an answer: {other:?}"),
    }
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
    let n = console.store.read(0, &mut bytes).unwrap();
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
    assert!(console.take_laws().is_none());
    assert_eq!(write(&mut console, &bytes), Some(Answer::Done));
    assert!(console.take_laws().is_some());
    assert!(console.take_laws().is_none(), "once");
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
    assert!(console(store).take_laws().is_some());
    let mut store = MemoryStore::default();
    store.commit(&encoded("ZR-8")).unwrap();
    assert!(console(store).take_laws().is_none(), "another unit's");
}

#[test]
fn a_record_that_cannot_be_run_never_replaces_one_that_can() {
    let mut console = console(MemoryStore::default());
    let good = encoded("ZR-7");
    write(&mut console, &good);
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

#[test]
fn a_store_that_fails_is_said_and_nothing_is_taken_into_use() {
    let mut console = console(WornOut);
    assert_eq!(write(&mut console, &encoded("ZR-7")), Some(Answer::Refused(Refusal::StoreFailed)));
    assert!(console.take_laws().is_none());
}

#[test]
fn damaged_frames_are_counted_and_not_acted_on() {
    let mut console = console(MemoryStore::default());
    let mut commands: Queue<Scheduled, 8> = Queue::new();
    for byte in [7, 3, 200, 0] {
        let acted = console.receive(byte, &Status::default(), &mut commands.split().0, &mut |_: &[u8]| true);
        assert!(!acted);
    }
    assert!(commands.is_empty());
    let Some(Answer::Faults(faults)) = ask(&mut console, Request::Faults) else { panic!("the faults") };
    assert_eq!(faults.damaged_frames, 1);
}

#[test]
fn the_device_says_who_it_is() {
    let mut console = console(MemoryStore::default());
    let Some(Answer::Identity(identity)) = ask(&mut console, Request::Identity) else { panic!("an identity") };
    assert_eq!((identity.unit.as_str(), identity.firmware), ("ZR-7", [1, 2, 3]));
    assert_eq!((identity.samples_per_group, identity.sample_period_us), (500, 3000));
}
