//! A run in numbers.

use std::time::SystemTime;

use zerorate_board_run::summary::{AxisSummary, Check, SCHEMA, Summary, TestResult, stamp};
use zerorate_cal::calibration::Origin;
use zerorate_cal::quality::Verdict;
use zerorate_cal::recording::Phase;
use zerorate_core::units::{Axis, Counts};
use zerorate_fit::least_squares::raw_coefficients;

use crate::calibrated::Calibrated;
use crate::evaluate::extremes;
use crate::measure::{Measured, MeasuredAxis};
use crate::setup::SetUp;

/// The summary of a run that left these recordings, began then and took so long by the wall clock.
#[must_use]
pub fn summary(run: &Calibrated, recordings: Vec<Origin>, started: SystemTime, wall_s: f64) -> Summary {
    let board = &run.setup.board;
    let failed = || run.checks.iter().filter(|check| !check.passed);
    let axes = Axis::BOTH.map(|axis| (axis.name().to_owned(), axis_summary(&run.measured, &run.setup, axis)));
    Summary {
        schema: SCHEMA,
        plant: run.unit.plant.map(|(kind, _)| kind.name().to_owned()),
        seed: run.unit.plant.map(|(_, seed)| seed),
        serial: run.unit.serial.to_string(),
        verdict: verdict(run),
        started: run.unit.plant.is_none().then(|| stamp(started)),
        wall_s,
        trim_part: board.trim_part.clone(),
        counts_per_dps: board.counts_per_dps,
        axes: axes.into(),
        tests: tests(run),
        checks: run.checks.clone(),
        recordings,
        soaks: run.soaks.clone(),
        failed_checks: failed().map(Check::sentence).collect(),
        warnings: run.measured.calibration.warnings.clone(),
    }
}

/// Good, where every check was passed, no compensation has made its axis worse in any test, and ramp and tests were over the
/// temperatures asked for.
fn verdict(run: &Calibrated) -> Verdict {
    let mut results = run.verifications.iter().flat_map(|test| &test.results);
    let warns = results.any(|result| !result.warnings().is_empty()) || !run.cut_short.is_empty();
    match run.checks.iter().all(|check| check.passed) {
        false => Verdict::Rejected,
        true if warns => Verdict::Warning,
        true => Verdict::Good,
    }
}

/// X heating, X cooling, then Y.
fn tests(run: &Calibrated) -> Vec<TestResult> {
    let mut tests: Vec<TestResult> = run.verifications.iter().flat_map(|test| test.results.clone()).collect();
    tests.sort_by_key(|test| (test.axis.index(), test.direction == Phase::Cooling));
    tests
}

/// Where the ramp covers too little of what was asked for, or went where no chamber was sent, a sentence for each axis.
pub(crate) fn cut_short(measured: &Measured, setup: &SetUp) -> impl Iterator<Item = String> {
    let of_axis = |axis| {
        let summary = axis_summary(measured, setup, axis);
        summary.warning(axis.name()).or_else(|| off_scale(setup, axis, summary.temperature_counts))
    };
    Axis::BOTH.into_iter().filter_map(of_axis)
}

/// Where a gyro's own temperature, by the set-up's scale, is far from the chamber's: a scale of another sensor makes every degree of
/// a certificate another.
fn off_scale(setup: &SetUp, axis: Axis, [coldest, hottest]: [f64; 2]) -> Option<String> {
    /// A gyro warms itself by less, kelvin.
    const BY_ITSELF: f64 = 20.0;
    let [from, to] = [coldest, hottest].map(|counts| setup.celsius(Counts(counts)).0);
    let [cold, hot] = setup.ends().map(|end| end.0);
    let is_off = (from - cold).abs() > BY_ITSELF || to > hot + BY_ITSELF;
    is_off.then(|| {
        format!(
            "axis {}: by board.counts_at_zero_celsius and board.counts_per_celsius the ramp went from {from:.0} to {to:.0} C, and the chamber was sent from {cold:.0} to {hot:.0} C: see whether the scale is the gyro's; until then no degree that is told of it is true",
            axis.name().to_uppercase()
        )
    })
}

fn axis_summary(measured: &Measured, setup: &SetUp, of: Axis) -> AxisSummary {
    let axis = &measured.axes[of.index()];
    let MeasuredAxis { drift, trim, .. } = axis;
    let [coldest, hottest] = extremes(measured.ramp.iter().map(|taken| taken.temperature(of).0));
    let heating = measured.ramp.iter().filter(|taken| taken.phase == Phase::Heating);
    let [cold, hot] = setup.ends();
    let asked = (hot - cold).0 * setup.board.counts_per_celsius;
    let (drift, statistics) = (&drift.calibration, &drift.calibration.fit.statistics);
    AxisSummary {
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
        heating_temperature_counts: Some(extremes(heating.map(|taken| taken.temperature(of).0))),
        share_of_asked_range: Some((hottest - coldest) / asked),
        curve_error_counts: axis.curve_error_counts,
        fit_rms_counts: statistics.in_sample.rms,
        fit_pp_counts: statistics.in_sample.pp,
        held_out_rms_counts: statistics.held_out.map(|residual| residual.rms),
        held_out_pp_counts: statistics.held_out.map(|residual| residual.pp),
    }
}
