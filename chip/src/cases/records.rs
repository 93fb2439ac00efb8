//! Records that cannot be used: in flash as the board starts, and over the line.

use anyhow::{Result, ensure};
use zerorate_core::compensate::CurveNumbers;
use zerorate_core::record::{DeviceRecord, RECORD_VERSION, RecordError, UnitSerial};
use zerorate_core::wire::{Answer, CalibrationState, Refusal, ResetCause};

use super::{Given, paper, wipers};
use crate::bench::Bench;
use crate::chip::time::SECOND;
use crate::deployment::encoded;
use crate::native;

/// A board whose flash holds what it cannot use says so, at the middle taps, and takes a record that it can; what it cannot use
/// is refused over the line, too, and the record before it stays.
fn refused(given: &Given, flash: &[u8], state: CalibrationState, offered: &[u8], refusal: Refusal) -> Result<()> {
    let mut bench = Bench::new(&given.image, paper(), Some(flash))?;
    bench.pass(SECOND / 10)?;
    let identity = bench.identify()?;
    ensure!(identity.calibration == state && !identity.running, "{identity:?}");
    ensure!(identity.reset == ResetCause::Power && wipers(&bench) == [511; 2], "{identity:?}");
    bench.deploy(&given.record)?;
    ensure!(bench.identify()?.calibration == CalibrationState::InUse);
    let answer = bench.offer(offered)?;
    ensure!(answer == Answer::Refused(refusal), "{answer:?}");
    bench.power_cycle()?;
    bench.pass(SECOND / 10)?;
    let identity = bench.identify()?;
    ensure!(identity.calibration == CalibrationState::InUse && identity.running, "{identity:?}");
    bench.nothing_wrong()
}

/// The same of a record's bytes that are whole, in flash and over the line.
fn whole(given: &Given, bytes: &[u8], state: CalibrationState, refusal: Refusal) -> Result<()> {
    refused(given, &native::stored(bytes)?, state, bytes, refusal)
}

/// A bit of the flash, and a byte bent on its way.
pub fn damaged(given: &Given) -> Result<String> {
    // Somewhere within the record's pieces: it has some 2 KiB at the beginning of a sector.
    let mut flash = given.records.clone();
    flash[400] ^= 0x10;
    let mut bytes = encoded(&given.record)?;
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    refused(given, &flash, CalibrationState::Damaged, &bytes, Refusal::Record(RecordError::Damaged))?;
    Ok("a bit of the flash: Damaged, at the middle taps, and it takes another; bent on its way: refused, the one before stays".into())
}

/// A record of another serial than the image was built for.
pub fn another_unit(given: &Given) -> Result<String> {
    let unit = UnitSerial::try_from("ZR-2").unwrap_or_default();
    let other = DeviceRecord { unit, ..given.record.clone() };
    whole(given, &encoded(&other)?, CalibrationState::OtherUnit, Refusal::OtherUnit)?;
    Ok(format!("{} on a board that is {}: told and not run, refused over the line", other.unit, given.record.unit))
}

/// A record of a version to come.
pub fn unknown_version(given: &Given) -> Result<String> {
    let found = RECORD_VERSION + 1;
    let mut bytes = encoded(&given.record)?;
    bytes[4..6].copy_from_slice(&found.to_le_bytes());
    let refusal = Refusal::Record(RecordError::UnknownVersion { found });
    whole(given, &bytes, CalibrationState::UnknownVersion { found }, refusal)?;
    Ok(format!("version {found}: told with its number and not run, refused over the line"))
}

/// Records that are whole, and whose numbers make no law, or not the law that their table of edges was solved for.
pub fn no_law(given: &Given) -> Result<String> {
    let mut without_a_range = given.record.clone();
    let drift = &mut without_a_range.axes[0].law.drift;
    drift.last = drift.first;
    let mut another = given.record.clone();
    if let CurveNumbers::Polynomial(curve) = &mut another.axes[1].law.drift.curve {
        // By three counts: a tenth of a tap.
        curve.coefficients[0] -= 3 << curve.fraction_bits;
    }
    for record in [without_a_range, another] {
        ensure!(record != given.record, "the record has no polynomial");
        whole(given, &encoded(&record)?, CalibrationState::LawRefused, Refusal::LawRefused)?;
    }
    Ok("a range of one code, and a drift 3 counts beside its edges: told and not run, refused over the line".into())
}
