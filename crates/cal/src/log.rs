//! Logs of any kind, read as sensors that give rows: tables, recordings of the bench, logs of autopilots.
//!
//! The kind is recognised by content, never by name, also where a log is packed ([`zerorate_source::packed`]). A log goes by as
//! batches of rows to a [`Sink`]; what is kept in memory is a batch a sensor, however long the log.

mod clock;
mod counter;
mod error;
mod of_autopilot;
mod of_recording;
mod of_table;
mod plausible;
mod sensor;
mod survey;

use std::time::SystemTime;

pub use clock::{Clock, Ticks};
pub use error::{LogError, LogFault};
pub use imu_logs::{Rows, Sensor, SensorKind};
pub use sensor::{SensorChoice, SensorChoiceError};

use crate::quality::Reason;
use crate::recording::Recording;
use crate::source::Source;
use crate::source::packed::unpacked;
use crate::table::{Columns, Resolved, Table};
use crate::units::{RateUnit, TemperatureUnit};
use of_table::TableLog;
use survey::Survey;

/// What is known of a table whose columns were found, once its numbers were seen.
#[derive(Debug)]
pub struct Surveyed {
    /// Units that were guessed, a file that is cut.
    pub reasons: Vec<Reason>,
    /// The times, where there is a column of them.
    pub clock: Clock,
}

/// Reads a table once, before its rows are.
///
/// # Errors
/// When the table cannot be read, its time runs backwards, or its numbers cannot be in the units they are taken for.
pub fn surveyed(table: &Table, columns: &Resolved) -> Result<Surveyed, LogError> {
    let Survey { reasons, clock, .. } = Survey::of(table, columns)?;
    Ok(Surveyed { reasons, clock })
}

/// What one sensor of a log is, and how its rows are to be read.
#[derive(Debug, Clone, PartialEq)]
pub struct Stream {
    /// Which sensor it is; `None` for the columns of a table that has one.
    pub sensor: Option<Sensor>,
    /// A name for each axis, as results are listed: a table's column, `gyro0.x` of an autopilot.
    pub names: Vec<String>,
    /// The unit of all values.
    pub unit: RateUnit,
    /// The temperature's unit.
    pub temperature_unit: TemperatureUnit,
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
    /// When the first row was taken, where the log itself says it.
    pub started: Option<SystemTime>,
    /// What was undone or is missing, a sentence each.
    pub notes: Vec<String>,
    /// What is wrong with the file, as far as it could be read nevertheless, and the units that were guessed.
    pub reasons: Vec<Reason>,
}

/// The autopilot's format that a log has by its first bytes; `None` for any other.
///
/// # Errors
/// When the source cannot be read.
pub fn autopilot_format(source: &Source) -> Result<Option<imu_logs::Format>, LogError> {
    format_of(&unpacked(source).map_err(LogFault::named)?)
}

/// The same of a source that is not packed.
fn format_of(source: &Source) -> Result<Option<imu_logs::Format>, LogError> {
    let start = source.start(imu_logs::START_BYTES as u64).map_err(|error| source.faulty::<LogFault>(error))?;
    Ok(imu_logs::recognise(&start))
}

/// A log that was opened and recognised.
#[derive(Debug)]
pub struct LogFile {
    source: Source,
    form: Form,
}

#[derive(Debug)]
enum Form {
    Table(Box<TableLog>),
    Recording(Box<Recording>),
    Autopilot(imu_logs::Format),
}

impl LogFile {
    /// Opens a log and finds out its form; a table is read once to learn how long it lasts.
    ///
    /// # Errors
    /// When the source cannot be read or is no log, or a table's columns are unclear or its time runs backwards.
    pub fn open(source: &Source, columns: &Columns) -> Result<Self, LogError> {
        let source = &unpacked(source).map_err(LogFault::named)?;
        let refuse = |form: &'static str| match columns.is_of_a_table() {
            true => Err(source.faulty(LogFault::NoColumns { form })),
            false => Ok(()),
        };
        let form = if let Some(format) = format_of(source)? {
            refuse("the log of an autopilot")?;
            Form::Autopilot(format)
        } else if columns.rates.is_empty() && Recording::is_one(source) {
            // Whoever names rates wants a table of a recording too.
            refuse("a recording of the bench")?;
            Form::Recording(Box::new(Recording::read(source).map_err(LogFault::named)?))
        } else {
            Form::Table(Box::new(TableLog::open(source, columns)?))
        };
        Ok(Self { source: source.clone(), form })
    }

    /// The autopilot's format, if it is an autopilot's log.
    #[must_use]
    pub fn autopilot(&self) -> Option<imu_logs::Format> {
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
    /// When the source cannot be read or holds what no log of its form can. What is whole of a log that was cut off or
    /// damaged is read, and the [`Ending`] says so.
    pub fn read(&self, sink: &mut dyn Sink) -> Result<Ending, LogError> {
        match &self.form {
            Form::Table(table) => table.read(sink),
            Form::Recording(recording) => Ok(of_recording::read(recording, sink)),
            Form::Autopilot(format) => {
                of_autopilot::read(&self.source, *format, sink).map_err(|error| self.source.faulty(error))
            }
        }
    }
}

#[cfg(test)]
mod tests;
