//! The fine supply and the voltmeter of a virtual board as an instrument that speaks SCPI.
//!
//! Output 1 is the supply, and takes the gyros' place while it is on; (@2) and (@3) are the voltmeter at the X and the Y gyro.

use zerorate_core::units::{Axis, Volts};
use zerorate_sim::SharedPlant;

/// The most that it gives, volts.
const MOST_V: f64 = 20.0;
/// What the board's inputs take of it, amperes: they are high-ohmic.
const LOAD_A: f64 = 0.000_1;

/// A supply.
pub(super) struct FineSupply {
    volts: f64,
    limit_a: f64,
    is_on: bool,
    /// The error queue.
    errors: Vec<&'static str>,
}

impl FineSupply {
    pub(super) const fn new() -> Self {
        Self { volts: 0.0, limit_a: 0.1, is_on: false, errors: Vec::new() }
    }

    /// Takes whole lines from what has come and answers what are questions.
    pub(super) fn hear(&mut self, incoming: &mut Vec<u8>, plant: &SharedPlant) -> Vec<u8> {
        let mut said = String::new();
        while let Some(end) = incoming.iter().position(|&byte| byte == b'\n') {
            let line: Vec<u8> = incoming.drain(..=end).collect();
            let line = String::from_utf8_lossy(&line).trim().to_uppercase();
            if let Some(answer) = self.obey(&line, plant) {
                said += &answer;
                said.push('\n');
            }
        }
        said.into_bytes()
    }

    fn obey(&mut self, line: &str, plant: &SharedPlant) -> Option<String> {
        let (header, parameter) = line.split_once(' ').unwrap_or((line, ""));
        let parameter = parameter.trim();
        match (header.trim_start_matches(':'), parameter) {
            ("*IDN?", _) => return Some(concat!("Zerorate,virtual supply,0,", env!("CARGO_PKG_VERSION")).into()),
            ("SYST:ERR?", _) => {
                let first = if self.errors.is_empty() { "0,\"No error\"" } else { self.errors.remove(0) };
                return Some(first.into());
            }
            ("MEAS:VOLT?", "(@2)") => return Some(voltmeter(plant, Axis::X)),
            ("MEAS:VOLT?", "(@3)") => return Some(voltmeter(plant, Axis::Y)),
            ("MEAS:VOLT?", _) => return Some(format!("{:.6}", if self.is_on { self.volts } else { 0.0 })),
            ("MEAS:CURR?", _) => return Some(format!("{:.6}", if self.is_on { LOAD_A } else { 0.0 })),
            ("VOLT?", _) => return Some(format!("{:.6}", self.volts)),
            ("CURR?", _) => return Some(format!("{:.6}", self.limit_a)),
            ("OUTP?", _) => return Some(u8::from(self.is_on).to_string()),
            ("VOLT", number) => match number.parse::<f64>() {
                Ok(volts) if (0.0..=MOST_V).contains(&volts) => self.volts = volts,
                _ => self.errors.push("-222,\"Data out of range\""),
            },
            ("OUTP", "ON" | "1") => self.is_on = true,
            ("OUTP", "OFF" | "0") => self.is_on = false,
            ("*RST", _) => *self = Self::new(),
            ("*CLS", _) => self.errors.clear(),
            _ => self.errors.push("-113,\"Undefined header\""),
        }
        if self.is_on {
            plant.borrow_mut().connect_supply(Volts(self.volts));
        } else {
            plant.borrow_mut().connect_gyro();
        }
        None
    }
}

fn voltmeter(plant: &SharedPlant, axis: Axis) -> String {
    format!("{:.6}", plant.borrow().rate_volts(axis).0)
}
