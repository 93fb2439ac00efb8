//! The folder that `calibrate` writes, read again: a calibration, the run in numbers, and the recordings of its ramps.

use std::path::Path;

use thiserror::Error;

use crate::summary::{Summary, SummaryError};
use zerorate_cal::calibration::{Calibration, CalibrationError, sha256};
use zerorate_recording::{Recording, RecordingError};
use zerorate_source::Source;

/// The calibration's file in the folder.
pub const CALIBRATION: &str = "calibration.json";
/// The summary's.
pub const SUMMARY: &str = "summary.json";
/// The page's.
pub const REPORT: &str = "report.html";
/// The certificate's.
pub const CERTIFICATE: &str = "certificate.html";
/// The recording of the full-temperature test.
pub const FULL_TEMPERATURE: &str = "full-temperature.parquet";
/// The recording of the compensation tests by the potentiometer alone.
pub const TRIM_TEST: &str = "compensation-test-trim.parquet";
/// The recording of the compensation tests by potentiometer and numbers.
pub const HYBRID_TEST: &str = "compensation-test-hybrid.parquet";

/// The files that [`BoardRun::read`] reads.
pub const FILES: [&str; 5] = [CALIBRATION, SUMMARY, FULL_TEMPERATURE, TRIM_TEST, HYBRID_TEST];

/// The label that says what became of the power between the tests; those of a simulated run have none.
pub const POWER: &str = "power";
/// Nobody was there to switch it.
pub const POWER_LEFT_ON: &str = "left on through the whole run";
/// The run was stopped, and gone on with later.
pub const POWER_UNKNOWN: &str = "not known: the run was stopped and gone on with";
/// A person has switched it.
pub const POWER_SWITCHED: &str = "switched off and on before each test";

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
    #[error("{file}: of another run than {than}: put the files of one run together")]
    Mixed {
        /// The file that does not fit.
        file: String,
        /// The one that it does not fit.
        than: &'static str,
    },
}

impl BoardRun {
    /// Whether the power was off between the tests; `None` where the run does not tell.
    #[must_use]
    pub fn was_switched(&self) -> Option<bool> {
        match self.calibration.labels.get(POWER).map(String::as_str) {
            Some(POWER_LEFT_ON) => Some(false),
            Some(POWER_SWITCHED) => Some(true),
            _ => self.summary.plant.is_some().then_some(true),
        }
    }

    /// Reads the files of a folder. The summary names every recording by its hash, the calibration those it rests on.
    ///
    /// # Errors
    /// [`BoardRunError`], when one is missing, cannot be read, or is of another run.
    pub fn read(folder: &Path) -> Result<Self, BoardRunError> {
        let source = |file: &str| Source::file(&folder.join(file));
        let mixed = |file, than| BoardRunError::Mixed { file: folder.join(file).display().to_string(), than };
        let calibration = Calibration::read(&source(CALIBRATION))?;
        let summary = Summary::read(&source(SUMMARY))?;
        let is_own = calibration.unit_serial.as_ref() == Some(&summary.serial)
            && calibration.sources.iter().all(|origin| summary.recordings.contains(origin));
        if !is_own {
            return Err(mixed(SUMMARY, CALIBRATION));
        }
        let recording = |file| {
            let recording = Recording::read(&source(file))?;
            let own = summary.recordings.iter().find(|origin| origin.file == file);
            if own.map(|origin| &origin.sha256) == sha256(&source(file)).ok().as_ref() {
                Ok(recording)
            } else {
                Err(mixed(file, SUMMARY))
            }
        };
        let full_temperature = recording(FULL_TEMPERATURE)?;
        let tests = vec![recording(TRIM_TEST)?, recording(HYBRID_TEST)?];
        Ok(Self { calibration, summary, full_temperature, tests })
    }
}
