//! The files of a run: calibration, device record, report, summary.

use zerorate_core::record::MAX_RECORD_BYTES;

use crate::calibrated::Calibrated;
use crate::error::BenchError;
use crate::output::OutputFolder;
use crate::report_view;
use crate::summary::Summary;

/// Writes the files of a run.
///
/// # Errors
/// [`BenchError`], when one cannot be made or written.
pub fn write(run: &Calibrated, summary: &Summary, output: &mut OutputFolder) -> Result<(), BenchError> {
    let composed = |error: &dyn std::fmt::Display| BenchError::Compose(error.to_string());
    let calibration = run.measured.calibration.to_json().map_err(|error| composed(&error))?;
    output.write("calibration.json", calibration.as_bytes())?;
    let mut buffer = [0; MAX_RECORD_BYTES];
    let record = run.measured.record.encode(&mut buffer).map_err(|error| composed(&error))?;
    output.write("device-record.bin", record)?;
    output.write("report.html", report_view::report(run).to_html().as_bytes())?;
    let mut summary = serde_json::to_string_pretty(summary).map_err(|error| composed(&error))?;
    summary.push('\n');
    output.write("summary.json", summary.as_bytes())
}
