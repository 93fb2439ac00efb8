use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Mutex};

use super::*;

/// What a line does with a request: the bytes that come back, none for silence.
#[derive(Default)]
struct Script {
    answers: VecDeque<Vec<u8>>,
    sent: Vec<Vec<u8>>,
    renewed: usize,
}

struct Scripted(Arc<Mutex<Script>>, Vec<u8>);

impl Line for Scripted {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut script = self.0.lock().unwrap();
        script.sent.push(bytes.to_vec());
        self.1.extend(script.answers.pop_front().unwrap_or_default());
        Ok(())
    }

    fn receive(&mut self, into: &mut Vec<u8>, wait: Duration) -> io::Result<bool> {
        if self.1.is_empty() {
            std::thread::sleep(wait);
        }
        into.append(&mut self.1);
        Ok(!into.is_empty())
    }

    fn drop_heard(&mut self, _: Duration) {
        self.1.clear();
    }

    fn renew(&mut self, _: Duration) {
        self.0.lock().unwrap().renewed += 1;
        self.1.clear();
    }
}

fn with(protocol: Protocol, answers: &[&[u8]]) -> (Modbus, Arc<Mutex<Script>>) {
    let script = Arc::new(Mutex::new(Script {
        answers: answers.iter().map(|answer| answer.to_vec()).collect(),
        ..Script::default()
    }));
    let line = Box::new(Scripted(Arc::clone(&script), Vec::new()));
    (Modbus::new(line, protocol, 1, Duration::from_millis(20)), script)
}

const fn tcp(transaction: u8, unit: u8, pdu: [u8; 4]) -> [u8; 11] {
    [0, transaction, 0, 0, 0, 5, unit, pdu[0], pdu[1], pdu[2], pdu[3]]
}

#[test]
fn an_answer_of_before_is_passed_over_and_the_right_one_taken() {
    let late = [tcp(0, 1, [3, 2, 0, 99]).as_slice(), &tcp(1, 1, [3, 2, 0, 250])].concat();
    let (mut modbus, script) = with(Protocol::ModbusTcp, &[&late]);
    assert_eq!(modbus.read(1, 1).unwrap(), [250]);
    assert_eq!(script.lock().unwrap().sent, [vec![0, 1, 0, 0, 0, 6, 1, 3, 0, 1, 0, 1]]);
}

#[test]
fn after_a_time_out_the_line_is_renewed_before_anything_is_asked_again() {
    let (mut modbus, script) = with(Protocol::ModbusTcp, &[&[], &tcp(2, 1, [3, 2, 0, 7])]);
    assert_eq!(modbus.read(1, 1).unwrap(), [7]);
    let script = script.lock().unwrap();
    assert_eq!((script.renewed, script.sent.len()), (1, 2));
}

#[test]
fn a_refusal_is_told_with_its_meaning_and_not_asked_again() {
    let (mut modbus, script) = with(Protocol::ModbusTcp, &[&[0, 1, 0, 0, 0, 3, 1, 0x83, 2]]);
    let told = modbus.read(2782, 2).unwrap_err().to_string();
    assert!(told.contains("refuses to read register 2782: it has no such register (exception 2)"), "{told}");
    assert_eq!(script.lock().unwrap().sent.len(), 1);
}

#[test]
fn a_controller_that_is_busy_is_asked_again() {
    let (mut modbus, _) = with(Protocol::ModbusTcp, &[&[0, 1, 0, 0, 0, 3, 1, 0x86, 6], &tcp(2, 1, [3, 2, 0, 7])]);
    assert_eq!(modbus.read(1, 1).unwrap(), [7]);
}

#[test]
fn another_unit_that_keeps_answering_is_named() {
    let of_two = [1, 2, 3].map(|transaction| tcp(transaction, 2, [3, 2, 0, 250]));
    let (mut modbus, _) = with(Protocol::ModbusTcp, &[&of_two[0], &of_two[1], &of_two[2]]);
    let told = modbus.read(1, 1).unwrap_err();
    assert!(!told.may_pass() && told.to_string().contains("unit 1 was asked and unit 2 answers"), "{told}");
}

#[test]
fn half_an_answer_is_none_and_is_told_as_such() {
    let half = &tcp(1, 1, [3, 2, 0, 250])[..9];
    let (mut modbus, _) = with(Protocol::ModbusTcp, &[half]);
    assert_eq!(modbus.read(1, 1).unwrap_err().to_string().matches("no answer to read register 1").count(), 1);
    let (mut modbus, _) = with(Protocol::ModbusRtu, &[&[1, 3], &[1, 3, 2], &[1, 3, 2, 0]]);
    let told = modbus.read(1, 1).unwrap_err();
    assert!(told.may_pass() && told.to_string().contains("only part of an answer came"), "{told}");
}

#[test]
fn an_answer_of_another_length_or_register_is_none() {
    // On a serial line nothing but its form says to what an answer belongs.
    let floats = Framing::Rtu.frame(0, 1, &[3, 4, 0, 0, 0x41, 0xC8]);
    let one = Framing::Rtu.frame(0, 1, &[3, 2, 0, 250]);
    let (mut modbus, script) = with(Protocol::ModbusRtu, &[&one, &floats]);
    assert_eq!(modbus.read(1, 2).unwrap(), [0, 0x41C8]);
    assert_eq!(script.lock().unwrap().renewed, 1);
    let elsewhere = Framing::Rtu.frame(0, 1, &[6, 0, 3, 0, 250]);
    let (mut modbus, _) = with(Protocol::ModbusRtu, &[&elsewhere, &elsewhere, &elsewhere]);
    assert!(modbus.write(2, &[250]).unwrap_err().to_string().contains("the answer is to another question"));
}

#[test]
fn one_register_is_written_by_function_6_and_two_by_16() {
    let (mut modbus, script) = with(
        Protocol::ModbusRtu,
        &[&Framing::Rtu.frame(0, 1, &[6, 0, 2, 1, 144]), &Framing::Rtu.frame(0, 1, &[16, 0, 9, 0, 2])],
    );
    modbus.write(2, &[400]).unwrap();
    modbus.write(9, &[0, 0x4220]).unwrap();
    assert_eq!(script.lock().unwrap().sent[1][..11], [1, 16, 0, 9, 0, 2, 4, 0, 0, 0x42, 0x20]);
}
