//! What `zerorate fit` does: logs of one unit in, a drift curve and a verdict for each axis of each sensor out.
//!
//! A log is read once to three times and never kept. In plain mode a fit is ordinary least squares on every row that
//! has a temperature and a rate, each counted once: the reference to hold against other tools. Otherwise rows are first
//! conditioned and averaged to groups of about 10 s ([`crate::condition`]), and the fit is of the groups.

mod gather;
mod grouped;
mod json;
mod plain;
mod residual;
mod words;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;
use zerorate_core::drift::{Drift, History, Scale, ValidRange};

use crate::auto::AutoFit;
use crate::calibration::{BandPoint, HeldOut, StaticCubic, TimeDrift};
use crate::choose::{Choice, Model, Stretches};
use crate::condition::{Rejected, Stretch};
use crate::interop;
use crate::log::{LogError, Sensor, SensorChoice, Stream};
use crate::quality::{Judgement, Reason, ReasonKind, TemperatureUnit, Verdict};
use crate::recorded::fit_recording;
use crate::recording::{Recording, RecordingError};
use crate::table::{Columns, RateUnit};
pub(crate) use residual::{Residuals, trace};

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
    /// Seconds in a group; `None` for about 10 s, and shorter where the log is.
    pub group_s: Option<f64>,
    /// The sensors to fit; `None` for all.
    pub sensor: Option<SensorChoice>,
}

/// Why a log cannot be fitted. What can be judged is no error but a verdict.
#[derive(Debug, Error)]
pub enum LogFitError {
    /// The log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The bench's own recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// Several logs have no sensor in common.
    #[error(
        "{}: this is another unit's log: it has {found}, and the logs before it {expected}: fit each unit by itself",
        path.display()
    )]
    AnotherUnit {
        /// The file.
        path: PathBuf,
        /// The sensors of the logs before it.
        expected: String,
        /// Its sensors.
        found: String,
    },
    /// The plain fit was asked for of several logs.
    #[error("the plain fit is of one log, to compare it with other tools: give one log, or leave out --plain")]
    PlainOfSeveral,
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
    /// The axis's name: a table's column, or `gyro0.x`.
    pub name: String,
    /// The sensor, where the log tells of sensors.
    pub sensor: Option<Sensor>,
    /// What the axis is good for: good or with warnings, for a rejected one has no curve.
    pub verdict: Verdict,
    /// The rate's unit; for an accelerometer, that of its specific force.
    pub rate_unit: RateUnit,
    /// The temperature's unit.
    pub temperature_unit: TemperatureUnit,
    /// Where the drift is 0 by definition: an accelerometer at rest shows its constant and gravity together. `None` where
    /// the constant is part of the drift.
    pub reference_temperature: Option<f64>,
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

impl AxisFit {
    /// The axis of a fit of groups ([`crate::auto`]), before anything is said of what they are groups of.
    pub(crate) fn of_auto(
        name: &str,
        (rate_unit, temperature_unit): (RateUnit, TemperatureUnit),
        auto: AutoFit,
        trace: Vec<TracePoint>,
    ) -> Self {
        let choice = Choice {
            model: Model::of_shape(&auto.drift.shape),
            solution: auto.solution,
            without: Vec::new(),
            candidates: auto.candidates,
        };
        Self {
            name: name.to_owned(),
            sensor: None,
            verdict: Verdict::Good,
            rate_unit,
            temperature_unit,
            reference_temperature: None,
            drift: auto.drift,
            history: auto.history,
            time_drift: auto.time_drift,
            static_cubic: auto.static_cubic,
            band: auto.band,
            nested: Some(auto.nested),
            choice,
            in_sample: auto.in_sample,
            held_out: auto.held_out,
            samples_used: 0,
            samples_rejected: Vec::new(),
            trace,
        }
    }

    /// The model chosen: `poly:3`, or `poly:3 + 3 plays + time`.
    #[must_use]
    pub fn model(&self) -> String {
        let chosen = self.choice.candidates.iter().find(|candidate| candidate.chosen);
        chosen.map_or_else(|| self.choice.model.to_string(), ToString::to_string)
    }
}

/// What an axis is good for.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisVerdict {
    /// The axis's name.
    pub name: String,
    /// The verdict and its reasons; those of the whole log are not among them.
    pub judgement: Judgement,
}

/// A jump of an axis's rate that stayed, and was taken out.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundStep {
    /// The axis's name.
    pub axis: String,
    /// Its time, seconds from the log's first row; NaN without a time column.
    pub time_s: f64,
    /// The temperature there, in the column's unit.
    pub temperature: f64,
    /// After less before, rate units.
    pub size: f64,
}

/// The fit of a log, or of several of one unit.
#[derive(Debug, Clone, PartialEq)]
pub struct LogFit {
    /// The file, as it was given; of several, all with a plus between.
    pub source: String,
    /// The files, as they were given.
    pub sources: Vec<PathBuf>,
    /// The autopilot's format, if the logs are an autopilot's.
    pub autopilot: Option<interop::Format>,
    /// The verdict on the whole and all reasons: rejected where no axis could be fitted.
    pub judgement: Judgement,
    /// The verdict on each axis, fitted or not, in the order of the log.
    pub verdicts: Vec<AxisVerdict>,
    /// What was guessed about columns and units, a sentence each.
    pub notes: Vec<String>,
    /// One fit an axis that was not rejected, in the order of the log.
    pub axes: Vec<AxisFit>,
    /// Stretches left out; none in plain mode.
    pub stretches: Vec<Stretch>,
    /// Steps taken out; none in plain mode.
    pub steps: Vec<FoundStep>,
}

/// Fits a log, or a recording of the bench: that is known by what is in it, and its groups are fitted as they are
/// ([`crate::recorded`]).
///
/// # Errors
/// As [`fit_logs`].
pub fn fit_log(path: &Path, options: &FitOptions) -> Result<LogFit, LogFitError> {
    fit_logs(&[path], options)
}

/// Fits logs of one unit as one.
///
/// # Errors
/// When one cannot be read, a column is missing or unclear, time runs backwards, or the logs are of different units. A log
/// that can be read and is no good is rejected in [`LogFit::judgement`] instead.
pub fn fit_logs(paths: &[&Path], options: &FitOptions) -> Result<LogFit, LogFitError> {
    if let [path] = paths
        && Recording::is_one(path)
    {
        return Ok(fit_recording(&Recording::read(path)?, path, options));
    }
    let mut fit = LogFit {
        source: paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(" + "),
        sources: paths.iter().map(|path| (*path).to_owned()).collect(),
        autopilot: None,
        judgement: Judgement::default(),
        verdicts: Vec::new(),
        notes: Vec::new(),
        axes: Vec::new(),
        stretches: Vec::new(),
        steps: Vec::new(),
    };
    match (options.plain, paths) {
        (true, [path]) => plain::fit(path, options, &mut fit)?,
        (true, _) => return Err(LogFitError::PlainOfSeveral),
        (false, _) => grouped::fit(paths, options, &mut fit)?,
    }
    fit.judgement = Judgement::of_axes(&fit.judgement, fit.verdicts.iter().map(|axis| &axis.judgement));
    Ok(fit)
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
    let what = if options.plain { "rows" } else { "groups" };
    judgement.rows(&stream.names[axis], rows, what, options.model.least_coefficients());
    if rows > 0 {
        judgement.span(min, max, stream.temperature_unit, options.allow_narrow);
    }
    if judgement.rejected() {
        return None;
    }
    Scale::spanning(min, max).zip(ValidRange::new(min, max))
}

/// Chooses an axis's model; a model that the rows do not settle rejects the axis.
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
