//! A chamber's own recording: where its air was, beside boards that log by themselves.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::types::{Float64Type, UInt32Type};
use arrow_array::{ArrayRef, Float64Array, RecordBatch, StringArray, UInt32Array};
use arrow_schema::{DataType, Field, Schema};
use chrono::{DateTime, Utc};

use crate::columns::{Column, column};
use crate::named::Named;
use crate::schema::{COLUMNS_KEY, STARTED_KEY, columns_told, field, labels, numbers, of_labels, texts};
use crate::streamed::{self, Streamed};
use crate::utc::rfc3339_ms;
use crate::{Phase, RecordingError, RecordingFault, WriteError};
use zerorate_source::Source;

const VERSION_KEY: &str = "zerorate.chamber_schema_version";
/// The version that is written and read.
const VERSION: &str = "1";
/// The profile's text.
const PROFILE_KEY: &str = "zerorate.profile";

/// All columns, in their order.
static COLUMNS: [Column; 5] = [
    column("t_s", DataType::Float64, "s", "Time since the recording was begun."),
    column("step", DataType::UInt32, "1", "The profile's step, counted from 1; the way to a soak is the soak's."),
    column("phase", DataType::Utf8, "none", "What the chamber was doing: soak, heating or cooling."),
    column("chamber_set_c", DataType::Float64, "°C", "The chamber's set point."),
    column("chamber_c", DataType::Float64, "°C", "The chamber's air; NaN while it did not answer."),
];

/// What is true of the whole recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChamberInfo {
    /// When it was begun, by this machine's clock.
    pub started: DateTime<Utc>,
    /// The profile's text.
    pub profile: String,
    /// What the set-up and the instruments know of it, by name.
    pub labels: BTreeMap<String, String>,
}

/// The chamber at one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct ChamberMoment {
    /// Seconds since the recording was begun.
    pub t_s: f64,
    /// The profile's step, counted from 1.
    pub step: u32,
    /// What the chamber was doing.
    pub phase: Phase,
    /// Where it was sent, degrees C.
    pub set_c: f64,
    /// Its air, degrees C; NaN while it did not answer.
    pub air_c: f64,
}

/// A chamber's recording that is being written.
pub struct ChamberWriter(Streamed);

impl ChamberWriter {
    /// Starts a recording, as [`RecordingWriter::create`](super::RecordingWriter::create) does.
    ///
    /// # Errors
    /// When the folder or the stream cannot be written.
    pub fn create(path: &Path, info: &ChamberInfo) -> Result<Self, WriteError> {
        let fields: Vec<Field> = COLUMNS.iter().map(field).collect();
        let mut metadata = HashMap::from([
            (VERSION_KEY.to_owned(), VERSION.to_owned()),
            (STARTED_KEY.to_owned(), rfc3339_ms(info.started)),
            (PROFILE_KEY.to_owned(), info.profile.clone()),
            (COLUMNS_KEY.to_owned(), columns_told(&fields)),
        ]);
        metadata.extend(of_labels(&info.labels));
        Streamed::create(path, Arc::new(Schema::new_with_metadata(fields, metadata)), "moments").map(Self)
    }

    /// Where an earlier recording is kept now that was cut, and stood where this one is written.
    #[must_use]
    pub fn set_aside(&self) -> Option<&Path> {
        self.0.set_aside()
    }

    /// Writes a moment and hands it to the system.
    ///
    /// # Errors
    /// When it cannot be written; what was written before is kept.
    pub fn write(&mut self, moment: &ChamberMoment) -> Result<(), WriteError> {
        let float = |value: f64| -> ArrayRef { Arc::new(Float64Array::from(vec![value])) };
        let columns: Vec<ArrayRef> = vec![
            float(moment.t_s),
            Arc::new(UInt32Array::from(vec![moment.step])),
            Arc::new(StringArray::from(vec![moment.phase.name()])),
            float(moment.set_c),
            float(moment.air_c),
        ];
        self.0.write(|schema| RecordBatch::try_new(Arc::clone(schema), columns))
    }

    /// Finishes the recording: Parquet, in the stream's place.
    ///
    /// # Errors
    /// When that fails: the stream then still holds every moment.
    pub fn finish(self) -> Result<PathBuf, WriteError> {
        self.0.finish()
    }
}

/// A chamber's recording that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct ChamberRecording {
    /// What is true of the whole.
    pub info: ChamberInfo,
    /// Every moment, in order.
    pub moments: Vec<ChamberMoment>,
    /// Whether it was not finished: cut off, or still being written.
    pub cut: bool,
}

impl ChamberRecording {
    /// Reads a chamber's recording, finished or not.
    ///
    /// # Errors
    /// When it cannot be read, is another's, or is damaged.
    pub fn read(source: &Source) -> Result<Self, RecordingError> {
        match streamed::read(source, info, moments) {
            Ok((info, moments, cut)) => Ok(Self { info, moments, cut }),
            Err(RecordingFault::NotARecording) => Err(source.faulty(RecordingFault::NotAChambers)),
            Err(fault) => Err(source.faulty(fault)),
        }
    }
}

fn info(schema: &Schema) -> Result<ChamberInfo, RecordingFault> {
    let text = |key| schema.metadata().get(key).map(String::as_str);
    match text(VERSION_KEY) {
        Some(VERSION) => {}
        Some(found) => return Err(RecordingFault::UnknownChamberVersion { found: found.to_owned() }),
        None => return Err(RecordingFault::NotAChambers),
    }
    let started = text(STARTED_KEY).unwrap_or_default().parse().map_err(RecordingFault::damaged)?;
    let profile = text(PROFILE_KEY).unwrap_or_default().to_owned();
    Ok(ChamberInfo { started, profile, labels: labels(schema.metadata()) })
}

fn moments(batch: &RecordBatch) -> Result<Vec<ChamberMoment>, String> {
    let t_s = numbers::<Float64Type>(batch, "t_s")?;
    let step = numbers::<UInt32Type>(batch, "step")?;
    let phase = texts(batch, "phase")?;
    let set_c = numbers::<Float64Type>(batch, "chamber_set_c")?;
    let air_c = numbers::<Float64Type>(batch, "chamber_c")?;
    let moment = |i| {
        Ok(ChamberMoment {
            t_s: t_s.value(i),
            step: step.value(i),
            phase: Phase::of_name(phase.value(i))?,
            set_c: set_c.value(i),
            air_c: air_c.value(i),
        })
    };
    (0..batch.num_rows()).map(moment).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info() -> ChamberInfo {
        let started = "2026-11-02T18:00:00.250Z".parse().unwrap();
        let labels = [("operator".to_owned(), "A. N.".to_owned())].into();
        ChamberInfo { started, profile: "steps = []".into(), labels }
    }

    fn moment(i: u32) -> ChamberMoment {
        let air_c = 20.0 - 0.5 * f64::from(i);
        ChamberMoment { t_s: f64::from(i), step: 1, phase: Phase::Cooling, set_c: -20.0, air_c }
    }

    #[test]
    fn a_recording_reads_back_as_it_was_written_finished_or_cut() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("chamber.parquet");
        let mut writer = ChamberWriter::create(&path, &info()).unwrap();
        let moments: Vec<ChamberMoment> = (0..5).map(moment).collect();
        moments.iter().for_each(|moment| writer.write(moment).unwrap());
        let cut = ChamberRecording::read(&(&path.with_extension("arrows")).into()).unwrap();
        assert_eq!(cut, ChamberRecording { info: info(), moments: moments.clone(), cut: true });
        let path = writer.finish().unwrap();
        assert_eq!(ChamberRecording::read(&(&path).into()).unwrap(), ChamberRecording { moments, cut: false, ..cut });
    }

    #[test]
    fn each_recording_that_was_cut_is_kept_and_told_where() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("chamber.parquet");
        // A program that is killed finishes nothing.
        let cut = |of: u32| {
            let mut writer = ChamberWriter::create(&path, &info()).unwrap();
            (0..of).for_each(|i| writer.write(&moment(i)).unwrap());
            writer.set_aside().map(Path::to_owned)
        };
        let told = [cut(3), cut(4), cut(5)];
        let kept = ["chamber.cut.arrows", "chamber.cut-1.arrows"].map(|name| folder.path().join(name));
        assert_eq!(told, [None, Some(kept[0].clone()), Some(kept[1].clone())]);
        let moments = kept.map(|file| ChamberRecording::read(&(&file).into()).unwrap().moments.len());
        assert_eq!(moments, [3, 4]);
    }

    #[test]
    fn another_recording_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.parquet");
        let writer = crate::RecordingWriter::create(&path, &crate::RecordingInfo::default()).unwrap();
        let path = writer.finish().unwrap();
        let told = ChamberRecording::read(&(&path).into()).unwrap_err().to_string();
        assert!(told.contains("not a chamber's recording"), "{told}");
    }
}
