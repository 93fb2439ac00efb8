//! What stands about a request: a header on TCP, a unit and a CRC on a serial line.

/// How frames are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Framing {
    /// Modbus Messaging on TCP/IP Implementation Guide V1.0b, 3.1.3: transaction, 0, length, unit.
    Tcp,
    /// Modbus over Serial Line V1.02, 2.5.1: unit, request, CRC-16 low byte first.
    Rtu,
}

/// What was heard.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Answer {
    /// A whole frame, its CRC right. A serial line's has no transaction.
    Whole { transaction: Option<u16>, unit: u8, pdu: Vec<u8> },
    /// Bytes that are no frame.
    Damaged,
}

/// A TCP header, with the unit.
const HEADER: usize = 7;
/// The longest request or answer (Modbus Application Protocol V1.1b3, 4.1).
const LONGEST_PDU: usize = 253;

impl Framing {
    /// A request in its frame.
    pub(super) fn frame(self, transaction: u16, unit: u8, pdu: &[u8]) -> Vec<u8> {
        match self {
            Self::Tcp => {
                #[allow(clippy::cast_possible_truncation)] // requests of ours are short
                let length = (pdu.len() + 1) as u16;
                let mut frame = Vec::with_capacity(HEADER + pdu.len());
                frame.extend(transaction.to_be_bytes());
                frame.extend([0, 0]);
                frame.extend(length.to_be_bytes());
                frame.push(unit);
                frame.extend(pdu);
                frame
            }
            Self::Rtu => {
                let mut frame = vec![unit];
                frame.extend(pdu);
                frame.extend(crc16(&frame).to_le_bytes());
                frame
            }
        }
    }

    /// Takes the first frame from what was heard; `None` while it is not whole.
    pub(super) fn take(self, heard: &mut Vec<u8>) -> Option<Answer> {
        match self {
            Self::Tcp => take_tcp(heard),
            Self::Rtu => take_rtu(heard),
        }
    }
}

fn take_tcp(heard: &mut Vec<u8>) -> Option<Answer> {
    let &[t1, t0, p1, p0, l1, l0, unit, ..] = heard.as_slice() else { return None };
    let length = usize::from(u16::from_be_bytes([l1, l0]));
    if (p1, p0) != (0, 0) || !(3..=LONGEST_PDU + 1).contains(&length) {
        // There is no telling where the next frame begins.
        heard.clear();
        return Some(Answer::Damaged);
    }
    if heard.len() < HEADER - 1 + length {
        return None;
    }
    let frame: Vec<u8> = heard.drain(..HEADER - 1 + length).collect();
    Some(Answer::Whole { transaction: Some(u16::from_be_bytes([t1, t0])), unit, pdu: frame[HEADER..].to_vec() })
}

fn take_rtu(heard: &mut Vec<u8>) -> Option<Answer> {
    let &[unit, function, third, ..] = heard.as_slice() else { return None };
    // Unit, function and CRC are four bytes; an exception has one more, an echo four, what was read as many as it says.
    let length = match function {
        code if code & 0x80 != 0 => 5,
        3 => 5 + usize::from(third),
        6 | 16 => 8,
        _ => {
            heard.clear();
            return Some(Answer::Damaged);
        }
    };
    if heard.len() < length {
        return None;
    }
    let (body, crc) = heard[..length].split_at(length - 2);
    if crc16(body).to_le_bytes() != *crc {
        heard.clear();
        return Some(Answer::Damaged);
    }
    let pdu = body[1..].to_vec();
    heard.drain(..length);
    Some(Answer::Whole { transaction: None, unit, pdu })
}

/// CRC-16 of a serial line: polynomial 0xA001 (0x8005 reflected), from 0xFFFF (Modbus over Serial Line V1.02, 6.2).
fn crc16(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |crc, &byte| {
        (0..8).fold(crc ^ u16::from(byte), |crc, _| if crc & 1 == 1 { (crc >> 1) ^ 0xA001 } else { crc >> 1 })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_crc_is_that_of_the_specification() {
        // Modbus over Serial Line V1.02, 6.2.2, its example: 02 07 gives 41 12 on the line.
        assert_eq!(crc16(&[0x02, 0x07]).to_le_bytes(), [0x41, 0x12]);
        // The CRC catalogue's check value of CRC-16/MODBUS.
        assert_eq!(crc16(b"123456789"), 0x4B37);
    }

    #[test]
    fn half_a_frame_waits_for_the_rest_and_a_damaged_one_is_told() {
        for framing in [Framing::Tcp, Framing::Rtu] {
            let frame = framing.frame(7, 1, &[3, 2, 0, 250]);
            let mut heard = Vec::new();
            for &byte in &frame[..frame.len() - 1] {
                heard.push(byte);
                assert_eq!(framing.take(&mut heard), None, "{framing:?}");
            }
            heard.push(frame[frame.len() - 1]);
            let Some(Answer::Whole { unit: 1, pdu, .. }) = framing.take(&mut heard) else { panic!("{framing:?}") };
            assert_eq!((pdu.as_slice(), heard.len()), ([3, 2, 0, 250].as_slice(), 0));
        }
        let mut frame = Framing::Rtu.frame(0, 1, &[3, 2, 0, 250]);
        frame[4] ^= 1;
        assert_eq!(Framing::Rtu.take(&mut frame), Some(Answer::Damaged));
        assert_eq!(Framing::Tcp.take(&mut vec![0, 1, 9, 9, 0, 3, 1, 3, 0]), Some(Answer::Damaged));
    }
}
