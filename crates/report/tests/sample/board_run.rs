//! A run of the paper's board by its own equations, with noise, a saw-tooth and a little hysteresis.

#![allow(clippy::unwrap_used)] // what a test cannot do without

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde_json::json;
use zerorate_board_run::folder::{BoardRun, FULL_TEMPERATURE};
use zerorate_board_run::summary::{AxisSoaks, AxisSummary, Check, SCHEMA, SoakPoint, Soaks, Summary, TestResult};
use zerorate_cal::calibration::{Calibration, Kind, Origin, TrimCalibration};
use zerorate_cal::log_fit::{AxisFit, FitOptions};
use zerorate_cal::quality::Verdict;
use zerorate_cal::ramp_fit::fit_recording;
use zerorate_cal::recording::{GroupRow, Phase, Recording, RecordingInfo};
use zerorate_cal::source::Source;
use zerorate_cal::units::TemperatureUnit;
use zerorate_core::compensate::{LowPass, Mode};
use zerorate_core::group::GroupSums;
use zerorate_core::trim::TapEffects;
use zerorate_core::units::{Axis, Counts, Taps, Volts};
use zerorate_fit::trim::{SupplyPoint, fit_trim};

use super::noise;

const GROUPS: u32 = 2400;
const CENTRE: f64 = 8200.0;
const MIDDLE: u16 = 511;

struct Gyro {
    axis: Axis,
    drift: [f64; 3],
    slope: f64,
    seed: u64,
}

const X: Gyro =
    Gyro { axis: Axis::X, drift: [13_435.7, -0.894_782, 0.375_298e-4], slope: -0.031_990_6, seed: 1_000_000 };
const Y: Gyro =
    Gyro { axis: Axis::Y, drift: [12_516.1, -0.676_531, 0.276_524e-4], slope: -0.031_609_3, seed: 2_000_000 };

impl Gyro {
    fn zro(&self, temperature: f64) -> f64 {
        let [c0, c1, c2] = self.drift;
        c0 + temperature * (c1 + temperature * c2)
    }

    /// The reading of a group, counts. Cooling runs a few counts below heating, most in the middle.
    fn reading(&self, temperature: f64, direction: Phase, run: u32, group: u32) -> f64 {
        let share = (temperature - 8500.0) / 3400.0;
        let hysteresis = if direction == Phase::Cooling { -18.0 * share * (1.0 - share) } else { 0.0 };
        self.zro(temperature) + hysteresis + 0.9 * noise(self.seed + u64::from(run * 10_000 + group))
    }
}

/// The die's temperature in counts: the chamber's ramp, followed with a lag.
fn temperature(group: u32, direction: Phase) -> f64 {
    let hours = f64::from(group) / f64::from(GROUPS);
    let share = 1.02 * (1.0 - (-3.2 * hours * hours.sqrt()).exp()).min(1.0);
    if direction == Phase::Cooling { 11_900.0 - 3400.0 * share } else { 8500.0 + 3400.0 * share }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // some millions
fn sums(temperature: f64, zro: f64) -> GroupSums {
    let sum = |mean: f64| (mean * 500.0).round() as u64;
    GroupSums { n: 500, temperature: sum(temperature), zro: sum(zro), ..GroupSums::default() }
}

fn pp(values: impl Iterator<Item = f64>) -> f64 {
    let (min, max) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    max - min
}

/// The groups of one ramp in a recording: one axis compensated in a mode, the other left alone.
fn ramp(run: u32, direction: Phase, compensated: &Gyro, mode: Mode) -> impl Iterator<Item = GroupRow> {
    let (axis, slope) = (compensated.axis, compensated.slope);
    (0..GROUPS).flat_map(move |group| {
        [&X, &Y].map(|gyro| {
            let temperature = temperature(group, direction);
            let reading = gyro.reading(temperature, direction, run, group);
            let taps = (gyro.slope * (gyro.zro(temperature) - CENTRE)).round() / slope;
            let corrected = match mode {
                _ if gyro.axis != axis => reading,
                Mode::Trim => reading - taps,
                Mode::Digital | Mode::Hybrid => reading - gyro.zro(temperature) + CENTRE,
                Mode::Off => reading,
            };
            GroupRow {
                group: run * GROUPS + group,
                t_s: 1.5 * f64::from(run * GROUPS + group + 1),
                phase: direction,
                axis: gyro.axis,
                sums: sums(temperature, reading),
                corrected_counts: corrected,
                tap: MIDDLE,
                mode: if gyro.axis == axis { mode } else { Mode::Off },
                chamber_set_c: f64::NAN,
                chamber_c: f64::NAN,
                status_bits: 0,
            }
        })
    })
}

fn recording(rows: impl Iterator<Item = GroupRow>) -> Recording {
    Recording { info: RecordingInfo::default(), rows: rows.collect(), cut: false }
}

fn trim(gyro: &Gyro) -> TrimCalibration {
    let per_tap = -1.0 / gyro.slope;
    let point = |i: u8| {
        let at_middle = CENTRE + (f64::from(i) - 10.0) * 60.0 + 180.0;
        let off = |tap: u16| (at_middle - CENTRE + per_tap * (f64::from(tap) - f64::from(MIDDLE))).abs();
        let nearest = (0..=1023).min_by(|a, b| off(*a).total_cmp(&off(*b)));
        let tap = nearest.and_then(Taps::new).unwrap();
        let trimmed = at_middle + per_tap * (f64::from(tap.get()) - f64::from(MIDDLE));
        let trimmed = Counts(trimmed + 0.8 * noise(gyro.seed + u64::from(i)));
        SupplyPoint { supply: Volts(2.5 + f64::from(i) * 0.01), at_middle: Counts(at_middle), trimmed, tap }
    };
    let points: Vec<SupplyPoint> = (0..21).map(point).collect();
    let fit = fit_trim(&points, Counts(CENTRE), Taps::new(MIDDLE).unwrap()).unwrap();
    let effect =
        |tap: u16| Counts(per_tap * (f64::from(tap) - f64::from(MIDDLE)) + 1.6 * noise(gyro.seed + u64::from(tap)));
    let effects: Vec<Counts> = (490..532).map(effect).collect();
    let trim = fit.trim(Counts(CENTRE), TapEffects::new(Taps::new(490).unwrap(), &effects)).unwrap();
    TrimCalibration {
        trim,
        points,
        paired: Some(fit.paired),
        paper: Some(fit.paper),
        dead_band_taps: 0.05,
        low_pass: LowPass { missing_at_first: 0.5, missing_per_sample: 0.5 },
        start_up_mode: Mode::Hybrid,
    }
}

fn axis_summary(gyro: &Gyro, fit: &AxisFit, trim: &TrimCalibration) -> AxisSummary {
    let (paired, paper) = (trim.paired.unwrap(), trim.paper.unwrap());
    let statistics = &fit.calibration.fit.statistics;
    let valid = fit.calibration.drift().valid;
    AxisSummary {
        model: fit.calibration.fit.chosen_model(),
        drift_raw_coefficients: gyro.drift.to_vec(),
        drift_pp_counts: pp(fit.trace.iter().map(|point| point.rate)),
        v0_counts: paired.centre_counts,
        trim_slope_taps_per_count: paired.slope_taps_per_count,
        trim_intercept_taps: paired.intercept_taps,
        paper_trim_slope_taps_per_count: paper.slope_taps_per_count,
        paper_trim_intercept_taps: paper.intercept_taps,
        plant_slope_taps_per_count: Some(gyro.slope),
        temperature_counts: [valid.min(), valid.max()],
        heating_temperature_counts: Some([valid.min(), valid.max()]),
        share_of_asked_range: Some(1.0),
        curve_error_counts: Some(0.31),
        fit_rms_counts: statistics.in_sample.rms,
        fit_pp_counts: statistics.in_sample.pp,
        held_out_rms_counts: statistics.held_out.map(|residual| residual.rms),
        held_out_pp_counts: statistics.held_out.map(|residual| residual.pp),
    }
}

/// What the compensated axis and its control did in a ramp of a recording.
fn result(recording: &Recording, mode: Mode, axis: Axis, direction: Phase) -> TestResult {
    let of = |wanted: Axis, mode| {
        let rows = recording.rows.iter();
        rows.filter(move |row| (row.axis, row.phase, row.mode) == (wanted, direction, mode))
    };
    let left: Vec<f64> = of(axis, mode).map(|row| row.corrected_counts).collect();
    let mean = left.iter().sum::<f64>() / f64::from(GROUPS);
    let squares = left.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    TestResult {
        mode,
        axis,
        control: axis.other(),
        direction,
        residual_pp_counts: pp(left.iter().copied()),
        residual_rms_counts: (squares / f64::from(GROUPS)).sqrt(),
        uncompensated_pp_counts: pp(of(axis, mode).map(|row| row.sums.mean_zro().0)),
        temperature_counts: Some([8500.0, 11_900.0]),
        outside: Some(0.0),
        quadratic_pp_counts: Some(7.3),
        control_pp_counts: pp(of(axis.other(), Mode::Off).map(|row| row.corrected_counts)),
        floor_pp_counts: Some(6.1),
        wiper_writes: 14,
        taps_crossed: Some(14),
        mean_counts: mean,
        largest_step_counts: if mode == Mode::Trim { 30.7 } else { 1.84 },
    }
}

fn soaks(gyro: &Gyro) -> AxisSoaks {
    let point = |i: u32| {
        let temperature_counts = 8500.0 + 340.0 * f64::from(i);
        let ramp_counts = gyro.zro(temperature_counts);
        let zro_counts = ramp_counts + 1.4 * noise(gyro.seed + 500 + u64::from(i));
        SoakPoint {
            chamber_c: -40.0 + 10.0 * f64::from(i),
            temperature_counts,
            zro_counts,
            ramp_counts,
            outside_ramp: false,
        }
    };
    AxisSoaks { max_difference_counts: Some(1.4), points: (0..11).map(point).collect() }
}

fn made() -> BoardRun {
    let full_temperature = recording(ramp(0, Phase::Heating, &X, Mode::Off));
    let source = Source::bytes(FULL_TEMPERATURE, []);
    let fit = fit_recording(&full_temperature, &source, &FitOptions::default());
    let mut axes = BTreeMap::new();
    let mut summaries = BTreeMap::new();
    for (gyro, fit) in [&X, &Y].into_iter().zip(fit.axes) {
        let trim = trim(gyro);
        summaries.insert(fit.name.clone(), axis_summary(gyro, &fit, &trim));
        let mut calibration = fit.calibration;
        calibration.trim = Some(trim);
        axes.insert(fit.name, calibration);
    }
    let test = |mode| {
        let of_x = ramp(0, Phase::Heating, &X, mode).chain(ramp(1, Phase::Cooling, &X, mode));
        recording(of_x.chain(ramp(2, Phase::Heating, &Y, mode)))
    };
    let tests = [Mode::Trim, Mode::Hybrid].map(|mode| (mode, test(mode)));
    let runs = [(Axis::X, Phase::Heating), (Axis::X, Phase::Cooling), (Axis::Y, Phase::Heating)];
    let results =
        runs.iter().flat_map(|(axis, way)| tests.iter().map(|(mode, test)| result(test, *mode, *axis, *way))).collect();
    let check = |what: &str, limit: &str, measured: &str, passed| Check {
        what: what.into(),
        limit: limit.into(),
        measured: measured.into(),
        passed,
    };
    let serial = "ZR-2012-0001".to_owned();
    let sha256 = "9f86d081884c7d659a2feaa0c55ad0159f86d081884c7d659a2feaa0c55ad015".into();
    let recordings = vec![Origin {
        content: "full-temperature".into(),
        file: FULL_TEMPERATURE.into(),
        sha256,
        started: None,
        changed: None,
        rows: Vec::new(),
    }];
    let summary = Summary {
        schema: SCHEMA,
        plant: Some("paper".into()),
        seed: Some(1),
        serial: serial.clone(),
        verdict: Verdict::Warning,
        started: None,
        wall_s: 12.0,
        trim_part: "max5494".into(),
        counts_per_dps: 54.6,
        axes: summaries,
        tests: results,
        checks: vec![
            check("Curve against the plant’s true drift, X", "at most 1 count", "0.31 counts", true),
            check("Trim residual, heating, peak to peak, held out", "at most 40 counts", "35.6 counts", true),
            check("Largest step a control loop feels, hybrid", "at most 4 counts", "1.84 counts", true),
            check("Cooling residual, hybrid, peak to peak", "at most 10 counts", "11.9 counts", false),
        ],
        recordings: recordings.clone(),
        soaks: Some(Soaks {
            ramp_hours: 2.0,
            soak_hours: 15.5,
            hours_saved: 13.5,
            axes: [&X, &Y].map(|gyro| (gyro.axis.name().to_owned(), soaks(gyro))).into(),
        }),
        failed_checks: Vec::new(),
        warnings: vec!["Cooling differs from heating by up to 5 counts: thermal hysteresis.".into()],
    };
    let calibration = Calibration {
        group_period_s: Some(1.5),
        labels: [("operator".to_owned(), "A. N.".to_owned())].into(),
        setup: Some(json!({ "board": { "counts_per_celsius": 34.0, "counts_at_zero_celsius": 9860.0 } })),
        ..Calibration::new(Kind::AnalogueBoard, Some(serial), recordings, TemperatureUnit::Counts, axes)
    };
    BoardRun { calibration, summary, full_temperature, tests: tests.map(|(_, test)| test).into() }
}

/// A run in which one check fails.
pub fn board_run() -> BoardRun {
    static RUN: LazyLock<BoardRun> = LazyLock::new(made);
    RUN.clone()
}
