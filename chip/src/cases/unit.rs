//! The serial that whoever builds a board writes beside the program.

use anyhow::{Result, ensure};
use zerorate_core::wire::CalibrationState;

use super::{Given, paper};
use crate::bench::Bench;
use crate::chip::time::SECOND;

/// The serial is the one that is written; without one any record is taken, and what is no serial is no record's.
pub fn sector(given: &Given) -> Result<String> {
    let own = given.record.unit.as_str();
    let longest = "L".repeat(32);
    let places: [(&[u8], &str, CalibrationState); 11] = [
        (own.as_bytes(), own, CalibrationState::InUse),
        (&[own.as_bytes(), b"\n"].concat(), own, CalibrationState::InUse),
        (b"", "", CalibrationState::InUse),
        (longest.as_bytes(), &longest, CalibrationState::OtherUnit),
        (&[longest.as_bytes(), b"L"].concat(), "?", CalibrationState::OtherUnit),
        (b"ZR 1", "ZR 1", CalibrationState::OtherUnit),
        (&[0x80, 7, b'Z'], "??Z", CalibrationState::OtherUnit),
        (&[0; 40], "?", CalibrationState::OtherUnit),
        (&[b"\r\n", own.as_bytes()].concat(), "?", CalibrationState::OtherUnit),
        // Letters of 16 bits, as some shells write them, and a text four bytes too far.
        (b"\xFF\xFEZ\0R\0-\x001\0", "?", CalibrationState::OtherUnit),
        (&[&[0xFF; 4], own.as_bytes()].concat(), "?", CalibrationState::OtherUnit),
    ];
    for (written, serial, state) in places {
        let mut bench = Bench::new(&given.image.clone().with_serial(written), paper(), Some(&given.records))?;
        bench.pass(SECOND / 10)?;
        let identity = bench.identify()?;
        ensure!(identity.unit == serial && identity.calibration == state, "{written:?}: {identity:?}");
        bench.nothing_wrong()?;
    }
    Ok(format!(
        "{} places: as it is written, with an end of line, none, the longest, too long, no text, none at its beginning",
        places.len()
    ))
}
