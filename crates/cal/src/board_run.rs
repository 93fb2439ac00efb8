//! The folder that `calibrate` writes, read again: a calibration, the run in numbers, and the recordings of its ramps.

use std::path::Path;

use thiserror::Error;

use crate::calibration::{Calibration, CalibrationError, sha256};
use crate::recording::{Recording, RecordingError};
use crate::source::Source;
use crate::summary::{Summary, SummaryError};

/// The calibration's file in the folder.
pub const CALIBRATION: &str = "calibration.json";
/// The summary's.
pub const SUMMARY: &str = "summary.json";
/// The page's.
pub const REPORT: &str = "report.html";
/// The recording of the full-temperature test.
pub const FULL_TEMPERATURE: &str = "full-temperature.parquet";
/// The recording of the compensation tests by the potentiometer alone.
pub const TRIM_TEST: &str = "compensation-test-trim.parquet";
/// The recording of the compensation tests by potentiometer and numbers.
pub const HYBRID_TEST: &str = "compensation-test-hybrid.parquet";

/// A board's run.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardRun {
    /// What was fitted.
    pub calibration: Calibration,
    /// What was tested.
    pub summary: Summary,
    /// The full-temperature test.
    pub full_temperature: Recording,
    /// The compensation tests.
    pub tests: Vec<Recording>,
}

/// Why a run cannot be read.
#[derive(Debug, Error)]
pub enum BoardRunError {
    /// The calibration.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// The summary.
    #[error(transparent)]
    Summary(#[from] SummaryError),
    /// A recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The files are not of one run.
    #[error("{folder}: {CALIBRATION} was made from another {file}: put the files of one run together")]
    Mixed {
        /// The folder.
        folder: String,
        /// The file that does not fit.
        file: &'static str,
    },
}

impl BoardRun {
    /// Reads the files of a folder.
    ///
    /// # Errors
    /// [`BoardRunError`], when one is missing, cannot be read, or is of another run.
    pub fn read(folder: &Path) -> Result<Self, BoardRunError> {
        let source = |file: &str| Source::file(&folder.join(file));
        let recording = |file| Recording::read(&source(file));
        let calibration = Calibration::read(&source(CALIBRATION))?;
        let summary = Summary::read(&source(SUMMARY))?;
        let mixed = |file| BoardRunError::Mixed { folder: folder.display().to_string(), file };
        if calibration.unit_serial.as_ref() != Some(&summary.serial) {
            return Err(mixed(SUMMARY));
        }
        let full_temperature = recording(FULL_TEMPERATURE)?;
        let own = calibration.sources.iter().find(|origin| origin.file == FULL_TEMPERATURE);
        if own.map(|origin| &origin.sha256) != sha256(&source(FULL_TEMPERATURE)).ok().as_ref() {
            return Err(mixed(FULL_TEMPERATURE));
        }
        let tests = vec![recording(TRIM_TEST)?, recording(HYBRID_TEST)?];
        Ok(Self { calibration, summary, full_temperature, tests })
    }
}
