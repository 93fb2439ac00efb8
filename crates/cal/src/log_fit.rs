//! What `zerorate fit` does: logs of one unit in, a drift curve and a verdict for each axis of each sensor out.
//!
//! A log is read once to three times and never kept. In plain mode a fit is ordinary least squares on every row that
//! has a temperature and a rate, each counted once: the reference to hold against other tools. Otherwise rows are first
//! conditioned and averaged to groups of about 10 s ([`crate::condition`]), and the fit is of the groups.

mod apart;
mod averages;
mod gather;
mod grouped;
mod json;
pub(crate) mod one_way;
mod overlap;
mod part;
mod plain;
mod repeated;
mod words;

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::time::SystemTime;

pub use averages::{are_alike, zero_taken_in};
pub use overlap::LogRows;

use thiserror::Error;
use zerorate_core::drift::{Scale, ValidRange};
use zerorate_fit::drift_fit::LogLeft;
use zerorate_fit::model::Model;

use crate::calibration::{AxisCalibration, Calibration, CalibrationFault, Kind, Origin, scale, sha256};
use crate::condition::{Excluded, Rejected};
use crate::log::{LogError, LogFault, SensorChoice, Stream};
use crate::quality::{Judgement, Verdict};
use crate::source::Source;
use crate::table::Columns;
use crate::units::{RateScale, RateUnit, TemperatureUnit, WrittenRate};
use zerorate_fit::trace::TracePoint;

/// Seconds that a group may take: rows of a log are no closer, and a ramp has more than a few groups.
pub const GROUP_SECONDS: RangeInclusive<f64> = 0.01..=600.0;

/// How a log is to be fitted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FitOptions {
    /// Which column is which.
    pub columns: Columns,
    /// The model.
    pub model: Model,
    /// Ordinary least squares on every numeric row, without conditioning.
    pub plain: bool,
    /// Fit a narrow temperature span too; the verdict is then a warning.
    pub allow_narrow: bool,
    /// Seconds in a group, of [`GROUP_SECONDS`]; `None` for about 10 s, and shorter where the log is.
    pub group_s: Option<f64>,
    /// The sensors to fit; `None` for all.
    pub sensor: Option<SensorChoice>,
    /// Tell a step of the rate, and leave it in: what a calibration leaves of a run has it too.
    pub keep_steps: bool,
    /// The unit in which sentences tell rates, where they can be told in it; `None` for the log's own, or a thousandth of it.
    pub told_in: Option<WrittenRate>,
}

impl FitOptions {
    /// Whether nothing is asked for that only a log's rows can give.
    pub(crate) fn is_of_ramps(&self) -> bool {
        !self.plain && self.columns == Columns::default() && self.group_s.is_none() && self.sensor.is_none()
    }
}

/// Why a log cannot be fitted. What can be judged is no error but a verdict.
#[derive(Debug, Error)]
pub enum LogFitError {
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// Several logs have no sensor in common.
    #[error(
        "{name}: it has {found}, and the logs before it {expected}: if it is another unit's, fit it by itself; if the same unit's, name its columns and units as theirs are"
    )]
    AnotherUnit {
        /// The log.
        name: String,
        /// The sensors of the logs before it.
        expected: String,
        /// Its sensors.
        found: String,
    },
    /// The same log was given twice: each copy would be held out while the other is fitted.
    #[error(
        "{second}: the same log as {first}, to the byte: what is held out would be fitted all the same; give it once"
    )]
    Twice {
        /// The log.
        first: String,
        /// Its copy.
        second: String,
    },
    /// Rows of one log are rows of another: they would be held out while they are fitted.
    #[error(
        "{second}: {part} of its rows are in {first} as well: what is held out would be fitted all the same; give each row once"
    )]
    Overlapping {
        /// The log.
        first: String,
        /// The log that has rows of it.
        second: String,
        /// How much of it, in words.
        part: String,
    },
    /// A log is another in other numbers.
    #[error(
        "{second}: a copy of {first} in other numbers (rounded, or of another unit or clock) or with some of its rows, for it has the same noise or rows: what is held out would be fitted all the same; give each run once"
    )]
    Copied {
        /// The log.
        first: String,
        /// Its copy.
        second: String,
    },
    /// The plain fit was asked for of several logs.
    #[error("the plain fit is of one log, to compare it with other tools: give one log, or leave out `plain`")]
    PlainOfSeveral,
}

/// The fit of one rate column.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisFit {
    /// The axis's name: a table's column, or `gyro0.x`.
    pub name: String,
    /// What the axis is good for: good or with warnings, for a rejected one has no curve.
    pub verdict: Verdict,
    /// The temperature's unit.
    pub temperature_unit: TemperatureUnit,
    /// What was fitted, as a calibration keeps it.
    pub calibration: AxisCalibration,
    /// Rows that were not fitted, by reason.
    pub samples_rejected: Vec<Rejected>,
    /// The groups fitted, in order of time; of a plain fit means over successive rows.
    pub trace: Vec<TracePoint>,
}

/// What an axis is good for.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisVerdict {
    /// The axis's name.
    pub name: String,
    /// The verdict and its reasons; those of the whole log are not among them.
    pub judgement: Judgement,
}

impl AxisVerdict {
    /// The reasons as one sentence, without the axis's name, with which each begins.
    #[must_use]
    pub fn why(&self) -> String {
        let texts = self.judgement.reasons.iter().map(|reason| reason.text.as_str());
        let bare = |text: &'_ str| {
            let after = text.strip_prefix(self.name.as_str()).and_then(|text| text.strip_prefix(": "));
            after.unwrap_or(text).to_owned()
        };
        texts.map(bare).collect::<Vec<_>>().join("; ")
    }
}

/// A jump of an axis's rate that stayed, and was taken out.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundStep {
    /// The axis's name.
    pub axis: String,
    /// The times between which it lies, seconds from the first log's first row; NaN without a time column.
    pub time_s: (f64, f64),
    /// The temperatures between which it lies, in the column's unit.
    pub temperature: (f64, f64),
    /// After less before, rate units.
    pub size: f64,
}

/// A log that was fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedLog {
    /// Its name, as it was given.
    pub name: String,
    /// When its first row was taken, where it says so itself.
    pub started: Option<SystemTime>,
    /// What its rows are known by; nothing in plain mode and of ramps.
    pub rows: LogRows,
}

/// The fit of a log, or of several of one unit.
#[derive(Debug, Clone, PartialEq)]
pub struct LogFit {
    /// The logs, in the order in which they were given.
    pub sources: Vec<FittedLog>,
    /// The autopilot's format, if the logs are an autopilot's.
    pub autopilot: Option<imu_logs::Format>,
    /// The verdict on the whole and all reasons: rejected where no axis could be fitted.
    pub judgement: Judgement,
    /// The verdict on each axis, fitted or not, in the order of the log.
    pub verdicts: Vec<AxisVerdict>,
    /// What to know of how the logs were read, a sentence each; a unit that was guessed is a reason.
    pub notes: Vec<String>,
    /// One fit an axis that was not rejected, in the order of the log.
    pub axes: Vec<AxisFit>,
    /// Intervals left out; none in plain mode.
    pub excluded: Vec<Excluded>,
    /// Steps taken out; none in plain mode.
    pub steps: Vec<FoundStep>,
}

impl LogFit {
    /// The unit for what is told of the axes in this unit: that of their drifts.
    #[must_use]
    pub fn scale(&self, unit: RateUnit, asked: Option<WrittenRate>) -> RateScale {
        scale(self.axes.iter().map(|axis| &axis.calibration), unit, asked)
    }

    pub(crate) fn new(sources: &[Source]) -> Self {
        Self {
            sources: sources
                .iter()
                .map(|log| FittedLog { name: log.name().to_owned(), started: None, rows: LogRows::default() })
                .collect(),
            autopilot: None,
            judgement: Judgement::default(),
            verdicts: Vec::new(),
            notes: Vec::new(),
            axes: Vec::new(),
            excluded: Vec::new(),
            steps: Vec::new(),
        }
    }

    /// The logs in words: of several, all with a plus between.
    #[must_use]
    pub fn source(&self) -> String {
        self.sources.iter().map(|log| log.name.as_str()).collect::<Vec<_>>().join(" + ")
    }

    /// What is left of each of several logs, log by log, of every axis in a unit of which it is known. Nothing of one log, and
    /// of an axis that a log has in parts, or not at all.
    #[must_use]
    pub fn by_log(&self, unit: RateUnit) -> Vec<(&FittedLog, &AxisFit, LogLeft)> {
        let of_unit = self.axes.iter().filter(|axis| axis.calibration.rate_unit == unit);
        let left = of_unit.map(|axis| (axis, &axis.calibration.fit.statistics.by_log));
        let known: Vec<_> = left.filter(|(_, by_log)| by_log.len() == self.sources.len()).collect();
        let logs = self.sources.iter().enumerate();
        logs.flat_map(|(place, log)| known.iter().map(move |(axis, by_log)| (log, *axis, by_log[place]))).collect()
    }

    /// Every reason, a sentence each.
    pub fn reasons(&self) -> impl Iterator<Item = &str> {
        self.judgement.reasons.iter().map(|reason| reason.text.as_str())
    }

    /// The logs that were fitted, with their SHA-256.
    ///
    /// # Errors
    /// [`LogError`], when one cannot be read any more.
    pub fn origins(&self, sources: &[Source]) -> Result<Vec<Origin>, LogError> {
        let origin = |(source, log): (&Source, &FittedLog)| {
            let origin = Origin::of_log(self.autopilot, source).map_err(|error| source.faulty::<LogFault>(error))?;
            Ok(Origin { rows: log.rows.written(), ..origin.started_at(log.started) })
        };
        sources.iter().zip(&self.sources).map(origin).collect()
    }

    /// The calibration that comes of it.
    ///
    /// # Errors
    /// [`CalibrationFault::Rejected`], when the log was rejected: no calibration comes of it.
    pub fn to_calibration(
        &self,
        sources: Vec<Origin>,
        unit_serial: Option<String>,
    ) -> Result<Calibration, CalibrationFault> {
        let Some(first) = self.axes.first() else {
            return Err(CalibrationFault::Rejected { reasons: self.reasons().collect::<Vec<_>>().join("; ") });
        };
        let axes = self.axes.iter().map(|axis| (axis.name.clone(), axis.calibration.clone())).collect();
        let warnings = self.reasons().map(str::to_owned).collect();
        let calibration = Calibration::new(Kind::Log, unit_serial, sources, first.temperature_unit, axes);
        Ok(Calibration { warnings, averaged_over_s: self.averaged_over_s(), ..calibration })
    }
}

/// Fits logs of one unit as one.
///
/// # Errors
/// When one cannot be read, a column is missing or unclear, time runs backwards, or the logs are of different units. A log
/// that can be read and is no good is rejected in [`LogFit::judgement`] instead.
pub fn fit_logs(sources: &[Source], options: &FitOptions) -> Result<LogFit, LogFitError> {
    refuse_copies(sources)?;
    let mut fit = LogFit::new(sources);
    match (options.plain, sources) {
        (true, [source]) => plain::fit(source, options, &mut fit)?,
        (true, _) => return Err(LogFitError::PlainOfSeveral),
        (false, _) => grouped::fit(sources, options, &mut fit)?,
    }
    fit.judgement = Judgement::of_axes(&fit.judgement, fit.verdicts.iter().map(|axis| &axis.judgement));
    Ok(fit)
}

fn refuse_copies(sources: &[Source]) -> Result<(), LogFitError> {
    let hash = |source: &Source| sha256(source).map_err(|error| source.faulty::<LogFault>(error));
    let mut seen: BTreeMap<u64, Vec<&Source>> = BTreeMap::new();
    for source in sources.iter().filter(|_| sources.len() > 1) {
        // Logs of gigabytes are read for it only where there are two of a length.
        let as_long = seen.entry(source.length().map_err(|error| source.faulty::<LogFault>(error))?).or_default();
        for first in as_long.iter() {
            if hash(first)? == hash(source)? {
                return Err(LogFitError::Twice { first: first.name().to_owned(), second: source.name().to_owned() });
            }
        }
        as_long.push(source);
    }
    Ok(())
}

/// Judges what would be fitted of one axis and, unless it is rejected, gives its scale and valid range.
fn admit(
    judgement: &mut Judgement,
    options: &FitOptions,
    stream: &Stream,
    axis: usize,
    rows: u64,
    (min, max): (f64, f64),
) -> Option<(Scale, ValidRange)> {
    let noun = if options.plain { "row" } else { "group" };
    judgement.rows(&stream.names[axis], rows, noun, options.model.least_coefficients());
    if rows > 0 {
        judgement.celsius(min, max, stream.temperature_unit);
        judgement.span(min, max, stream.temperature_unit, options.allow_narrow);
    }
    if judgement.rejected() {
        return None;
    }
    Scale::spanning(min, max).zip(ValidRange::new(min, max))
}

#[cfg(test)]
mod tests;
