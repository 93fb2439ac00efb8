//! `lot export`: the calibration and the device record of one unit.
//!
//! The row says which recording and which model; the recording is fitted again by the code of `zerorate fit`, so that the
//! files are the same to the bit, and the fit must agree with the row.

use std::fs;
use std::path::{Path, PathBuf};

use object_store::ObjectStoreExt;
use zerorate_bench::error::BenchError;
use zerorate_bench::recorded;
use zerorate_cal::calibration::{Calibration, CalibrationFault};
use zerorate_cal::device_record::StoredRecord;
use zerorate_cal::fit::fit;
use zerorate_cal::log_fit::{FitOptions, LogFit, LogFitError};
use zerorate_cal::quality::Verdict;
use zerorate_cal::source::Source;
use zerorate_cal::source::whole_file::write_whole;
use zerorate_fit::model::Model;

use crate::dataset::{Place, PlaceError, bytes};
use crate::models::{self, ModelRow, ModelsError};
use crate::out::{self, OutError};

/// How far a curve may be from its row's, in parts of its range.
const AGREES: f64 = 1e-9;

/// The files of a unit.
const CALIBRATION: &str = "calibration.json";
const RECORD: &str = "device-record.bin";

/// What was exported.
#[derive(Debug, Clone)]
pub struct Exported {
    /// The calibration's file.
    pub calibration: PathBuf,
    /// The device record's file.
    pub record: PathBuf,
    /// What the lot says there is to look at, a sentence each.
    pub warnings: Vec<String>,
    /// How far the curves were from their rows' at most, in parts of their range.
    pub disagreement: f64,
}

/// Why a unit cannot be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The rows.
    #[error(transparent)]
    Models(#[from] ModelsError),
    /// No row is the unit's.
    #[error("{models}: no unit {unit}: `zerorate lot fit` writes one row for each axis of each")]
    NoSuchUnit {
        /// The rows' file.
        models: PathBuf,
        /// The serial asked for.
        unit: String,
    },
    /// The unit was rejected.
    #[error("unit {unit} was rejected, and no calibration comes of it: {reasons}")]
    Rejected {
        /// The serial.
        unit: String,
        /// The reasons.
        reasons: String,
    },
    /// The dataset.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// The recording is not where it was.
    #[error(
        "{file}: the recording cannot be read: {reason}: bring it back, or say where the dataset is now (`dataset`)"
    )]
    Recording {
        /// The recording.
        file: String,
        /// What the store says.
        reason: String,
    },
    /// The recording cannot be fitted.
    #[error(transparent)]
    Fit(#[from] LogFitError),
    /// It cannot be fitted now.
    #[error("{file}: it is rejected now, so it is not the recording that was fitted: {reasons}; fit the lot again")]
    Refused {
        /// The recording.
        file: String,
        /// Why.
        reasons: String,
    },
    /// It gives another curve than its row.
    #[error(
        "{file}: its curve is off its row's by {off:.1e} of its range: the recording is not the one that was fitted; fit the lot again"
    )]
    Disagrees {
        /// The recording.
        file: String,
        /// By how much.
        off: f64,
    },
    /// The calibration or the record cannot be made.
    #[error(transparent)]
    Bench(#[from] BenchError),
    /// The calibration cannot be written.
    #[error(transparent)]
    Calibration(#[from] CalibrationFault),
    /// A file would go over something else.
    #[error(transparent)]
    Out(#[from] OutError),
    /// A file cannot be written.
    #[error("{path}: cannot be written: {source}")]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}

/// Writes a unit's calibration and device record into a folder.
///
/// `dataset` says where the recordings are now, if not where they were fitted.
///
/// # Errors
/// [`ExportError`].
pub async fn export(models: &Path, dataset: Option<&str>, unit: &str, out: &Path) -> Result<Exported, ExportError> {
    let rows: Vec<ModelRow> = models::read(models)?.into_iter().filter(|row| row.unit_serial == unit).collect();
    let sound: Vec<&ModelRow> = rows.iter().filter(|row| !row.rejected()).collect();
    let Some(first) = sound.first() else {
        let Some(row) = rows.first() else {
            return Err(ExportError::NoSuchUnit { models: models.to_owned(), unit: unit.to_owned() });
        };
        let reasons: Vec<String> = row.reasons_of(Verdict::Rejected).into_iter().map(|reason| reason.text).collect();
        return Err(ExportError::Rejected { unit: unit.to_owned(), reasons: reasons.join("; ") });
    };
    let of_unit =
        |path: &Path| Calibration::read(&path.into()).is_ok_and(|there| there.unit_serial.as_deref() == Some(unit));
    out::check_kind(&out.join(CALIBRATION), "this unit's calibration", of_unit)?;
    let of_unit = |path: &Path| StoredRecord::read(&path.into()).is_ok_and(|there| there.record.unit.as_str() == unit);
    out::check_kind(&out.join(RECORD), "this unit's device record", of_unit)?;
    let (recording, fit) = refit(first, dataset).await?;
    let disagreements = sound.iter().map(|row| agrees(row, &fit)).collect::<Result<Vec<f64>, _>>()?;
    let disagreement = disagreements.into_iter().fold(0.0, f64::max);
    let calibration = recorded::calibration(&recording, &fit)?;
    let warnings = first.reasons_of(Verdict::Warning).into_iter().map(|reason| reason.text).collect();
    write(&calibration, out).map(|(calibration, record)| Exported { calibration, record, warnings, disagreement })
}

/// The recording of a row and its fit by the row's model.
///
/// # Errors
/// [`ExportError`].
pub async fn refit(row: &ModelRow, dataset: Option<&str>) -> Result<(Source, LogFit), ExportError> {
    let place = Place::of(dataset.unwrap_or(&row.dataset))?;
    let gone =
        |error: object_store::Error| ExportError::Recording { file: row.file.clone(), reason: error.to_string() };
    let meta = place.store.head(&place.key_of(&row.file)).await.map_err(gone)?;
    let recording = Source::bytes(row.file.clone(), bytes(&place, &meta).await.map_err(gone)?);
    let (model, narrow) =
        row.model_asked.split_once(' ').map_or((row.model_asked.as_str(), false), |(model, _)| (model, true));
    let model: Model = model.parse().unwrap_or_default();
    let options = FitOptions { model, allow_narrow: narrow, ..FitOptions::default() };
    let fit = fit(std::slice::from_ref(&recording), &options)?;
    Ok((recording, fit))
}

/// How far a row's curve is from the fit's, in parts of its range.
///
/// # Errors
/// [`ExportError::Refused`] where the fit has no such axis, [`ExportError::Disagrees`] where it is another curve.
pub fn agrees(row: &ModelRow, fit: &LogFit) -> Result<f64, ExportError> {
    let file = row.file.clone();
    if !fit.axes.iter().any(|axis| axis.name == row.axis) {
        return Err(ExportError::Refused { file, reasons: fit.reasons().collect::<Vec<_>>().join("; ") });
    }
    let off = distance(row, fit);
    if off <= AGREES { Ok(off) } else { Err(ExportError::Disagrees { file, off }) }
}

/// The greatest distance of a row's curve from the fit's, in parts of its range.
fn distance(row: &ModelRow, fit: &LogFit) -> f64 {
    let (Some(own), Some(again)) = (row.axis_calibration(), fit.axes.iter().find(|axis| axis.name == row.axis)) else {
        return f64::NAN;
    };
    let (own, again) = (own.fit.model, &again.calibration.fit.model);
    let (min, max) = (own.drift.valid.min(), own.drift.valid.max());
    let at = |step: i32| min + (max - min) * f64::from(step) / 100.0;
    let off = |step| (own.drift.evaluate(at(step)).0 - again.drift.evaluate(at(step)).0).abs();
    let curves = (0..=100).map(off).fold(0.0, f64::max) / own.drift.peak_to_peak();
    // Rows are written to the last bit, and so are their histories.
    if own.history == again.history { curves } else { f64::INFINITY }
}

fn write(calibration: &Calibration, out: &Path) -> Result<(PathBuf, PathBuf), ExportError> {
    fs::create_dir_all(out).map_err(cannot(out))?;
    let (path, record) = (out.join(CALIBRATION), out.join(RECORD));
    let bytes = recorded::device_record(calibration)?;
    write_whole(&record, &bytes).map_err(cannot(&record))?;
    write_whole(&path, calibration.to_json()?.as_bytes()).map_err(cannot(&path))?;
    Ok((path, record))
}

fn cannot(path: &Path) -> impl FnOnce(std::io::Error) -> ExportError {
    let path = path.to_owned();
    move |source| ExportError::Write { path, source }
}
