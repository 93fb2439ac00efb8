//! A unit and what a whole run found out about it.

use zerorate_board_run::summary::{Check, Soaks};
use zerorate_core::record::{UNREADABLE, UnitSerial};

use crate::error::BenchError;
use crate::measure::Measured;
use crate::plants::PlantKind;
use crate::setup::SetUp;
use crate::verify::Verification;

/// The unit on the bench.
#[derive(Debug, Clone)]
pub struct Unit {
    /// Its serial.
    pub serial: UnitSerial,
    /// The simulated plant and its seed; `None` on a real bench.
    pub plant: Option<(PlantKind, u64)>,
}

impl Unit {
    /// A unit by its serial.
    ///
    /// # Errors
    /// [`BenchError::SerialTooLong`]; [`BenchError::SerialUnreadable`] of what a board calls itself that cannot read its own.
    pub fn new(serial: &str, plant: Option<(PlantKind, u64)>) -> Result<Self, BenchError> {
        if serial.contains(UNREADABLE) {
            return Err(BenchError::SerialUnreadable(serial.into()));
        }
        let serial = UnitSerial::try_from(serial).map_err(|_| BenchError::SerialTooLong(serial.into()))?;
        Ok(Self { serial, plant })
    }
}

/// A unit that went through everything.
#[derive(Debug, Clone)]
pub struct Calibrated {
    /// The unit.
    pub unit: Unit,
    /// The set-up.
    pub setup: SetUp,
    /// What was found out about it.
    pub measured: Measured,
    /// The compensation tests: X trim and hybrid, heating and cooling; Y the same, heating.
    pub verifications: Vec<Verification>,
    /// The traditional test beside the ramp; `None` where it was left out.
    pub soaks: Option<Soaks>,
    /// What was checked.
    pub checks: Vec<Check>,
    /// Where its ramp was not over the temperatures asked for, a sentence each; the calibration's warnings have them too.
    pub cut_short: Vec<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_has_a_serial_that_a_board_can_hold() {
        assert_eq!(Unit::new("ZR 0001", None).unwrap().serial, "ZR 0001");
        let refused = |serial: &str| Unit::new(serial, None).unwrap_err().to_string();
        assert!(refused("?").contains("write the board's serial anew"));
        assert!(refused(&"L".repeat(33)).contains("longer than the 32 bytes"));
    }
}
