//! What `zerorate fit` does: a log in, a drift curve for each rate column and a verdict out.
//!
//! The log is read two or three times and never kept. In plain mode a fit is ordinary least squares on every row that
//! has a temperature and a rate, each counted once: the reference to hold against other tools. Otherwise rows are first
//! conditioned and averaged to groups of about 10 s ([`crate::condition`]), and the fit is of the groups.

mod grouped;
mod json;
mod plain;
mod residual;
mod survey;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;
use zerorate_core::drift::{Drift, History, Scale, ValidRange};

use crate::calibration::{BandPoint, HeldOut, StaticCubic, TimeDrift};
use crate::choose::{Choice, Model, Stretches};
use crate::condition::{Rejected, Step, Stretch};
use crate::quality::{Judgement, Reason, ReasonKind, TemperatureUnit};
use crate::table::{Columns, RateUnit, Resolved, TableError, TableFile};
pub(crate) use residual::Residuals;
use survey::Survey;

/// Points in a trace, at most: more than a figure can show.
const TRACE_POINTS: u64 = 2000;

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
}

/// Why a log cannot be fitted. What can be judged is no error but a verdict.
#[derive(Debug, Error)]
pub enum LogFitError {
    /// The log cannot be read.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A row's time is before that of the row above it.
    #[error(
        "{}: row {row}: column '{column}' runs backwards, from {before} to {after}: the log is damaged, or several were joined: split it there",
        path.display()
    )]
    TimeBackwards {
        /// The file.
        path: PathBuf,
        /// The row, from 1, the header not counted.
        row: u64,
        /// The time column's name.
        column: String,
        /// The time above.
        before: f64,
        /// The time in the row.
        after: f64,
    },
}

/// A residual's size, in the rate's unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Root mean square about zero.
    pub rms: f64,
    /// Peak to peak.
    pub pp: f64,
}

/// A point for figures: the mean over some successive rows or groups.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct TracePoint {
    /// Seconds from the log's first row; NaN if not known.
    pub time_s: f64,
    /// In the temperature column's unit.
    pub temperature: f64,
    /// Rate less the steps taken out, in the rate column's unit.
    pub rate: f64,
    /// Rate less the fitted curve.
    pub residual: f64,
}

/// The fit of one rate column.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisFit {
    /// The column's name.
    pub name: String,
    /// The rate's unit.
    pub rate_unit: RateUnit,
    /// The temperature's unit.
    pub temperature_unit: TemperatureUnit,
    /// The curve with its valid range: the least and greatest temperature fitted.
    pub drift: Drift,
    /// What the drift remembers of its temperatures. `drift` and `choice` are then the static curve for when that is not
    /// known.
    pub history: Option<History>,
    /// The recording's own drift in time, which is not deployed.
    pub time_drift: Option<TimeDrift>,
    /// The best static cubic of the same data.
    pub static_cubic: Option<StaticCubic>,
    /// The prediction band over temperature, coldest first.
    pub band: Vec<BandPoint>,
    /// How the whole choice predicts what played no part in it; `None` where nothing was chosen.
    pub nested: Option<HeldOut>,
    /// The model chosen, its coefficients, covariance and rivals.
    pub choice: Choice,
    /// Residual of the fit of everything: over rows in plain mode, over groups otherwise.
    pub in_sample: Spread,
    /// Residual of eight contiguous stretches, each predicted by the fit of the others, over the same rows or groups.
    /// NaN where the others do not settle the model.
    pub held_out: Spread,
    /// Rows that were fitted, each counted once, in groups or not.
    pub samples_used: u64,
    /// Rows that were not, by reason.
    pub samples_rejected: Vec<Rejected>,
    /// Points for figures, in order of time.
    pub trace: Vec<TracePoint>,
}

/// The fit of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct LogFit {
    /// The file, as it was given.
    pub source: String,
    /// The verdict and its reasons.
    pub judgement: Judgement,
    /// What was guessed about columns and units, a sentence each.
    pub notes: Vec<String>,
    /// One fit a rate column, in the order of the columns; none when the log is rejected.
    pub axes: Vec<AxisFit>,
    /// Stretches left out; none in plain mode.
    pub stretches: Vec<Stretch>,
    /// Steps taken out; none in plain mode.
    pub steps: Vec<Step>,
}

/// Fits a log.
///
/// # Errors
/// When it cannot be read, a column is missing or unclear, or time runs backwards. A log that can be read and is no good
/// is rejected in [`LogFit::judgement`] instead.
pub fn fit_log(path: &Path, options: &FitOptions) -> Result<LogFit, LogFitError> {
    let table = TableFile::open(path)?;
    let columns = options.columns.resolve(&table)?;
    let survey = Survey::of(&table, &columns)?;
    let mut fit = LogFit {
        source: path.display().to_string(),
        judgement: Judgement::default(),
        notes: columns.notes.iter().chain(&survey.notes).cloned().collect(),
        axes: Vec::new(),
        stretches: Vec::new(),
        steps: Vec::new(),
    };
    let log = Log { table, columns, survey };
    if options.plain {
        plain::fit(&log, options, &mut fit)?;
    } else {
        grouped::fit(&log, options, &mut fit)?;
    }
    if fit.judgement.rejected() {
        fit.axes.clear();
    }
    Ok(fit)
}

/// A log that was opened and surveyed.
struct Log {
    table: TableFile,
    columns: Resolved,
    survey: Survey,
}

/// Judges what would be fitted of one axis and, unless it is rejected, gives its scale and valid range.
fn admit(
    judgement: &mut Judgement,
    options: &FitOptions,
    log: &Log,
    axis: usize,
    rows: u64,
    (min, max): (f64, f64),
) -> Option<(Scale, ValidRange)> {
    let what = if options.plain { "rows" } else { "groups" };
    judgement.rows(&log.columns.rate_names[axis], rows, what, options.model.least_coefficients());
    if rows > 0 {
        judgement.span(min, max, log.columns.temperature_unit, options.allow_narrow);
    }
    if judgement.rejected() {
        return None;
    }
    Scale::spanning(min, max).zip(ValidRange::new(min, max))
}

/// Chooses an axis's model; a model that the rows do not settle rejects the log.
fn choose(
    judgement: &mut Judgement,
    options: &FitOptions,
    name: &str,
    stretches: &Stretches,
    valid: ValidRange,
) -> Option<(Choice, Drift)> {
    match stretches.choose(options.model) {
        Ok(choice) => {
            let shape = choice.solution.shape()?;
            Some((choice, Drift { shape, valid }))
        }
        Err(error) => {
            judgement.add(Reason::new(ReasonKind::TooFewGroups, format!("{name}: {error}")));
            None
        }
    }
}

#[cfg(test)]
mod tests;
