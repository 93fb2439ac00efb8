//! The chamber of a virtual board as a controller that speaks Modbus: control loop 1 of a Watlow F4T.
//!
//! Decoded from the specification and not from our client, so that two readings of it meet.

use zerorate_core::units::Celsius;
use zerorate_sim::SharedPlant;

/// Registers: process value, set point (floats, low word first) and mode (Espec North America, watlowf4t.py).
const PROCESS_VALUE: u16 = 2820;
const SET_POINT: u16 = 2782;
const MODE: u16 = 2730;
/// The mode in which the loop regulates.
const AUTO: u16 = 10;
/// Exceptions: no such function, register, value (Modbus Application Protocol V1.1b3, chapter 7).
const NO_FUNCTION: u8 = 1;
const NO_REGISTER: u8 = 2;
const NO_VALUE: u8 = 3;

/// A controller.
pub(super) struct Controller {
    set_point: f32,
    mode: u16,
    is_serial: bool,
}

impl Controller {
    /// One on TCP, or on a serial line.
    pub(super) fn new(plant: &SharedPlant, is_serial: bool) -> Self {
        #[allow(clippy::cast_possible_truncation)] // as a controller has it
        let set_point = plant.borrow().chamber_air().0 as f32;
        Self { set_point, mode: AUTO, is_serial }
    }

    /// Takes whole frames from what has come and answers them.
    pub(super) fn hear(&mut self, incoming: &mut Vec<u8>, plant: &SharedPlant) -> Vec<u8> {
        let mut said = Vec::new();
        while let Some(length) = if self.is_serial { rtu_length(incoming) } else { tcp_length(incoming) } {
            let frame: Vec<u8> = incoming.drain(..length).collect();
            if self.is_serial {
                let (body, crc) = frame.split_at(length - 2);
                if crc16(body).to_le_bytes() != *crc {
                    incoming.clear();
                    break;
                }
                let mut answer = vec![body[0]];
                answer.extend(self.answer(&body[1..], plant));
                answer.extend(crc16(&answer).to_le_bytes());
                said.extend(answer);
            } else {
                let answer = self.answer(&frame[7..], plant);
                said.extend(&frame[..4]);
                said.extend(u16::try_from(answer.len() + 1).unwrap_or_default().to_be_bytes());
                said.push(frame[6]);
                said.extend(answer);
            }
        }
        said
    }

    fn answer(&mut self, request: &[u8], plant: &SharedPlant) -> Vec<u8> {
        let function = request[0];
        self.obey(request, plant).unwrap_or_else(|exception| vec![function | 0x80, exception])
    }

    fn obey(&mut self, request: &[u8], plant: &SharedPlant) -> Result<Vec<u8>, u8> {
        let word = |at: usize| {
            let pair = request.get(at..at + 2).ok_or(NO_VALUE)?;
            Ok::<u16, u8>(u16::from_be_bytes([pair[0], pair[1]]))
        };
        let register = word(1)?;
        match request[0] {
            3 => {
                let count = word(3)?;
                let mut answer = vec![3, u8::try_from(2 * count).map_err(|_| NO_VALUE)?];
                for at in register..register.saturating_add(count) {
                    answer.extend(self.read(at, plant)?.to_be_bytes());
                }
                Ok(answer)
            }
            6 if register == MODE => {
                self.mode = word(3)?;
                Ok(request.to_vec())
            }
            16 if register == SET_POINT && word(3)? == 2 => {
                let to = f32::from_bits(u32::from(word(8)?) << 16 | u32::from(word(6)?));
                let sent = plant.borrow_mut().chamber_set_point(Celsius(f64::from(to)));
                sent.map_err(|_| NO_VALUE)?;
                self.set_point = to;
                Ok(request[..5].to_vec())
            }
            6 | 16 => Err(NO_REGISTER),
            _ => Err(NO_FUNCTION),
        }
    }

    fn read(&self, register: u16, plant: &SharedPlant) -> Result<u16, u8> {
        #[allow(clippy::cast_possible_truncation)] // as a controller has it
        let air = plant.borrow().chamber_air().0 as f32;
        let low_first = |value: f32, at: u16| {
            let [b3, b2, b1, b0] = value.to_bits().to_be_bytes();
            u16::from_be_bytes(if at == 0 { [b1, b0] } else { [b3, b2] })
        };
        match register {
            MODE => Ok(self.mode),
            SET_POINT | 2783 => Ok(low_first(self.set_point, register - SET_POINT)),
            PROCESS_VALUE | 2821 => Ok(low_first(air, register - PROCESS_VALUE)),
            _ => Err(NO_REGISTER),
        }
    }
}

/// The length of the first frame, once it is whole: a header of six bytes, the last two its length.
fn tcp_length(heard: &[u8]) -> Option<usize> {
    let length = 6 + usize::from(u16::from_be_bytes([*heard.get(4)?, *heard.get(5)?]));
    (heard.len() >= length.max(8)).then_some(length.max(8))
}

/// The same on a serial line: a read or a single write is 8 bytes, several registers 9 and their own.
fn rtu_length(heard: &[u8]) -> Option<usize> {
    let length = match heard.get(1)? {
        16 => 9 + usize::from(*heard.get(6)?),
        _ => 8,
    };
    (heard.len() >= length).then_some(length)
}

/// CRC-16 by the table-less way of the specification's appendix, bit by bit.
fn crc16(bytes: &[u8]) -> u16 {
    let mut crc = u16::MAX;
    for &byte in bytes {
        crc ^= u16::from(byte);
        for _ in 0..8 {
            let carry = crc & 1 != 0;
            crc >>= 1;
            if carry {
                crc ^= 0xA001;
            }
        }
    }
    crc
}
