//! The files of a run: calibration, device record, summary, and the pages made of them.

use std::fmt;
use std::path::Path;

use zerorate_board_run::folder::{BoardRun, CALIBRATION, CERTIFICATE, FILES, FULL_TEMPERATURE, REPORT, SUMMARY};
use zerorate_board_run::summary::Summary;
use zerorate_cal::calibration::Calibration;
use zerorate_cal::recording::Recording;
use zerorate_cal::source::Source;
use zerorate_core::record::{DeviceRecord, MAX_RECORD_BYTES};
use zerorate_report::{board_page, certificate};

use crate::calibrated::Unit;
use crate::error::BenchError;
use crate::output::OutputFolder;

/// The record as a device keeps it.
const DEVICE_RECORD: &str = "device-record.bin";
/// The recording of the trim experiment.
pub(crate) const TRIM_SWEEP: &str = "trim-sweep.parquet";
/// The recording of the soaks.
pub(crate) const SOAKS: &str = "soaks.parquet";

/// The names of a run's files that are no recordings read again ([`FILES`]).
const OTHER_FILES: [&str; 5] = [REPORT, CERTIFICATE, DEVICE_RECORD, TRIM_SWEEP, SOAKS];

/// Refuses a folder in which a run would take the place of another unit's results or of what is no run's. A simulated unit
/// is another for each plant and seed. `force` gives these up, but for a real unit's, in whose place no simulated ones go.
///
/// # Errors
/// [`BenchError::RealResults`], [`BenchError::OthersResults`], [`BenchError::NoRuns`].
pub fn refuse_others(folder: &Path, unit: &Unit, force: bool) -> Result<(), BenchError> {
    let shown = || folder.display().to_string();
    let own = Whose::new(unit.serial.as_str(), unit.plant.map(|(kind, seed)| (Some(kind.name()), seed)));
    match Whose::of(folder) {
        Some(whose) if whose.is(&own) => Ok(()),
        Some(whose) if whose.simulated.is_none() && own.simulated.is_some() => {
            Err(BenchError::RealResults { folder: shown(), serial: whose.serial })
        }
        Some(whose) if !force => Err(BenchError::OthersResults { folder: shown(), whose: whose.to_string() }),
        None if !force => match FILES.iter().chain(&OTHER_FILES).find(|file| folder.join(file).exists()) {
            Some(file) => Err(BenchError::NoRuns { file: folder.join(file).display().to_string() }),
            None => Ok(()),
        },
        Some(_) | None => Ok(()),
    }
}

/// Whose results a folder holds.
struct Whose {
    serial: String,
    /// The plant, where it is known, and the seed.
    simulated: Option<(Option<String>, u64)>,
}

impl Whose {
    fn new(serial: &str, simulated: Option<(Option<&str>, u64)>) -> Self {
        let simulated = simulated.map(|(plant, seed)| (plant.map(str::to_owned), seed));
        Self { serial: serial.to_owned(), simulated }
    }

    /// Of a folder with a run in it. A version that wrote another summary is known by its recording.
    fn of(folder: &Path) -> Option<Self> {
        let source = |file: &str| Source::file(&folder.join(file));
        if let Ok(Summary { serial, plant, seed, .. }) = Summary::read(&source(SUMMARY)) {
            return Some(Self { serial, simulated: seed.map(|seed| (plant, seed)) });
        }
        let info = Recording::read(&source(FULL_TEMPERATURE)).ok()?.info;
        Some(Self { serial: info.unit_serial, simulated: info.seed.map(|seed| (None, seed)) })
    }

    /// The same unit, as far as both know.
    fn is(&self, other: &Self) -> bool {
        let of_seed = |simulated: &Option<(Option<String>, u64)>| simulated.as_ref().map(|(_, seed)| *seed);
        let plant = |simulated: &Option<(Option<String>, u64)>| simulated.as_ref().and_then(|(plant, _)| plant.clone());
        let plants_agree = plant(&self.simulated).zip(plant(&other.simulated)).is_none_or(|(own, other)| own == other);
        self.serial == other.serial && of_seed(&self.simulated) == of_seed(&other.simulated) && plants_agree
    }
}

impl fmt::Display for Whose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { serial, simulated } = self;
        match simulated {
            None => write!(f, "unit {serial}"),
            Some((None, seed)) => write!(f, "the simulated unit {serial} (seed {seed})"),
            Some((Some(plant), seed)) => write!(f, "the simulated unit {serial} (plant {plant}, seed {seed})"),
        }
    }
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
    output.write(DEVICE_RECORD, record)?;
    let mut summary = serde_json::to_string_pretty(summary).map_err(|error| composed(&error))?;
    summary.push('\n');
    output.write(SUMMARY, summary.as_bytes())?;
    // From the files, as `report` makes it again.
    let run = BoardRun::read(output.in_progress())?;
    output.write(REPORT, board_page(&run, None).as_bytes())?;
    output.write(CERTIFICATE, certificate(&run).as_bytes())
}
