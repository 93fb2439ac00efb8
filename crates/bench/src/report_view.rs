//! A run as its report tells it.

use zerorate_cal::quality::Verdict;
use zerorate_core::drift::{Drift, ValidRange};
use zerorate_core::units::Axis;
use zerorate_fit::least_squares::raw_coefficients;
use zerorate_fit::trim::TrimEstimate;
use zerorate_report::{
    AxisSoaks, CalibratedAxis, CalibrationReport, CompensationTest, Direction, DriftFacts, Mode, RampPoint,
    SoakComparison, SoakPoint, TapDeviation, TestPoint, TrimFacts, TrimLine, TrimPoint, UnitFacts,
};

use crate::calibrated::Calibrated;
use crate::evaluate::TestResult;
use crate::measure::MeasuredAxis;
use crate::run::Taken;
use crate::verify::Verification;

/// The report of a run.
#[must_use]
pub fn report(run: &Calibrated) -> CalibrationReport {
    CalibrationReport {
        unit: unit(run),
        verdict: if run.passed() { Verdict::Good } else { Verdict::Rejected },
        axes: Axis::BOTH.map(|axis| calibrated_axis(run, axis)).into(),
        tests: tests(run),
        soaks: Some(soaks(run)),
        checks: run.checks.clone(),
        warnings: run.measured.calibration.warnings.clone(),
    }
}

fn unit(run: &Calibrated) -> UnitFacts {
    let sources = run
        .measured
        .calibration
        .sources
        .iter()
        .map(|source| (format!("SHA-256 of {}", source.file), source.sha256.clone()));
    UnitFacts {
        serial: run.unit.serial.to_string(),
        device: if run.unit.plant.is_some() { "native device, MAX5494" } else { "board, MAX5494" }.into(),
        plant: run.unit.plant.map(|(kind, _)| kind.name().into()),
        seed: run.unit.plant.map(|(_, seed)| seed),
        centre_counts: run.setup.board.centre_counts,
        middle_tap: run.setup.board.middle_tap,
        group_samples: u32::from(run.setup.acquisition.group_length),
        groups_per_minute: 60.0 / run.setup.group_period().0,
        scale_counts_per_dps: Some(run.setup.board.counts_per_dps),
        further: sources.collect(),
    }
}

fn calibrated_axis(run: &Calibrated, axis: Axis) -> CalibratedAxis {
    let measured = &run.measured.axes[axis.index()];
    let began = run.measured.ramp.first().map_or(0.0, |taken| taken.time.0);
    let ramp = run.measured.ramp.iter().zip(&measured.predicted).map(|(taken, predicted)| RampPoint {
        elapsed_s: taken.time.0 - began,
        temperature_counts: taken.temperature(axis).0,
        zro_counts: taken.zro(axis).0,
        fitted_counts: *predicted,
    });
    CalibratedAxis {
        name: axis.name().to_uppercase(),
        ramp: ramp.collect(),
        drift: drift_facts(measured),
        trim: trim_facts(measured),
    }
}

fn drift_facts(measured: &MeasuredAxis) -> DriftFacts {
    let drift = &measured.drift.calibration;
    let statistics = &drift.fit.statistics;
    let is_polynomial = matches!(drift.drift().shape, zerorate_core::drift::Shape::Polynomial(_));
    DriftFacts {
        model: drift.fit.chosen_model(),
        remembers: drift.fit.model.history.is_some(),
        raw_coefficients: if is_polynomial { raw_coefficients(&drift.drift().shape) } else { Vec::new() },
        temperature_counts: [drift.drift().valid.min(), drift.drift().valid.max()],
        drift_pp_counts: measured.drift_pp_counts,
        fit_rms_counts: statistics.in_sample.rms,
        held_out_rms_counts: statistics.held_out.map_or(f64::NAN, |residual| residual.rms),
        curve_error_counts: measured.curve_error_counts,
        candidates: statistics.candidates.clone(),
    }
}

fn trim_facts(measured: &MeasuredAxis) -> TrimFacts {
    let trim = &measured.trim;
    let middle = f64::from(trim.middle.get());
    let line = |estimate: &TrimEstimate| TrimLine {
        slope_taps_per_count: estimate.slope_taps_per_count,
        intercept_taps: estimate.intercept_taps,
        centre_counts: estimate.centre_counts,
    };
    let per_tap = trim.paired.counts_per_tap().0;
    let measured_taps = measured.law.trim.measured.iter();
    let taps = measured_taps.flat_map(|effects| (effects.first().get()..).zip(effects.effects()));
    TrimFacts {
        points: trim
            .points
            .iter()
            .map(|point| TrimPoint {
                delta_counts: (point.at_middle - point.trimmed).0,
                delta_taps: f64::from(point.tap.get()) - middle,
            })
            .collect(),
        paper: line(&trim.paper),
        better: line(&trim.paired),
        plant_slope_taps_per_count: measured.plant_slope_taps_per_count,
        taps: taps
            .map(|(tap, effect)| TapDeviation { tap, deviation_counts: effect.0 - per_tap * (f64::from(tap) - middle) })
            .collect(),
    }
}

fn tests(run: &Calibrated) -> Vec<CompensationTest> {
    let mut tests = Vec::new();
    for result in run.results() {
        let found = run.verifications.iter().find(|verification| verification.results.contains(result));
        tests.extend(found.map(|verification| compensation_test(run, verification, result)));
    }
    tests
}

fn compensation_test(run: &Calibrated, verification: &Verification, result: &TestResult) -> CompensationTest {
    let axis = verification.run.axis;
    let heating = result.direction == "heating";
    let ramp = if heating { &verification.run.heating } else { &verification.run.cooling };
    let began = ramp.first().map_or(0.0, |taken| taken.time.0);
    let point = |taken: &Taken| TestPoint {
        elapsed_s: taken.time.0 - began,
        temperature_counts: taken.temperature(axis).0,
        compensated_counts: taken.corrected(axis).0,
        control_counts: taken.zro(axis.other()).0,
    };
    CompensationTest {
        mode: match verification.run.mode {
            zerorate_core::compensate::Mode::Hybrid => Mode::Hybrid,
            zerorate_core::compensate::Mode::Digital => Mode::Digital,
            _ => Mode::Trim,
        },
        axis: axis.name().to_uppercase(),
        control: axis.other().name().to_uppercase(),
        direction: if heating { Direction::Heating } else { Direction::Cooling },
        residual_pp_counts: result.residual_pp_counts,
        residual_rms_counts: result.residual_rms_counts,
        control_pp_counts: result.control_pp_counts,
        uncompensated_pp_counts: run.measured.axes[axis.index()].drift_pp_counts,
        floor_pp_counts: result.floor_pp_counts.unwrap_or(f64::NAN),
        wiper_writes: result.wiper_writes,
        taps_crossed: result.taps_crossed.unwrap_or(0),
        mean_counts: result.mean_counts,
        largest_step_counts: result.largest_step_counts,
        points: ramp.iter().map(point).collect(),
    }
}

fn soaks(run: &Calibrated) -> SoakComparison {
    const SECONDS_AN_HOUR: f64 = 3600.0;
    SoakComparison {
        ramp_hours: run.measured.ramp_time.0 / SECONDS_AN_HOUR,
        soak_hours: run.soaks.chamber_time.0 / SECONDS_AN_HOUR,
        axes: Axis::BOTH
            .map(|axis| {
                let drift = run.measured.axes[axis.index()].drift.calibration.drift();
                let points: Vec<SoakPoint> = run
                    .setup
                    .chamber
                    .soaks_c
                    .iter()
                    .zip(&run.soaks.points)
                    .map(|(&chamber_c, point)| {
                        let (temperature, zro) = point[axis.index()];
                        SoakPoint {
                            chamber_c,
                            temperature_counts: temperature.0,
                            zro_counts: zro.0,
                            ramp_counts: drift.evaluate(temperature.0).0,
                        }
                    })
                    .collect();
                let largest_difference_counts = largest_difference(drift, &points);
                AxisSoaks { name: axis.name().to_uppercase(), points, largest_difference_counts }
            })
            .into(),
    }
}

/// The largest distance between the ramp's curve and straight lines through the soaks, at the soaks: what each soak
/// says of the curve that it was not used for. Soaks outside the ramp's range are left out.
fn largest_difference(drift: &Drift, points: &[SoakPoint]) -> f64 {
    let valid: ValidRange = drift.valid;
    points
        .iter()
        .filter(|point| (valid.min()..=valid.max()).contains(&point.temperature_counts))
        .map(|point| (point.zro_counts - point.ramp_counts).abs())
        .fold(0.0, f64::max)
}
