//! `lot fit`: every recording of a dataset, in batches; what is done stays done.

mod copies;
mod earlier;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::Serialize;
use zerorate_cal::log_fit::FitOptions;
use zerorate_cal::quality::{Reason, Verdict};
use zerorate_fit::model::Model;
use zerorate_fit::robust::median;

use crate::dataset::{Dataset, Found, Place, PlaceError, Skipped};
use crate::engine::{Engine, EngineError};
use crate::fit::{self, Fitted};
use crate::models::{self, Beside, ModelRow, ModelsError, NARROW};
use crate::out::{self, OutError};
use earlier::Earlier;

/// Recordings in a batch: what is lost when a run is ended, and what is in memory at a time.
const BATCH: usize = 128;

/// Recordings in a batch on a cluster: a plan names each of them, and its messages have a limit of 16 MB.
const CLUSTER_BATCH: usize = 512;

/// A fit of a lot.
#[derive(Debug, Clone)]
pub struct FitRun {
    /// A folder, a glob, or a URL.
    pub dataset: String,
    /// Where the rows go.
    pub out: PathBuf,
    /// The model.
    pub model: Model,
    /// Fit a narrow temperature span too.
    pub allow_narrow: bool,
    /// What runs the queries.
    pub engine: Engine,
    /// Fit everything again, whatever an earlier run has done.
    pub fresh: bool,
}

/// What a fit of a lot came to.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// The version of this summary.
    pub schema: u32,
    /// The rows' file.
    pub models: PathBuf,
    /// Recordings fitted or rejected.
    pub units: usize,
    /// Of these, those that an earlier run had done.
    pub reused: usize,
    /// Rows with a curve.
    pub fits: usize,
    /// Units with something to look at.
    pub warnings: usize,
    /// Those units, and what.
    pub warned: Vec<JudgedUnit>,
    /// Units rejected, and why.
    pub rejected: Vec<JudgedUnit>,
    /// Files that were not fitted, and why.
    pub skipped: Vec<Skipped>,
    /// Recordings of other procedures beside them.
    pub other_procedures: u64,
    /// The median of the fits' held-out residuals, counts rms; none without a fit.
    pub median_held_out_rms_counts: Option<f64>,
    /// The fit that predicts worst.
    pub worst: Option<WorstFit>,
    /// Wall time, seconds.
    pub seconds: f64,
}

/// The fit of a lot that predicts worst.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WorstFit {
    /// The serial in its recording.
    pub serial: String,
    /// The axis.
    pub axis: String,
    /// Its held-out residual, counts rms.
    pub held_out_rms_counts: f64,
}

/// A unit that was rejected, or has something to look at.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JudgedUnit {
    /// The serial in its recording.
    pub serial: String,
    /// The recording.
    pub file: String,
    /// Why.
    pub reasons: Vec<Reason>,
}

/// Why a lot was not fitted.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The dataset.
    #[error(transparent)]
    Place(#[from] PlaceError),
    /// The engine.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The rows.
    #[error(transparent)]
    Models(#[from] ModelsError),
    /// The rows would go over something else.
    #[error(transparent)]
    Out(#[from] OutError),
    /// Another run writes there.
    #[error("{path}: another run is writing there: wait for it, or give `out` another name")]
    Busy {
        /// Where the rows go.
        path: String,
    },
    /// Nothing in the dataset is a recording that can be fitted.
    #[error("{dataset}: none of its {files} files is a recording of a full-temperature test: {first}")]
    NothingToFit {
        /// The dataset.
        dataset: String,
        /// Files in it.
        files: usize,
        /// The first one's reason.
        first: String,
    },
    /// The folder for the rows cannot be made.
    #[error("{path}: cannot be made: {source}: give `out` another place")]
    Parts {
        /// The folder.
        path: String,
        /// What the system says.
        source: std::io::Error,
    },
}

impl FitRun {
    /// Fits the lot; `progress` is told how many recordings of how many are done.
    ///
    /// # Errors
    /// [`RunError`]; what was done is kept beside `out`, and the same command goes on from there.
    pub async fn run(&self, progress: &dyn Fn(usize, usize)) -> Result<Summary, RunError> {
        let began = Instant::now();
        out::check_kind(&self.out, "models of `zerorate lot fit`", models::are_in)?;
        let Dataset { place, found, mut skipped, other_procedures } = Dataset::open(&self.dataset).await?;
        let others: u64 = other_procedures.values().sum();
        if found.is_empty() {
            let first = skipped.first().map_or_else(
                || "they are of other procedures".to_owned(),
                |skipped| format!("{}: {}", skipped.file, skipped.reason),
            );
            let files = skipped.len() + usize::try_from(others).unwrap_or(usize::MAX);
            return Err(RunError::NothingToFit { dataset: self.dataset.clone(), files, first });
        }
        // Models of another version cannot be read, and are made anew.
        let before = models::read(&self.out).unwrap_or_default();
        // Serials begin anew with many a lot: of the same one is what came of the same dataset, or of the very files of this.
        let states: BTreeSet<(String, u64)> = found.iter().map(earlier::state).collect();
        let of_this_lot = |row: &ModelRow| row.dataset == self.dataset || states.contains(&earlier::state_of(row));
        out::check_kind(&self.out, "the models of this lot alone", |_| before.iter().all(of_this_lot))?;
        let files = found.iter().map(|own| &own.file).chain(skipped.iter().map(|skipped| &skipped.file));
        let files: BTreeSet<String> = files.cloned().collect();
        let fitted: BTreeSet<String> = before.into_iter().map(|row| row.file).collect();
        skipped.extend(fitted.difference(&files).map(|file| Skipped {
            file: file.clone(),
            reason: "it was fitted before, and is no longer there: its rows were left out".to_owned(),
        }));
        let asked = self.asked();
        let mut earlier = Earlier::open(&self.out, &asked, self.fresh)?;
        let (mut rows, mut todo) = (Vec::with_capacity(2 * found.len()), Vec::new());
        for own in &found {
            match earlier.take(own) {
                Some(done) => rows.extend(done),
                None => todo.push(own),
            }
        }
        let reused = rows.len() / 2;
        progress(reused, found.len());
        let batch = if matches!(self.engine, Engine::Cluster(_)) { CLUSTER_BATCH } else { BATCH };
        let mut done = reused;
        for files in todo.chunks(batch) {
            let fitted = self.batch(&place, files, &mut skipped).await?;
            let fresh: Vec<ModelRow> =
                fitted.iter().flat_map(|(found, fitted)| ModelRow::of(found, fitted, &asked, &self.dataset)).collect();
            earlier.keep(&fresh)?;
            rows.extend(fresh);
            done += files.len();
            progress(done, found.len());
        }
        rows.sort_by(|a, b| (&a.unit_serial, &a.file, &a.axis).cmp(&(&b.unit_serial, &b.file, &b.axis)));
        copies::judge(&mut rows);
        skipped.sort_by(|a, b| a.file.cmp(&b.file));
        let beside = Beside { skipped, other_procedures: others };
        models::write(&self.out, &rows, &beside)?;
        earlier.finish();
        Ok(self.summary(&rows, beside, reused, began.elapsed().as_secs_f64()))
    }

    /// The model and how it is fitted, as rows name it.
    fn asked(&self) -> String {
        if self.allow_narrow { format!("{}{NARROW}", self.model) } else { self.model.to_string() }
    }

    /// Fits some recordings. Where the engine fails, those that cannot be read are found and left out.
    async fn batch<'f>(
        &self,
        place: &Place,
        files: &[&'f Found],
        skipped: &mut Vec<Skipped>,
    ) -> Result<Vec<(&'f Found, Fitted)>, RunError> {
        let options = FitOptions { model: self.model, allow_narrow: self.allow_narrow, ..FitOptions::default() };
        let mut files: Vec<&Found> = files.to_vec();
        let fitted = match fit::fit(&self.engine, place, &files, &options).await {
            Ok(fitted) => fitted,
            Err(error) if error.is_of_the_files() => {
                let unreadable = unreadable(place, &files).await;
                if unreadable.is_empty() {
                    return Err(error.into());
                }
                files.retain(|own| unreadable.iter().all(|skipped| skipped.file != own.file));
                skipped.extend(unreadable);
                if files.is_empty() { Vec::new() } else { fit::fit(&self.engine, place, &files, &options).await? }
            }
            Err(error) => return Err(error.into()),
        };
        let mut kept = Vec::with_capacity(files.len());
        for (found, mut fitted) in files.into_iter().zip(fitted) {
            if fitted.inconsistent > 0 {
                let reason = format!(
                    "damaged: {} groups have means that are not those of their sums: take another copy or record again",
                    fitted.inconsistent
                );
                skipped.push(Skipped { file: found.file.clone(), reason });
                continue;
            }
            found.serial_reason.iter().for_each(|reason| fitted.judgement.add(reason.clone()));
            kept.push((found, fitted));
        }
        Ok(kept)
    }

    fn summary(&self, rows: &[ModelRow], beside: Beside, reused: usize, seconds: f64) -> Summary {
        let units = || rows.iter().step_by(2);
        let judged = |row: &ModelRow| JudgedUnit {
            serial: row.unit_serial.clone(),
            file: row.file.clone(),
            reasons: row.reason_list(),
        };
        let warned: Vec<JudgedUnit> =
            units().filter(|row| row.verdict == Verdict::Warning.name()).map(judged).collect();
        let mut held_out: Vec<&ModelRow> =
            rows.iter().filter(|row| !row.rejected() && row.held_out_rms.is_finite()).collect();
        held_out.sort_by(|a, b| a.held_out_rms.total_cmp(&b.held_out_rms));
        let middle = median(&mut held_out.iter().map(|row| row.held_out_rms).collect::<Vec<_>>());
        Summary {
            schema: 1,
            models: self.out.clone(),
            units: units().count(),
            reused,
            fits: rows.iter().filter(|row| !row.model.is_empty()).count(),
            warnings: warned.len(),
            warned,
            rejected: units().filter(|row| row.rejected()).map(judged).collect(),
            skipped: beside.skipped,
            other_procedures: beside.other_procedures,
            median_held_out_rms_counts: Some(middle).filter(|middle| middle.is_finite()),
            worst: held_out.last().map(|row| WorstFit {
                serial: row.unit_serial.clone(),
                axis: row.axis.clone(),
                held_out_rms_counts: row.held_out_rms,
            }),
            seconds,
        }
    }
}

/// Which of some recordings cannot be read, each looked at alone.
async fn unreadable(place: &Place, files: &[&Found]) -> Vec<Skipped> {
    let engine = Engine::Embedded { threads: 1 };
    let mut found = Vec::new();
    for file in files {
        if let Err(error) = fit::look(&engine, place, file).await {
            let reason = format!("damaged: {error}: take another copy or record again");
            found.push(Skipped { file: file.file.clone(), reason });
        }
    }
    found
}

/// The folder in which a run's batches are kept until it is whole.
fn parts(out: &Path) -> PathBuf {
    let mut name = out.file_name().unwrap_or_default().to_owned();
    name.push(".parts");
    out.with_file_name(name)
}
