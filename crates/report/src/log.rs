//! What the report of a log's fit shows.

mod of_fit;
mod parameters;

use super::calibration::CandidateRow;
use zerorate_cal::characterise::Characteristics;
use zerorate_cal::quality::{Reason, Verdict};
use zerorate_fit::residual::ResidualStatistics;

/// The fit of a log. Rates and temperatures are in the log's own units.
#[derive(Debug, Clone, PartialEq)]
pub struct LogReport {
    /// The file, as it was given.
    pub source: String,
    /// What the log is good for.
    pub verdict: Verdict,
    /// What the verdict rests on, in the order found.
    pub reasons: Vec<Reason>,
    /// What was guessed about columns and units, a sentence each.
    pub notes: Vec<String>,
    /// The unit of all temperatures, as `°C`.
    pub temperature_unit: String,
    /// The axes; none when the log is rejected.
    pub axes: Vec<LogAxis>,
    /// The stretches left out, in order of time.
    pub left_out: Vec<LeftOut>,
    /// Parameters as other programs take them, to be copied.
    pub parameters: Vec<Parameters>,
    /// What to do to get a better log, a sentence each.
    pub advice: Vec<String>,
    /// The command to type next, if there is one.
    pub next_command: Option<String>,
}

/// One axis of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct LogAxis {
    /// The rate column's name.
    pub name: String,
    /// The unit of its rates, as `rad/s`; of an accelerometer's specific force, `m/s^2`.
    pub rate_unit: String,
    /// The model, as `poly:3`.
    pub model: String,
    /// The polynomial's coefficients, lowest power first, rate over temperature to the power of the place; for a table its
    /// values at the knots, which are equally spaced over the valid range.
    pub raw_coefficients: Vec<f64>,
    /// Whether `raw_coefficients` are those of a polynomial.
    pub is_polynomial: bool,
    /// The valid range: the least and the greatest temperature fitted.
    pub temperature: [f64; 2],
    /// Residual of the fit of everything.
    pub in_sample: ResidualStatistics,
    /// Residual of stretches, each predicted by the fit of the others.
    pub held_out: ResidualStatistics,
    /// Samples that were fitted.
    pub samples_used: u64,
    /// Samples that were not.
    pub samples_rejected: Vec<RejectedSamples>,
    /// The models compared, simplest first.
    pub candidates: Vec<CandidateRow>,
    /// What was fitted, in order of time.
    pub points: Vec<LogPoint>,
    /// Noise, hysteresis and sensitivities; `None` where they were not looked for.
    pub characteristics: Option<Characteristics>,
    /// Temperatures with what 95 of 100 averages stay within of the prediction, coldest first; empty where it is not known.
    pub band: Vec<(f64, f64)>,
}

/// A calibration in another program's form.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parameters {
    /// The program, as people know it.
    pub program: String,
    /// The command that writes it to a file.
    pub command: String,
    /// The text, or why there is none.
    pub text: Result<String, String>,
}

/// Samples left out for one reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RejectedSamples {
    /// The reason, in words.
    pub reason: String,
    /// How many.
    pub count: u64,
}

/// The mean of some successive samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogPoint {
    /// Time since the log's first row; NaN if the log has no time.
    pub elapsed_s: f64,
    /// Temperature.
    pub temperature: f64,
    /// Rate as it was recorded.
    pub rate: f64,
    /// Rate less the fitted curve.
    pub corrected: f64,
}

/// A stretch of a log that was left out.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOut {
    /// Why, in words.
    pub reason: String,
    /// Its first moment, since the log's first row; NaN if the log has no time.
    pub start_s: f64,
    /// Its last moment, since the log's first row; NaN if the log has no time.
    pub end_s: f64,
    /// The least and the greatest temperature in it.
    pub temperature: [f64; 2],
    /// Rows left out.
    pub rows: u64,
}
