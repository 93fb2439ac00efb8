//! The fit of an invented log: a chamber cycle, warm to cold and back, one stretch of it disturbed.

use std::f64::consts::PI;

use zerorate_cal::characterise::{Characteristics, Hysteresis, TemperatureSensitivity};
use zerorate_cal::quality::{Reason, ReasonKind, Verdict};
use zerorate_fit::allan::Allan;
use zerorate_fit::residual::ResidualStatistics;
use zerorate_report::{CandidateRow, LeftOut, LogAxis, LogPoint, LogReport, Parameters, RejectedSamples};

use super::noise;

fn axis(name: &str, seed: u64, size: f64) -> LogAxis {
    let point = |i: u32| {
        let elapsed_s = f64::from(i) * 8.0;
        let phase = f64::from(i) / 2000.0;
        let temperature = 12.0 + 45.0 * (2.0 * PI * phase).cos() + 0.1 * noise(seed + u64::from(i));
        let u = (temperature - 12.0) / 45.0;
        let curve = size * (0.4 - 1.1 * u + 0.5 * u * u * u);
        let hysteresis = 0.12 * size * (1.0 - u * u) * if phase > 0.5 { 1.0 } else { -1.0 };
        let corrected = hysteresis + 0.03 * size * noise(seed + 5000 + u64::from(i));
        LogPoint { elapsed_s, temperature, rate: curve + corrected, corrected }
    };
    let left_out = |point: &LogPoint| (5200.0..6100.0).contains(&point.elapsed_s);
    let candidate = |order: usize, rms: f64| CandidateRow {
        model: format!("poly:{order}"),
        in_sample_rms: rms * size,
        held_out_rms: 1.4 * rms * size,
        standard_error: 0.1 * rms * size,
        chosen: order == 3,
    };
    LogAxis {
        rate_unit: "rad/s".into(),
        name: name.into(),
        model: "poly:3".into(),
        raw_coefficients: vec![6.96e-4 * size / 1e-3, -2.6e-5, -1.98e-7, 5.49e-9],
        is_polynomial: true,
        temperature: [-33.1, 57.2],
        in_sample: ResidualStatistics { rms: 0.09 * size, pp: 0.41 * size },
        held_out: ResidualStatistics { rms: 0.13 * size, pp: 0.55 * size },
        samples_used: 398_120,
        samples_rejected: vec![
            RejectedSamples { reason: "no number for the rate".into(), count: 1280 },
            RejectedSamples { reason: "the unit was moved".into(), count: 22_500 },
        ],
        candidates: vec![candidate(1, 0.31), candidate(2, 0.22), candidate(3, 0.09), candidate(4, 0.089)],
        points: (0..2000).map(point).filter(|point| !left_out(point)).collect(),
        characteristics: Some(characteristics(seed, size)),
        band: (0..=50).map(|i| (-33.1 + 1.806 * f64::from(i), 0.16 * size)).collect(),
    }
}

fn characteristics(seed: u64, size: f64) -> Characteristics {
    // A walk below white noise: an Allan curve with both its slopes.
    let mut bias = 0.0;
    let rates: Vec<f64> = (0..1800)
        .map(|i| {
            bias += 0.002 * size * noise(seed + 40_000 + i);
            bias + 0.03 * size * noise(seed + 80_000 + i)
        })
        .collect();
    Characteristics {
        temperature_sensitivity: TemperatureSensitivity {
            mean: -0.01 * size,
            steepest: -0.024 * size,
            steepest_at: 12.3,
        },
        hysteresis: Ok(Hysteresis { largest: -0.24 * size, at: 14.0, rms: 0.15 * size, share: 0.17 }),
        ramp_sensitivity: Err("the temperature always changed at one speed".into()),
        residual_noise: Allan::of(&rates, 8.0).map_err(|error| error.to_string()),
    }
}

/// A log that is good for something, with warnings.
pub fn log() -> LogReport {
    LogReport {
        source: "imu_raw_data.tsv".into(),
        verdict: Verdict::Warning,
        reasons: vec![Reason::new(
            ReasonKind::Rotation,
            "the unit was moved from 5200 s to 6100 s (rows 130001 to 152500, 10.2 to 22.9 C): these rows were left out",
        )],
        notes: vec!["Column 'time' was taken for the time, in s: its name says so.".into()],
        temperature_unit: "°C".into(),
        axes: vec![
            axis("imu.gyro.x", 1, 4.1e-3),
            axis("imu.gyro.y", 900_000, 1.9e-3),
            axis("imu.gyro.z", 800_000, 2.6e-3),
        ],
        left_out: vec![LeftOut {
            reason: "the unit was moved".into(),
            start_s: 5200.0,
            end_s: 6100.0,
            temperature: [10.2, 22.9],
            rows: 22_500,
        }],
        parameters: vec![
            Parameters {
                program: "PX4 (QGroundControl)".into(),
                command: "zerorate export calibration.json --format px4 --out calibration.params".into(),
                text: Err("gyro 0 has no device id: give --device-id".into()),
            },
            Parameters {
                program: "ArduPilot (Mission Planner, MAVProxy)".into(),
                command: "zerorate export calibration.json --format ardupilot --out calibration.parm".into(),
                text: Ok((0..40).map(|i| format!("INS_TCAL1_GYR1_{i} {}.123456789\n", 7 * i)).collect()),
            },
        ],
        advice: vec!["Leave the unit untouched while it logs: turn off motors, close the box, walk away.".into()],
        next_command: Some("zerorate apply calibration.json flight.csv --out corrected.csv".into()),
    }
}
