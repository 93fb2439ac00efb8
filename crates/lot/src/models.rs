//! `models.parquet`: one row a fit, with everything that a calibration needs and everything that an audit asks for.

mod columns;

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use arrow_array::RecordBatch;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::{Compression, ZstdLevel};
use parquet::file::properties::WriterProperties;
use serde::{Deserialize, Serialize};
use zerorate_cal::calibration::AxisCalibration;
use zerorate_cal::quality::{Reason, Verdict};
use zerorate_cal::ramp_fit::verdict_of;
use zerorate_cal::recording::key_values;
use zerorate_core::drift::{Scale, Shape, ValidRange};
use zerorate_core::units::Axis;
use zerorate_fit::residual::ResidualStatistics;

use crate::dataset::{Found, Skipped};
use crate::fit::Fitted;

/// What follows the model asked for where a narrow span was allowed.
pub(crate) const NARROW: &str = " narrow";

/// The version of the columns.
pub const SCHEMA_VERSION: u32 = 1;

/// One fit: an axis of a unit. Counts unless said otherwise; NaN, written as null, where there is no such number.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ModelRow {
    /// The unit's serial, as its recording has it.
    pub unit_serial: String,
    /// `x` or `y`.
    pub axis: String,
    /// The station that recorded it.
    pub station: String,
    /// Who recorded it.
    pub operator: String,
    /// When, RFC 3339.
    pub recorded_at: String,
    /// The procedure.
    pub procedure: String,
    /// The device's firmware.
    pub firmware: String,
    /// The dataset, as it was given.
    pub dataset: String,
    /// The recording, from the dataset's root.
    pub file: String,
    /// Its size, bytes.
    pub file_bytes: f64,
    /// When it was written, RFC 3339.
    pub file_modified: String,
    /// What its readings are known by: SHA-256 of the ramps' means; empty without a ramp, and in rows of an earlier version.
    pub readings_sha256: String,
    /// The model asked for.
    pub model_asked: String,
    /// The model fitted, terms beside the curve included; empty without a fit.
    pub model: String,
    /// `good`, `warning` or `rejected`, of the unit.
    pub verdict: String,
    /// The reasons, as JSON.
    pub reasons: String,
    /// The axis of the calibration file, as JSON; empty without a fit.
    pub calibration: String,
    /// The program that fitted it.
    pub created_by: String,
    /// The valid range.
    pub temperature_min: f64,
    /// The valid range.
    pub temperature_max: f64,
    /// Centre of the scaled variable.
    pub temperature_centre: f64,
    /// Half span of the scaled variable.
    pub temperature_half_span: f64,
    /// Coefficients in the scaled variable, constant first; of a table its knots.
    pub coefficients: Vec<f64>,
    /// Groups fitted.
    pub groups: f64,
    /// Samples in them.
    pub samples: f64,
    /// Residual of the fit of everything.
    pub in_sample_rms: f64,
    /// Residual of the fit of everything, peak to peak.
    pub in_sample_pp: f64,
    /// Residual of the folds, each predicted by the fit of the others.
    pub held_out_rms: f64,
    /// The same, peak to peak.
    pub held_out_pp: f64,
    /// The drift over the valid range, peak to peak.
    pub drift_pp: f64,
    /// The reading in the middle of the valid range.
    pub reading_mid: f64,
    /// The set-up's limit on what mode trim leaves, peak to peak.
    pub limit_trim_residual_pp: f64,
    /// The set-up's limit on what mode hybrid leaves, in floors.
    pub limit_hybrid_residual_floors: f64,
    /// The set-up's limit on the mean's distance from the centre.
    pub limit_mean_offset: f64,
}

/// Why a file of rows cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {reason}")]
pub struct ModelsError {
    path: String,
    reason: String,
}

impl ModelsError {
    fn of(path: &Path) -> impl Fn(&dyn std::fmt::Display) -> Self {
        let path = path.display().to_string();
        move |reason| Self { path: path.clone(), reason: reason.to_string() }
    }
}

impl ModelRow {
    /// The rows of a unit, one an axis.
    #[must_use]
    pub fn of(found: &Found, fitted: &Fitted, model_asked: &str, dataset: &str) -> Vec<Self> {
        let limit = |of: fn(&zerorate_bench::setup::Limits) -> f64| found.limits.as_ref().map_or(f64::NAN, of);
        Axis::BOTH
            .into_iter()
            .map(|axis| {
                let mut row = Self {
                    unit_serial: found.info.unit_serial.clone(),
                    axis: axis.name().to_owned(),
                    station: found.label("station").to_owned(),
                    operator: found.label("operator").to_owned(),
                    recorded_at: found.recorded_at(),
                    procedure: found.info.procedure.clone(),
                    firmware: found.info.firmware.clone(),
                    dataset: dataset.to_owned(),
                    file: found.file.clone(),
                    file_bytes: found.meta.size as f64,
                    file_modified: found.meta.last_modified.to_rfc3339(),
                    readings_sha256: fitted.readings_sha256.clone(),
                    model_asked: model_asked.to_owned(),
                    created_by: zerorate_cal::calibration::CREATED_BY.to_owned(),
                    limit_trim_residual_pp: limit(|limits| limits.trim_residual_pp_counts),
                    limit_hybrid_residual_floors: limit(|limits| limits.hybrid_residual_floors),
                    limit_mean_offset: limit(|limits| limits.mean_offset_counts),
                    ..Self::unfitted()
                };
                row.judge(&fitted.judgement.reasons);
                if let Some(own) = fitted.axes.get(axis.name()) {
                    row.take(own);
                }
                row
            })
            .collect()
    }

    /// Every number of a fit missing.
    fn unfitted() -> Self {
        let mut row = Self::default();
        columns::NUMBERS.iter().for_each(|number| *(number.of_mut)(&mut row) = f64::NAN);
        row
    }

    fn take(&mut self, axis: &AxisCalibration) {
        // Told of the drift; the coefficients are the model's own.
        let drift = axis.measured_drift();
        let valid: ValidRange = drift.valid;
        let (scale, coefficients) = match &axis.drift().shape {
            Shape::Polynomial(polynomial) => (Some(polynomial.scale()), polynomial.coefficients().to_vec()),
            Shape::Table(table) => (Scale::spanning(valid.min(), valid.max()), table.knots().to_vec()),
        };
        self.calibration = serde_json::to_string(axis).unwrap_or_default();
        self.model = axis.fit.chosen_model();
        (self.temperature_min, self.temperature_max) = (valid.min(), valid.max());
        if let Some(scale) = scale {
            (self.temperature_centre, self.temperature_half_span) = (scale.centre(), scale.half_span());
        }
        self.coefficients = coefficients;
        self.drift_pp = drift.peak_to_peak();
        self.reading_mid = drift.evaluate(f64::midpoint(valid.min(), valid.max())).0;
        let statistics = &axis.fit.statistics;
        self.groups = statistics.residuals as f64;
        self.samples = statistics.samples_used as f64;
        let held_out = statistics.held_out.unwrap_or(ResidualStatistics::NONE);
        (self.in_sample_rms, self.in_sample_pp) = (statistics.in_sample.rms, statistics.in_sample.pp);
        (self.held_out_rms, self.held_out_pp) = (held_out.rms, held_out.pp);
    }

    /// The axis of the calibration, where there is a fit.
    #[must_use]
    pub fn axis_calibration(&self) -> Option<AxisCalibration> {
        serde_json::from_str(&self.calibration).ok()
    }

    /// Whether the unit was rejected.
    #[must_use]
    pub fn rejected(&self) -> bool {
        self.verdict == Verdict::Rejected.name()
    }

    /// The reasons.
    #[must_use]
    pub fn reason_list(&self) -> Vec<Reason> {
        serde_json::from_str(&self.reasons).unwrap_or_default()
    }

    /// The reasons of this weight.
    #[must_use]
    pub fn reasons_of(&self, verdict: Verdict) -> Vec<Reason> {
        self.reason_list().into_iter().filter(|reason| self.verdict_of(reason) == verdict).collect()
    }

    /// Gives the unit its reasons, and with them its verdict.
    pub(crate) fn judge(&mut self, reasons: &[Reason]) {
        let verdict = reasons.iter().map(|reason| self.verdict_of(reason)).max().unwrap_or_default();
        verdict.name().clone_into(&mut self.verdict);
        self.reasons = serde_json::to_string(reasons).unwrap_or_default();
    }

    fn verdict_of(&self, reason: &Reason) -> Verdict {
        verdict_of(reason, self.model_asked.ends_with(NARROW))
    }
}

/// What a lot has beside the recordings that were fitted.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Beside {
    /// Files that were not fitted, and why.
    pub skipped: Vec<Skipped>,
    /// Recordings of other procedures.
    pub other_procedures: u64,
}

/// Writes rows, whole or not at all.
///
/// # Errors
/// [`ModelsError`].
pub fn write(path: &Path, rows: &[ModelRow], beside: &Beside) -> Result<(), ModelsError> {
    let failed = ModelsError::of(path);
    let beside = serde_json::to_string(beside).unwrap_or_default();
    let batch = columns::batch(rows, &beside).map_err(|error| failed(&error))?;
    let partial = path.with_extension("parquet.partial");
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_key_value_metadata(Some(key_values(&batch.schema())))
        .build();
    let file = File::create(&partial).map_err(|error| failed(&error))?;
    let mut writer = ArrowWriter::try_new(file, batch.schema(), Some(properties)).map_err(|error| failed(&error))?;
    writer.write(&batch).map_err(|error| failed(&error))?;
    writer.into_inner().map_err(|error| failed(&error))?.sync_all().map_err(|error| failed(&error))?;
    std::fs::rename(&partial, path).map_err(|error| failed(&error))
}

/// Whether a file holds rows, of whatever version.
#[must_use]
pub fn are_in(path: &Path) -> bool {
    let builder = File::open(path).ok().and_then(|file| ParquetRecordBatchReaderBuilder::try_new(file).ok());
    builder.is_some_and(|builder| builder.schema().metadata().contains_key(columns::VERSION_KEY))
}

/// Reads rows.
///
/// # Errors
/// [`ModelsError`], when the file cannot be read or is none of ours.
pub fn read(path: &Path) -> Result<Vec<ModelRow>, ModelsError> {
    read_whole(path).map(|(rows, _)| rows)
}

/// Reads rows, and what the lot has beside them; `None` where an earlier version wrote them.
///
/// # Errors
/// [`ModelsError`], when the file cannot be read or is none of ours.
pub fn read_whole(path: &Path) -> Result<(Vec<ModelRow>, Option<Beside>), ModelsError> {
    let failed = ModelsError::of(path);
    let file = File::open(path).map_err(|error| failed(&error))?;
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(|error| failed(&error))?;
    let version = builder.schema().metadata().get(columns::VERSION_KEY).cloned();
    if version.as_deref() != Some(SCHEMA_VERSION.to_string().as_str()) {
        return Err(failed(&"these are no models of `zerorate lot fit`, or of another version: fit again"));
    }
    let beside = builder.schema().metadata().get(columns::BESIDE_KEY).and_then(|told| serde_json::from_str(told).ok());
    let mut rows = Vec::new();
    for batch in builder.build().map_err(|error| failed(&error))? {
        let batch: RecordBatch = batch.map_err(|error| failed(&error))?;
        rows.extend(columns::rows(&Arc::new(batch)).map_err(|error| failed(&error))?);
    }
    Ok((rows, beside))
}
