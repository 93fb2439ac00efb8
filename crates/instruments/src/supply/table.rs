//! A supply as a set-up has it.

use std::fmt;

use documented::DocumentedFields;
use serde::{Deserialize, Serialize};

/// The fine supply that takes the gyros' place by remote control: a relay on its output takes them off while it is on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, DocumentedFields)]
#[serde(default, deny_unknown_fields)]
pub struct SupplyTable {
    /// The most that it may feed, volts: what the board's inputs stand.
    pub most_v: f64,
    /// How far what it measures may be from what it was set to, volts.
    pub tolerance_v: f64,
    /// Its output, where it has several and names them as (@1): 1, 2, ...; 0 where it has one.
    pub output: Output,
    /// What asks a voltmeter behind the same address for the X gyro's rate output, as MEAS:VOLT? (@2); empty without one.
    pub voltmeter_x: String,
    /// The same for the Y gyro.
    pub voltmeter_y: String,
    /// The gyros' rate output at rest where no voltmeter is asked, volts: about which the supply is varied.
    pub gyro_v: f64,
    /// How long an answer may take, milliseconds.
    pub time_out_ms: u64,
}

/// One of several outputs; 0 is the only one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Output(u8);

impl Output {
    /// As a command's last parameter: `,(@2)`, or nothing.
    pub(super) fn as_argument(self) -> String {
        if self.0 == 0 { String::new() } else { format!(",{self}") }
    }

    /// As a question's only parameter: ` (@2)`, or nothing.
    pub(super) fn alone(self) -> String {
        if self.0 == 0 { String::new() } else { format!(" {self}") }
    }
}

impl fmt::Display for Output {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "(@{})", self.0)
    }
}

impl Default for SupplyTable {
    fn default() -> Self {
        Self {
            most_v: 5.0,
            tolerance_v: 0.02,
            output: Output::default(),
            voltmeter_x: String::new(),
            voltmeter_y: String::new(),
            // The ADXRS620's null is half of its 5 V.
            gyro_v: 2.5,
            time_out_ms: 1000,
        }
    }
}

impl SupplyTable {
    /// What cannot be, in sentences.
    #[must_use]
    pub fn contradictions(&self) -> Vec<String> {
        let mut found = Vec::new();
        for (name, value) in [("most_v", self.most_v), ("tolerance_v", self.tolerance_v), ("gyro_v", self.gyro_v)] {
            if !(value > 0.0 && value.is_finite()) {
                found.push(format!("supply.{name} is {value}: it must be above 0"));
            }
        }
        if self.gyro_v > self.most_v {
            found.push(format!(
                "supply.gyro_v {} is above supply.most_v {}: it could not be fed",
                self.gyro_v, self.most_v
            ));
        }
        if self.voltmeter_x.is_empty() != self.voltmeter_y.is_empty() {
            found.push("supply.voltmeter_x and voltmeter_y belong together: give both or neither".into());
        }
        if !(50..=30_000).contains(&self.time_out_ms) {
            found.push(format!("supply.time_out_ms is {}: give 50 to 30000", self.time_out_ms));
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_supply_that_cannot_be_is_told() {
        assert_eq!(SupplyTable::default().contradictions(), Vec::<String>::new());
        let wrong = SupplyTable { most_v: f64::NAN, voltmeter_x: "READ?".into(), ..SupplyTable::default() };
        let low = SupplyTable { most_v: 2.4, gyro_v: 2.5, ..SupplyTable::default() };
        assert_eq!(low.contradictions(), ["supply.gyro_v 2.5 is above supply.most_v 2.4: it could not be fed"]);
        let told = wrong.contradictions().join("; ");
        assert!(told.contains("most_v is NaN") && told.contains("belong together"), "{told}");
    }
}
