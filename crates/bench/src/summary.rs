//! `summary.json`: the run in numbers, for scripts.

use std::collections::BTreeMap;

use serde::Serialize;
use zerorate_fit::least_squares::raw_coefficients;
use zerorate_fit::residual::ResidualStatistics;

use crate::calibrated::Calibrated;
use crate::evaluate::TestResult;
use crate::measure::MeasuredAxis;

/// The version of the summary's form.
pub const SCHEMA: u32 = 1;

/// The run in numbers. Figures known on a simulated bench alone are left out on a real one.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// [`SCHEMA`].
    pub schema: u32,
    /// The simulated plant's name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plant: Option<String>,
    /// The simulated plant's seed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// The unit's serial.
    pub serial: String,
    /// `good` or `rejected`.
    pub verdict: &'static str,
    /// How long the run took by the wall clock, seconds.
    pub wall_s: f64,
    /// The axes by name.
    pub axes: BTreeMap<&'static str, AxisSummary>,
    /// The compensation tests.
    pub tests: Vec<TestResult>,
    /// What was outside its limit, a sentence each.
    pub failed_checks: Vec<String>,
    /// What to look at, a sentence each.
    pub warnings: Vec<String>,
}

/// One axis in numbers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AxisSummary {
    /// The drift model, as `poly:2`.
    pub model: String,
    /// The drift's coefficients in temperature counts, constant first, counts; a table's knots.
    pub drift_raw_coefficients: Vec<f64>,
    /// Zero-rate output over the ramp's hour, peak to peak.
    pub drift_pp_counts: f64,
    /// V0: mean of the trimmed readings (eq. 4).
    pub v0_counts: f64,
    /// a, each point against its own trimmed reading.
    pub trim_slope_taps_per_count: f64,
    /// b, the same.
    pub trim_intercept_taps: f64,
    /// a by the paper's formula (eq. 2 to 4).
    pub paper_trim_slope_taps_per_count: f64,
    /// b by the paper's formula.
    pub paper_trim_intercept_taps: f64,
    /// The plant's own slope over the taps that the experiment used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plant_slope_taps_per_count: Option<f64>,
    /// The least and greatest temperature fitted, counts.
    pub temperature_counts: [f64; 2],
    /// The largest distance of the fitted curve from the plant's deterministic curve of this run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub curve_error_counts: Option<f64>,
    /// Residual of the fit, rms, in-sample.
    pub fit_rms_counts: f64,
    /// Residual of the fit, peak to peak, in-sample.
    pub fit_pp_counts: f64,
    /// Residual of the folds, each predicted by the fit of the others, rms.
    pub held_out_rms_counts: f64,
    /// The same, peak to peak.
    pub held_out_pp_counts: f64,
}

impl Summary {
    /// The summary of a run.
    #[must_use]
    pub fn of(run: &Calibrated, wall_s: f64) -> Self {
        let axes = [("x", &run.measured.axes[0]), ("y", &run.measured.axes[1])];
        Self {
            schema: SCHEMA,
            plant: run.unit.plant.map(|(kind, _)| kind.name().to_owned()),
            seed: run.unit.plant.map(|(_, seed)| seed),
            serial: run.unit.serial.to_string(),
            verdict: if run.passed() { "good" } else { "rejected" },
            wall_s,
            axes: axes.map(|(name, axis)| (name, AxisSummary::of(axis))).into(),
            tests: run.results().cloned().collect(),
            failed_checks: run.failed_checks().collect(),
            warnings: run.measured.calibration.warnings.clone(),
        }
    }
}

impl AxisSummary {
    fn of(axis: &MeasuredAxis) -> Self {
        let MeasuredAxis { drift, trim, .. } = axis;
        let (drift, statistics) = (&drift.calibration, &drift.calibration.fit.statistics);
        let held_out = statistics.held_out.unwrap_or(ResidualStatistics::NONE);
        Self {
            model: drift.fit.chosen_model(),
            drift_raw_coefficients: raw_coefficients(&drift.drift().shape),
            drift_pp_counts: axis.drift_pp_counts,
            v0_counts: trim.paired.centre_counts,
            trim_slope_taps_per_count: trim.paired.slope_taps_per_count,
            trim_intercept_taps: trim.paired.intercept_taps,
            paper_trim_slope_taps_per_count: trim.paper.slope_taps_per_count,
            paper_trim_intercept_taps: trim.paper.intercept_taps,
            plant_slope_taps_per_count: axis.plant_slope_taps_per_count,
            temperature_counts: [drift.drift().valid.min(), drift.drift().valid.max()],
            curve_error_counts: axis.curve_error_counts,
            fit_rms_counts: statistics.in_sample.rms,
            fit_pp_counts: statistics.in_sample.pp,
            held_out_rms_counts: held_out.rms,
            held_out_pp_counts: held_out.pp,
        }
    }
}
