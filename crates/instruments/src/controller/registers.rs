//! A controller by its registers.

use super::Speech;
use super::form::{Form, WordOrder};
use super::table::Registers;
use crate::fault::Fault;
use crate::modbus::Modbus;

/// What controllers put into a register when a sensor is broken lies this near to the ends of an i16: 32767, 32766, -32768.
const NEAR_THE_END: i16 = 32_760;
/// No sensor is so near to 0: the words of an ordinary temperature, taken in the other order, mostly are (25.0 is 2e-41).
const NEARLY_NOTHING: f32 = 1e-6;
/// A float's last digit that is told: controllers show tenths, and keep hundredths.
const FLOAT_RESOLUTION: f64 = 0.02;

/// A controller by its registers.
pub(super) struct ByRegisters {
    modbus: Modbus,
    registers: Registers,
    /// Whether its register for running and stopping has said that it runs: not every one can be read, or keeps what was written.
    tells: bool,
}

impl ByRegisters {
    pub(super) const fn new(modbus: Modbus, registers: Registers) -> Self {
        Self { modbus, registers, tells: false }
    }

    fn read(&mut self, register: u16) -> Result<f64, Fault> {
        match self.registers.form {
            Form::I16 => {
                let raw = self.modbus.read(register, 1)?[0].cast_signed();
                if raw >= NEAR_THE_END || raw <= -NEAR_THE_END {
                    return Err(Fault::NoTemperature { what: "a register", raw: raw.to_string() });
                }
                Ok(f64::from(raw) / self.registers.scale)
            }
            Form::F32 => {
                let words = self.modbus.read(register, 2)?;
                Ok(f64::from(float([words[0], words[1]], self.registers.word_order)?) / self.registers.scale)
            }
        }
    }
}

fn float(words: [u16; 2], order: WordOrder) -> Result<f32, Fault> {
    let (high, low) = match order {
        WordOrder::HighFirst => (words[0], words[1]),
        WordOrder::LowFirst => (words[1], words[0]),
    };
    let value = f32::from_bits(u32::from(high) << 16 | u32::from(low));
    if value != 0.0 && value.abs() < NEARLY_NOTHING {
        return Err(Fault::NoTemperature { what: "a pair of registers", raw: format!("{value:e}") });
    }
    Ok(value)
}

const fn halves(bits: u32) -> [[u8; 2]; 2] {
    let [b3, b2, b1, b0] = bits.to_be_bytes();
    [[b3, b2], [b1, b0]]
}

impl Speech for ByRegisters {
    fn actual(&mut self) -> Result<f64, Fault> {
        self.read(self.registers.actual)
    }

    fn set_point(&mut self) -> Result<f64, Fault> {
        self.read(self.registers.set_point)
    }

    fn send(&mut self, value: f64) -> Result<(), Fault> {
        let scaled = value * self.registers.scale;
        let words = match self.registers.form {
            Form::I16 => {
                let end = f64::from(NEAR_THE_END);
                if !(-end..=end).contains(&scaled) {
                    let least = -end / self.registers.scale;
                    return Err(Fault::OutsideLimits {
                        what: "in one register",
                        value,
                        least,
                        most: -least,
                        limit: "chamber.controller.scale",
                    });
                }
                #[allow(clippy::cast_possible_truncation)] // within an i16, as was seen
                let raw = scaled.round() as i16;
                vec![raw.cast_unsigned()]
            }
            Form::F32 => {
                #[allow(clippy::cast_possible_truncation)] // a hundredth of a degree needs 15 bits of 24
                let bits = (scaled as f32).to_bits();
                let [[b3, b2], [b1, b0]] = halves(bits);
                let (high, low) = (u16::from_be_bytes([b3, b2]), u16::from_be_bytes([b1, b0]));
                match self.registers.word_order {
                    WordOrder::HighFirst => vec![high, low],
                    WordOrder::LowFirst => vec![low, high],
                }
            }
        };
        self.modbus.write(self.registers.set_point, &words)
    }

    fn run(&mut self) -> Result<(), Fault> {
        let Some((register, value)) = self.registers.run else { return Ok(()) };
        self.modbus.write(register, &[value])?;
        let is_its_stop = self.registers.stop.is_some_and(|(other, _)| other == register);
        self.tells = is_its_stop && self.modbus.read(register, 1).is_ok_and(|words| words[0] == value);
        Ok(())
    }

    fn stop(&mut self) -> Result<(), Fault> {
        self.registers.stop.map_or(Ok(()), |(register, value)| self.modbus.write(register, &[value]))
    }

    fn stopped(&mut self) -> Result<Option<bool>, Fault> {
        let (Some((register, run)), Some((_, stop)), true) = (self.registers.run, self.registers.stop, self.tells)
        else {
            return Ok(None);
        };
        let is = self.modbus.read(register, 1)?[0];
        Ok([(stop, true), (run, false)].into_iter().find_map(|(value, stopped)| (value == is).then_some(stopped)))
    }

    fn resolution(&self) -> f64 {
        match self.registers.form {
            Form::I16 => 1.0 / self.registers.scale,
            Form::F32 => FLOAT_RESOLUTION,
        }
    }

    fn identity(&mut self) -> Result<Option<String>, Fault> {
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 25.0 is 0x41C8_0000 by IEEE 754, and -10.0 is 0xC120_0000.
    #[test]
    fn a_temperature_in_the_other_word_order_is_none() {
        for (words, celsius) in [([0x41C8, 0], 25.0), ([0xC120, 0], -10.0), ([0, 0], 0.0)] {
            assert!((float(words, WordOrder::HighFirst).unwrap() - celsius).abs() < 1e-6);
        }
        for words in [[0x41C8, 0], [0xC120, 0]] {
            let told = float(words, WordOrder::LowFirst).unwrap_err().to_string();
            assert!(told.contains("no temperature of a chamber") && told.contains("word_order"), "{told}");
        }
    }
}
