//! A calibration of the paper's gyro by its own equations, with noise, a saw-tooth and a little hysteresis.

use zerorate_cal::quality::Verdict;
use zerorate_fit::drift_fit::Candidate;
use zerorate_report::{
    AxisSoaks, CalibratedAxis, CalibrationReport, Check, CompensationTest, Direction, DriftFacts, Mode, RampPoint,
    SoakComparison, SoakPoint, TapDeviation, TestPoint, TrimFacts, TrimLine, TrimPoint, UnitFacts,
};

use super::noise;

const GROUPS: u32 = 2400;
const CENTRE: f64 = 8200.0;

struct Gyro {
    name: &'static str,
    drift: [f64; 3],
    slope: f64,
    seed: u64,
}

const X: Gyro = Gyro { name: "X", drift: [13_435.7, -0.894_782, 0.375_298e-4], slope: -0.031_990_6, seed: 1_000_000 };
const Y: Gyro = Gyro { name: "Y", drift: [12_516.1, -0.676_531, 0.276_524e-4], slope: -0.031_609_3, seed: 2_000_000 };

impl Gyro {
    fn zro(&self, temperature: f64) -> f64 {
        let [c0, c1, c2] = self.drift;
        c0 + temperature * (c1 + temperature * c2)
    }

    fn noise(&self, run: u64, group: u32) -> f64 {
        noise(self.seed + run * 10_000 + u64::from(group))
    }
}

/// The die's temperature in counts: the chamber's ramp, followed with a lag.
fn temperature(group: u32, direction: Direction) -> f64 {
    let hours = f64::from(group) / f64::from(GROUPS);
    let share = 1.02 * (1.0 - (-3.2 * hours * hours.sqrt()).exp()).min(1.0);
    match direction {
        Direction::Heating => 8500.0 + 3400.0 * share,
        Direction::Cooling => 11_900.0 - 3400.0 * share,
    }
}

fn pp(values: impl Iterator<Item = f64>) -> f64 {
    let (min, max) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    max - min
}

fn axis(gyro: &Gyro) -> CalibratedAxis {
    let point = |group: u32| {
        let temperature_counts = temperature(group, Direction::Heating);
        let fitted_counts = gyro.zro(temperature_counts);
        let zro_counts = fitted_counts + 0.9 * gyro.noise(0, group);
        RampPoint { elapsed_s: f64::from(group) * 1.5, temperature_counts, zro_counts, fitted_counts }
    };
    let ramp: Vec<RampPoint> = (0..GROUPS).map(point).collect();
    let candidate = |order: usize, rms: f64| Candidate {
        model: format!("poly:{order}"),
        in_sample_rms: rms,
        held_out_rms: Some(rms * 1.02),
        held_out_excess_standard_error: Some(rms * 0.03),
        deployed_rms: None,
        ends_rms: None,
        by_direction_rms: None,
        shrinkage_weight: None,
        chosen: order == 2,
    };
    let drift = DriftFacts {
        model: "poly:2".into(),
        remembers: false,
        raw_coefficients: gyro.drift.to_vec(),
        temperature_counts: [8500.0, 11_829.0],
        drift_pp_counts: pp(ramp.iter().map(|point| point.zro_counts)),
        fit_rms_counts: 0.903,
        held_out_rms_counts: 0.921,
        curve_error_counts: Some(0.31),
        candidates: vec![candidate(1, 24.1), candidate(2, 0.903), candidate(3, 0.902), candidate(4, 0.902)],
    };
    let line = |shift: f64| TrimLine {
        slope_taps_per_count: gyro.slope * (1.0 + shift),
        intercept_taps: -0.27 * shift * 200.0,
        centre_counts: CENTRE + 900.0 * shift,
    };
    let points = (0..21_u32).map(|i| {
        let delta_counts = (f64::from(i) - 10.0) * 100.0 + 300.0 + 3.0 * noise(gyro.seed + u64::from(i));
        let taps = gyro.slope * delta_counts + 0.04 * noise(gyro.seed + 77 + u64::from(i));
        TrimPoint { delta_counts, delta_taps: taps }
    });
    let taps = (490..532).map(|tap| TapDeviation { tap, deviation_counts: 1.6 * noise(gyro.seed + u64::from(tap)) });
    let trim = TrimFacts {
        points: points.collect(),
        paper: line(0.0021),
        better: line(0.0002),
        plant_slope_taps_per_count: Some(gyro.slope),
        taps: taps.collect(),
    };
    CalibratedAxis { name: gyro.name.into(), ramp, drift, trim }
}

fn test(gyro: &Gyro, control: &Gyro, mode: Mode, direction: Direction, run: u64) -> CompensationTest {
    let point = |group: u32| {
        let temperature_counts = temperature(group, direction);
        // Hysteresis: cooling runs a few counts below heating, most in the middle.
        let share = (temperature_counts - 8500.0) / 3400.0;
        let hysteresis = if direction == Direction::Cooling { -9.0 * share * (1.0 - share) * 2.0 } else { 0.0 };
        let drift = gyro.zro(temperature_counts);
        let taps = (gyro.slope * (drift - CENTRE)).round();
        let left = if mode == Mode::Trim { drift - CENTRE - taps / gyro.slope } else { 0.0 };
        TestPoint {
            elapsed_s: f64::from(group) * 1.5,
            temperature_counts,
            compensated_counts: CENTRE + left + hysteresis + 0.9 * gyro.noise(run, group),
            control_counts: control.zro(temperature_counts) + hysteresis + 0.9 * control.noise(run, group),
        }
    };
    let points: Vec<TestPoint> = (0..GROUPS).map(point).collect();
    let mean = points.iter().map(|point| point.compensated_counts).sum::<f64>() / f64::from(GROUPS);
    let squares = points.iter().map(|point| (point.compensated_counts - mean).powi(2)).sum::<f64>();
    CompensationTest {
        mode,
        axis: gyro.name.into(),
        control: control.name.into(),
        direction,
        residual_pp_counts: pp(points.iter().map(|point| point.compensated_counts)),
        residual_rms_counts: (squares / f64::from(GROUPS)).sqrt(),
        control_pp_counts: pp(points.iter().map(|point| point.control_counts)),
        uncompensated_pp_counts: pp((0..GROUPS).map(|group| gyro.zro(temperature(group, Direction::Heating)))),
        floor_pp_counts: pp((0..GROUPS).map(|group| 0.9 * gyro.noise(run, group))),
        wiper_writes: 14,
        taps_crossed: 14,
        mean_counts: mean,
        largest_step_counts: if mode == Mode::Trim { 30.7 } else { 1.84 },
        points,
    }
}

fn soaks(gyro: &Gyro) -> AxisSoaks {
    let point = |i: u32| {
        let temperature_counts = 8500.0 + 340.0 * f64::from(i);
        let ramp_counts = gyro.zro(temperature_counts);
        let zro_counts = ramp_counts + 1.4 * noise(gyro.seed + 500 + u64::from(i));
        SoakPoint { chamber_c: -40.0 + 10.0 * f64::from(i), temperature_counts, zro_counts, ramp_counts }
    };
    AxisSoaks { name: gyro.name.into(), points: (0..11).map(point).collect(), largest_difference_counts: 2.7 }
}

/// A calibration in which one check fails.
pub fn calibration() -> CalibrationReport {
    let mut tests = Vec::new();
    let mut run = 1;
    for (gyro, control, direction) in
        [(&X, &Y, Direction::Heating), (&X, &Y, Direction::Cooling), (&Y, &X, Direction::Heating)]
    {
        for mode in [Mode::Trim, Mode::Hybrid] {
            tests.push(test(gyro, control, mode, direction, run));
            run += 1;
        }
    }
    let check = |what: &str, limit: &str, measured: &str, pass| Check {
        what: what.into(),
        limit: limit.into(),
        measured: measured.into(),
        pass,
    };
    CalibrationReport {
        unit: UnitFacts {
            serial: "ZR-2012-0001".into(),
            device: "native device, MAX5494, spoken to through wire bytes".into(),
            plant: Some("paper".into()),
            seed: Some(1),
            centre_counts: CENTRE,
            middle_tap: 511,
            group_samples: 500,
            groups_per_minute: 40.0,
            scale_counts_per_dps: Some(54.6),
            further: vec![
                ("Set-up".into(), "default (the paper’s)".into()),
                ("Dead band".into(), "0.15 tap".into()),
                ("Recording".into(), "full-temperature.parquet, SHA-256 9f86d081884c7d659a2feaa0c55ad015".into()),
            ],
        },
        verdict: Verdict::Warning,
        axes: vec![axis(&X), axis(&Y)],
        tests,
        soaks: Some(SoakComparison { ramp_hours: 2.0, soak_hours: 15.5, axes: vec![soaks(&X), soaks(&Y)] }),
        checks: vec![
            check("Curve against the plant’s true drift, X", "at most 1 count", "0.31 counts", true),
            check("Trim residual, heating, peak to peak, held out", "at most 40 counts", "35.6 counts", true),
            check("Largest step a control loop feels, hybrid", "at most 4 counts", "1.84 counts", true),
            check("Cooling residual, hybrid, peak to peak", "at most 10 counts", "11.9 counts", false),
        ],
        warnings: vec!["Cooling differs from heating by up to 5 counts: thermal hysteresis.".into()],
    }
}
