//! The files of a run: calibration, device record, summary, and the page made of them.

use std::path::Path;

use zerorate_cal::board_run::{BoardRun, CALIBRATION, REPORT, SUMMARY};
use zerorate_cal::calibration::Calibration;
use zerorate_cal::source::Source;
use zerorate_cal::summary::Summary;
use zerorate_core::record::{DeviceRecord, MAX_RECORD_BYTES};
use zerorate_report::board_page;

use crate::calibrated::Unit;
use crate::error::BenchError;
use crate::output::OutputFolder;

/// Refuses a folder with the results of another unit. A simulated unit is another for each plant and seed, and no real one.
///
/// # Errors
/// [`BenchError::OthersResults`].
pub fn refuse_others(folder: &Path, unit: &Unit) -> Result<(), BenchError> {
    let of = |file: &str| Source::file(&folder.join(file));
    let own = described(unit.serial.as_str(), unit.plant.map(|(kind, seed)| (kind.name(), seed)));
    let whose = if let Ok(earlier) = Summary::read(&of(SUMMARY)) {
        described(&earlier.serial, earlier.plant.as_deref().zip(earlier.seed))
    } else {
        // Of a version that wrote less: the serial is all that is known.
        match Calibration::read(&of(CALIBRATION)) {
            Ok(Calibration { unit_serial: Some(serial), .. }) if serial != unit.serial.as_str() => {
                described(&serial, None)
            }
            _ => return Ok(()),
        }
    };
    if whose == own { Ok(()) } else { Err(BenchError::OthersResults { folder: folder.display().to_string(), whose }) }
}

fn described(serial: &str, plant: Option<(&str, u64)>) -> String {
    plant.map_or_else(
        || format!("unit {serial}"),
        |(plant, seed)| format!("the simulated unit {serial} (plant {plant}, seed {seed})"),
    )
}

/// Writes the files of a run whose recordings are finished.
///
/// # Errors
/// [`BenchError`], when one cannot be made or written.
pub fn write(
    calibration: &Calibration,
    record: &DeviceRecord,
    summary: &Summary,
    output: &mut OutputFolder,
) -> Result<(), BenchError> {
    let composed = |error: &dyn std::fmt::Display| BenchError::Compose(error.to_string());
    let calibration = calibration.to_json().map_err(|error| composed(&error))?;
    output.write(CALIBRATION, calibration.as_bytes())?;
    let mut buffer = [0; MAX_RECORD_BYTES];
    let record = record.encode(&mut buffer).map_err(|error| composed(&error))?;
    output.write("device-record.bin", record)?;
    let mut summary = serde_json::to_string_pretty(summary).map_err(|error| composed(&error))?;
    summary.push('\n');
    output.write(SUMMARY, summary.as_bytes())?;
    // From the files, as `report` makes it again.
    let page = board_page(&BoardRun::read(output.in_progress())?);
    output.write(REPORT, page.as_bytes())
}
