//! A board's calibration from one recording of its ramp, without a trim experiment.
//!
//! The drift is measured; the trim is the circuit's nominal one. So the device record starts in the digital mode, which
//! leaves the potentiometer at its middle tap and subtracts the drift in numbers.

use std::collections::BTreeMap;

use zerorate_cal::calibration::{AxisCalibration, Calibration, Kind, Origin, TrimCalibration};
use zerorate_cal::log_fit::LogFit;
use zerorate_cal::recording::{Recording, RecordingInfo};
use zerorate_cal::source::Source;
use zerorate_cal::units::TemperatureUnit;
use zerorate_core::compensate::Mode;
use zerorate_core::record::MAX_RECORD_BYTES;
use zerorate_core::trim::{Trim, TrimLine};

use crate::error::BenchError;
use crate::setup::SetUp;

/// What every such calibration says.
const NO_TRIM: &str =
    "no trim experiment: the trim is the circuit's nominal one, and the device starts in mode digital";

/// The calibration that a fit makes: a board's of its recording alone, else a log's. `sources` are what was fitted; the
/// serial and the labels are a log's, for a recording has its own.
///
/// # Errors
/// [`BenchError`], when what was fitted was rejected or cannot be read any more, or a recording's set-up makes no trim.
pub fn of_fit(
    sources: &[Source],
    fit: &LogFit,
    serial: Option<String>,
    labels: BTreeMap<String, String>,
) -> Result<Calibration, BenchError> {
    if let [source] = sources
        && Recording::is_one(source)
    {
        return calibration(source, fit);
    }
    Ok(Calibration { labels, ..fit.to_calibration(fit.origins(sources)?, serial)? })
}

/// The calibration that the fit of a recording makes.
///
/// # Errors
/// [`BenchError::Rejected`], when the recording was rejected; [`BenchError`], when it cannot be read or its set-up
/// makes no trim.
pub fn calibration(recording: &Source, fit: &LogFit) -> Result<Calibration, BenchError> {
    let info = Recording::read(recording)?.info;
    let origin = Origin::of(&info.procedure, recording).map_err(|error| composed(&error))?;
    let origin = origin.started_at(info.started.map(Into::into));
    if fit.axes.is_empty() {
        return Err(BenchError::Rejected { reasons: fit.reasons().collect::<Vec<_>>().join("; ") });
    }
    let axes = fit.axes.iter().map(|axis| (axis.name.clone(), axis.calibration.clone()));
    let warnings = fit.reasons().map(str::to_owned).collect();
    of_axes(&info, axes.collect(), origin, warnings)
}

/// The calibration of a board whose axes were fitted elsewhere, from its recording's metadata.
///
/// # Errors
/// [`BenchError::Compose`], when the recording's set-up cannot be read or makes no trim.
pub fn of_axes(
    info: &RecordingInfo,
    axes: Vec<(String, AxisCalibration)>,
    origin: Origin,
    warnings: Vec<String>,
) -> Result<Calibration, BenchError> {
    let setup = SetUp::parse(&info.set_up, "in the recording").map_err(|error| composed(&error))?;
    let trim = nominal_trim(&setup)?;
    let with_trim =
        |(name, axis): (String, AxisCalibration)| (name, AxisCalibration { trim: Some(trim.clone()), ..axis });
    let serial = Some(info.unit_serial.clone()).filter(|serial| !serial.is_empty());
    let axes = axes.into_iter().map(with_trim).collect();
    Ok(Calibration {
        temperature_scale: Some(setup.temperature_scale()),
        board: Some(setup.board_scale()),
        group_period_s: Some(setup.group_period().0),
        warnings: warnings.into_iter().chain([NO_TRIM.to_owned()]).collect(),
        labels: info.labels.clone(),
        simulated: info.seed.map(|seed| format!("seed {seed}")),
        setup: serde_json::to_value(&setup).ok(),
        ..Calibration::new(Kind::AnalogueBoard, serial, vec![origin], TemperatureUnit::Counts, axes)
    })
}

/// The bytes of a calibration's device record.
///
/// # Errors
/// [`BenchError::Compose`], when it makes none.
pub fn device_record(calibration: &Calibration) -> Result<Vec<u8>, BenchError> {
    let made = calibration.to_device_record().map_err(|error| composed(&error))?;
    let mut buffer = [0; MAX_RECORD_BYTES];
    Ok(made.record.encode(&mut buffer).map_err(|error| composed(&error))?.to_vec())
}

/// The trim as the circuit's drawing has it.
fn nominal_trim(setup: &SetUp) -> Result<TrimCalibration, BenchError> {
    let line = TrimLine::new(-1.0 / setup.nominal_counts_per_tap(), 0.0, setup.centre(), setup.middle());
    let line = line.ok_or_else(|| composed(&"the set-up's board.input_volts_per_count makes no trim"))?;
    Ok(TrimCalibration {
        trim: Trim { line, measured: None },
        points: Vec::new(),
        paired: None,
        paper: None,
        dead_band_taps: setup.trim.dead_band_taps,
        low_pass: setup.low_pass(),
        start_up_mode: Mode::Digital,
    })
}

fn composed(error: &dyn std::fmt::Display) -> BenchError {
    BenchError::Compose(error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_nominal_tap_is_the_papers() {
        let trim = nominal_trim(&SetUp::paper()).unwrap();
        assert!((trim.trim.line.counts_per_tap().0 - 31.26).abs() < 0.01);
        assert_eq!(trim.start_up_mode, Mode::Digital);
    }
}
