//! The files of a run: calibration, device record, report, summary.

use zerorate_cal::calibration::{AxisCalibration, CREATED_BY, Calibration, Kind, ResidualOver, TrimCalibration};
use zerorate_cal::quality::TemperatureUnit;
use zerorate_core::record::MAX_RECORD_BYTES;
use zerorate_core::units::{Axis, TemperatureScale};

use crate::calibrated::Calibrated;
use crate::error::BenchError;
use crate::output::OutputFolder;
use crate::story;
use crate::summary::Summary;

/// Writes the files of a run.
///
/// # Errors
/// [`BenchError`], when one cannot be made or written.
pub fn write(run: &Calibrated, summary: &Summary, output: &mut OutputFolder) -> Result<(), BenchError> {
    let composed = |error: &dyn std::fmt::Display| BenchError::Compose(error.to_string());
    let calibration = calibration(run).to_json().map_err(|error| composed(&error))?;
    output.write("calibration.json", calibration.as_bytes())?;
    let mut buffer = [0; MAX_RECORD_BYTES];
    let record = run.character.record.encode(&mut buffer).map_err(|error| composed(&error))?;
    output.write("device-record.bin", record)?;
    output.write("report.html", story::report(run).to_html().as_bytes())?;
    let mut summary = serde_json::to_string_pretty(summary).map_err(|error| composed(&error))?;
    summary.push('\n');
    output.write("summary.json", summary.as_bytes())
}

/// The calibration file of a run.
fn calibration(run: &Calibrated) -> Calibration {
    let axes = Axis::BOTH.map(|axis| {
        let character = &run.character.axes[axis.index()];
        let model = &character.composed.model;
        let trim = TrimCalibration {
            trim: model.trim.clone(),
            better: Some(character.trim.better),
            paper: Some(character.trim.paper),
            dead_band_taps: model.dead_band,
            low_pass: model.low_pass,
            start_up_mode: model.start_up_mode,
        };
        let drift = AxisCalibration::of_fit(&character.drift, ResidualOver::Groups);
        (axis.name().to_owned(), AxisCalibration { trim: Some(trim), ..drift })
    });
    Calibration {
        kind: Kind::AnalogueBoard,
        unit_serial: Some(run.unit.serial.to_string()),
        created_by: CREATED_BY.to_owned(),
        sources: run.sources.clone(),
        temperature_unit: TemperatureUnit::Counts,
        temperature_scale: Some(TemperatureScale::QUARTER_COUNTS),
        group_period_s: Some(run.setup.group_period().0),
        axes: axes.into_iter().collect(),
        warnings: run.character.warnings.clone(),
        setup: serde_json::to_value(&run.setup).ok(),
    }
}
