//! Modbus as a client: function codes 3, 6 and 16, in TCP's frames and in those of a serial line.
//!
//! After a time-out nothing that was asked before is taken for an answer: a TCP connection is made anew and its answers carry
//! a number, a serial line is listened to until it is quiet. A set point may be sent twice, so what is not answered is asked again.

mod frame;

use std::time::{Duration, Instant};

use self::frame::{Answer, Framing};
use crate::address::Protocol;
use crate::fault::Fault;
use crate::line::Line;

/// How often something is asked before it is given up.
const TRIES: u32 = 3;
/// How long a controller that says that it is busy is let alone.
const BUSY: Duration = Duration::from_millis(300);
/// How long a serial line is quiet before the next question: an answer that comes twice is over by then. On TCP an answer has a
/// number.
const QUIET: Duration = Duration::from_millis(50);
/// Exception codes that pass: acknowledge, and busy (Modbus Application Protocol V1.1b3, chapter 7).
const PASSING: [u8; 2] = [5, 6];

/// A controller that speaks Modbus.
pub struct Modbus {
    line: Box<dyn Line>,
    framing: Framing,
    unit: u8,
    time_out: Duration,
    transaction: u16,
    /// An answer may still be under way that nobody waits for any more.
    is_stale: bool,
    answered: Option<Instant>,
}

impl Modbus {
    /// A controller on a line, by its unit number. An answer takes `time_out` at most.
    #[must_use]
    pub fn new(line: Box<dyn Line>, protocol: Protocol, unit: u8, time_out: Duration) -> Self {
        let framing = if protocol == Protocol::ModbusRtu { Framing::Rtu } else { Framing::Tcp };
        Self { line, framing, unit, time_out, transaction: 0, is_stale: false, answered: None }
    }

    /// Reads holding registers (function code 3).
    ///
    /// # Errors
    /// [`Fault`].
    pub fn read(&mut self, register: u16, count: u8) -> Result<Vec<u16>, Fault> {
        let [high, low] = register.to_be_bytes();
        let asked = || format!("read register {register}");
        let data = self.ask(&[3, high, low, 0, count], asked, |pdu| {
            // The bytes that follow, and as many.
            pdu.len() == 2 + 2 * usize::from(count) && pdu[1] == 2 * count
        })?;
        Ok(data[2..].chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect())
    }

    /// Writes registers: one by function code 6, several by 16.
    ///
    /// # Errors
    /// [`Fault`].
    pub fn write(&mut self, register: u16, values: &[u16]) -> Result<(), Fault> {
        let [high, low] = register.to_be_bytes();
        let asked = || format!("write register {register}");
        if let &[value] = values {
            let [value_high, value_low] = value.to_be_bytes();
            let request = [6, high, low, value_high, value_low];
            // The answer is the request.
            return self.ask(&request, asked, |pdu| pdu == request).map(drop);
        }
        #[allow(clippy::cast_possible_truncation)] // two registers are a temperature
        let count = values.len() as u8;
        let mut request = vec![16, high, low, 0, count, 2 * count];
        request.extend(values.iter().flat_map(|value| value.to_be_bytes()));
        let answer = [16, high, low, 0, count];
        self.ask(&request, asked, |pdu| pdu == answer).map(drop)
    }

    /// Asks, and returns the answer once it is one that fits.
    fn ask(
        &mut self,
        request: &[u8],
        asked: impl Fn() -> String,
        fits: impl Fn(&[u8]) -> bool,
    ) -> Result<Vec<u8>, Fault> {
        let mut last = None;
        for _ in 0..TRIES {
            if std::mem::take(&mut self.is_stale) {
                self.line.renew(self.time_out);
            }
            self.transaction = self.transaction.wrapping_add(1);
            match self.once(request, &asked, &fits) {
                Ok(pdu) => {
                    self.answered = Some(Instant::now());
                    return Ok(pdu);
                }
                Err(Fault::Refused { code, asked }) if PASSING.contains(&code) => {
                    std::thread::sleep(BUSY);
                    last = Some(Fault::Refused { code, asked });
                }
                Err(refused @ Fault::Refused { .. }) => return Err(refused),
                Err(fault) => {
                    self.is_stale = true;
                    last = Some(fault);
                }
            }
        }
        Err(last.unwrap_or_else(|| Fault::Silent { asked: asked(), heard: "nothing came" }))
    }

    fn once(
        &mut self,
        request: &[u8],
        asked: impl Fn() -> String,
        fits: impl Fn(&[u8]) -> bool,
    ) -> Result<Vec<u8>, Fault> {
        let is_recent = self.answered.is_some_and(|answered| answered.elapsed() < QUIET);
        let quiet = if self.framing == Framing::Rtu && is_recent { QUIET } else { Duration::ZERO };
        self.line.drop_heard(quiet);
        self.line.send(&self.framing.frame(self.transaction, self.unit, request)).map_err(Fault::Line)?;
        let deadline = Instant::now() + self.time_out;
        let mut heard = Vec::new();
        let mut what = "nothing came";
        loop {
            while let Some(answer) = self.framing.take(&mut heard) {
                match answer {
                    Answer::Damaged => what = "what came is damaged",
                    // An answer to what was asked before.
                    Answer::Whole { transaction: Some(other), .. } if other != self.transaction => {}
                    Answer::Whole { unit, .. } if unit != self.unit => {
                        return Err(Fault::OtherUnit { asked: self.unit, answered: unit });
                    }
                    Answer::Whole { pdu, .. } if pdu[0] == request[0] | 0x80 && pdu.len() == 2 => {
                        return Err(Fault::Refused { asked: asked(), code: pdu[1] });
                    }
                    Answer::Whole { pdu, .. } if pdu[0] == request[0] && fits(&pdu) => return Ok(pdu),
                    Answer::Whole { .. } => what = "the answer is to another question",
                }
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                let heard = if heard.is_empty() { what } else { "only part of an answer came" };
                return Err(Fault::Silent { asked: asked(), heard });
            }
            self.line.receive(&mut heard, left).map_err(Fault::Line)?;
        }
    }
}

#[cfg(test)]
mod tests;
