//! Logs of any kind, read as sensors that give rows: tables, recordings of the bench, logs of autopilots.
//!
//! The kind is recognised by content, never by name. A log goes by as batches of rows to a [`Sink`]; what is kept in
//! memory is a batch a sensor, however long the log.

mod buffer;
mod error;
mod of_recording;
mod of_table;
mod sensor;
mod survey;

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

pub(crate) use buffer::RowBuffer;
pub use error::LogError;
pub(crate) use of_table::TableLog;
pub use sensor::{Sensor, SensorChoice, SensorChoiceError, SensorKind};
pub(crate) use survey::AxisSurvey;

use crate::interop;
use crate::quality::{Reason, TemperatureUnit};
use crate::recording::{Recording, RecordingError};
use crate::table::{Columns, RateUnit};

/// As many bytes as every format needs to be recognised.
const START_BYTES: u64 = 64;

/// What one sensor of a log is, and how its rows are to be read.
#[derive(Debug, Clone, PartialEq)]
pub struct Stream {
    /// Which sensor it is; `None` for the columns of a table, which name no sensor.
    pub sensor: Option<Sensor>,
    /// A name for each axis, as results are listed: a table's column, `gyro0.x` of an autopilot.
    pub names: Vec<String>,
    /// The unit of all values.
    pub unit: RateUnit,
    /// The temperature's unit.
    pub temperature_unit: TemperatureUnit,
}

/// Some successive rows of one sensor.
#[derive(Debug, Clone, Copy)]
pub struct Rows<'a> {
    /// The sensor, by its place among those of the log.
    pub stream: usize,
    /// How often time had started anew before these rows: several logs in one file.
    pub part: u32,
    /// The first row's number among the sensor's, from 0.
    pub first_row: u64,
    /// Seconds from the log's first row, one a row; NaN where not known.
    pub time_s: &'a [f64],
    /// Temperatures, one a row; NaN where there is none.
    pub temperature: &'a [f64],
    /// Values, a vector an axis, one a row; NaN where there is none.
    pub values: &'a [Vec<f64>],
}

/// Who takes a log's rows as they go by.
pub trait Sink {
    /// A sensor was met, numbered from 0 in the order met; its rows follow if they are wanted.
    fn stream(&mut self, stream: &Stream) -> bool;
    /// Some rows of a sensor that is wanted.
    fn rows(&mut self, rows: &Rows<'_>);
}

/// How the reading of a log ended.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Ending {
    /// What was guessed or undone, a sentence each.
    pub notes: Vec<String>,
    /// What is wrong with the file, as far as it could be read nevertheless.
    pub reasons: Vec<Reason>,
}

/// A log that was opened and recognised.
#[derive(Debug)]
pub struct LogFile {
    path: PathBuf,
    form: Form,
}

#[derive(Debug)]
enum Form {
    Table(Box<TableLog>),
    Recording(Box<Recording>),
    Autopilot(interop::Format),
}

impl LogFile {
    /// Opens a log and finds out its form; a table is read once to learn how long it lasts.
    ///
    /// # Errors
    /// When the file cannot be read or is no log, or a table's columns are unclear or its time runs backwards.
    pub fn open(path: &Path, columns: &Columns) -> Result<Self, LogError> {
        let path = path.to_owned();
        let unreadable = |source| LogError::Read { path: path.clone(), source };
        let mut start = Vec::new();
        File::open(&path).map_err(unreadable)?.take(START_BYTES).read_to_end(&mut start).map_err(unreadable)?;
        let form = if let Some(format) = interop::recognise(&start) {
            Form::Autopilot(format)
        } else {
            // Whoever names columns wants a table of a recording too.
            let recording = if columns.rates.is_empty() { of_recording::recognise(&path, &start) } else { None };
            match recording {
                Some(Ok(recording)) => Form::Recording(Box::new(recording)),
                Some(Err(RecordingError::NotARecording { .. })) | None => {
                    Form::Table(Box::new(TableLog::open(&path, columns)?))
                }
                Some(Err(error)) => return Err(error.into()),
            }
        };
        Ok(Self { path, form })
    }

    /// The file's path, as it was given.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The autopilot's format, if it is an autopilot's log.
    #[must_use]
    pub fn autopilot(&self) -> Option<interop::Format> {
        match self.form {
            Form::Autopilot(format) => Some(format),
            Form::Table(_) | Form::Recording(_) => None,
        }
    }

    /// The number of rows and the mean time between them in seconds (NaN if not known), where these are known before
    /// the rows are read.
    #[must_use]
    pub fn extent(&self) -> Option<(u64, f64)> {
        match &self.form {
            Form::Table(table) => Some((table.survey.rows, table.survey.step_s())),
            Form::Recording(recording) => Some((recording.rows.len() as u64 / 2, f64::NAN)),
            Form::Autopilot(_) => None,
        }
    }

    /// Reads the log once from beginning to end.
    ///
    /// # Errors
    /// When the file cannot be read or holds what no log of its form can. What is whole of a log that was cut off or
    /// damaged is read, and the [`Ending`] says so.
    pub fn read(&self, sink: &mut dyn Sink) -> Result<Ending, LogError> {
        match &self.form {
            Form::Table(table) => table.read(sink),
            Form::Recording(recording) => Ok(of_recording::read(recording, sink)),
            Form::Autopilot(format) => interop::read(&self.path, *format, sink),
        }
    }
}

#[cfg(test)]
mod tests;
