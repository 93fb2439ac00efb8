//! The files of a run: calibration, device record, summary, and the page made of them.

use zerorate_cal::board_run::{BoardRun, CALIBRATION, REPORT, SUMMARY};
use zerorate_cal::calibration::Calibration;
use zerorate_cal::summary::Summary;
use zerorate_core::record::{DeviceRecord, MAX_RECORD_BYTES};
use zerorate_report::board_page;

use crate::error::BenchError;
use crate::output::OutputFolder;

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
