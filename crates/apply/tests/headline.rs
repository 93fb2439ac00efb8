//! The number that a fit tells first, against arithmetic of its own: what a device has left of a log that takes its zero
//! in the first half minute, corrects from then on, and knows no drift in time. And a verification finds it again.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

use std::f64::consts::TAU;
use std::fmt::Write;

use zerorate_apply::verify::{VerifyOptions, verify};
use zerorate_cal::fit::fit;
use zerorate_cal::log_fit::{FitOptions, LogFit};
use zerorate_cal::source::Source;
use zerorate_fit::model::Model;

/// Rows of a log of two a second: 400 groups of 21.
const ROWS: u32 = 8400;
const ROWS_A_GROUP: usize = 21;

/// Time, temperature, rate: a parabola, a drift in time of 2 mrad/s an hour, and noise.
fn rows() -> Vec<[f64; 3]> {
    let mut state = 7_u64;
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let row = |row| {
        let time = 0.5 * f64::from(row);
        let t = 25.0 + 40.0 * (TAU * 1.3 * f64::from(row) / f64::from(ROWS) + 2.0).cos();
        [time, t, parabola(t) + 2e-3 / 3600.0 * time + 5e-4 * noise()]
    };
    (0..ROWS).map(row).collect()
}

fn parabola(t: f64) -> f64 {
    0.02 + 2e-4 * t - 3e-6 * t * t
}

fn log() -> Source {
    let mut text = String::from("time_s,temperature_c,gyro_x_rad_s\n");
    rows().iter().for_each(|[time, t, rate]| writeln!(text, "{time},{t},{rate}").unwrap());
    Source::bytes("log.csv", text.into_bytes())
}

/// The groups' means.
fn groups() -> Vec<[f64; 3]> {
    let mean =
        |rows: &[[f64; 3]]| [0, 1, 2].map(|column| rows.iter().map(|row| row[column]).sum::<f64>() / rows.len() as f64);
    rows().chunks(ROWS_A_GROUP).map(mean).collect()
}

/// The rms after the mean of the first half minute, which is 3 groups of 10.5 s, was taken off.
fn zeroed(left: &[f64]) -> f64 {
    let zero = (left[0] + left[1] + left[2]) / 3.0;
    (left[3..].iter().map(|left| (left - zero).powi(2)).sum::<f64>() / (left.len() - 3) as f64).sqrt()
}

fn fitted(model: Model) -> LogFit {
    fit(&[log()], &FitOptions { model, ..FitOptions::default() }).unwrap()
}

/// The coefficients of a parabola by the normal equations and Gauss's elimination, temperatures in units of 40 from 25.
fn least_squares(points: &[[f64; 3]]) -> [f64; 3] {
    let mut rows = [[0.0; 4]; 3];
    for [_, t, rate] in points {
        let x = (t - 25.0) / 40.0;
        let powers = [1.0, x, x * x];
        for (row, own) in rows.iter_mut().zip(powers) {
            row.iter_mut().zip([1.0, x, x * x, *rate]).for_each(|(sum, other)| *sum += own * other);
        }
    }
    for pivot in 0..3 {
        for below in pivot + 1..3 {
            let factor = rows[below][pivot] / rows[pivot][pivot];
            (0..4).for_each(|column| rows[below][column] -= factor * rows[pivot][column]);
        }
    }
    let c = rows[2][3] / rows[2][2];
    let b = (rows[1][3] - rows[1][2] * c) / rows[1][1];
    [(rows[0][3] - rows[0][1] * b - rows[0][2] * c) / rows[0][0], b, c]
}

#[test]
fn with_the_drift_in_time_known_to_the_fit_it_is_still_in_what_a_device_has_left() {
    let fit = fitted(Model::Auto);
    let statistics = &fit.axes[0].calibration.fit.statistics;
    assert!(fit.axes[0].calibration.fit.model.time_drift.is_some(), "{}", fit.axes[0].calibration.fit.chosen_model());
    // The truth: the parabola is known, the drift in time is not.
    let left: Vec<f64> = groups().iter().map(|[_, t, rate]| rate - parabola(*t)).collect();
    let (deployed, truth) = (statistics.deployed.unwrap().rms, zeroed(&left));
    assert!((deployed / truth - 1.0).abs() < 0.05, "{deployed} {truth}");
    let uncorrected = zeroed(&groups().iter().map(|group| group[2]).collect::<Vec<_>>());
    assert!((statistics.uncorrected.unwrap().rms / uncorrected - 1.0).abs() < 0.01);
    assert!(statistics.held_out.unwrap().rms < 0.2 * deployed, "the figure within the recording has taken it off");
}

#[test]
fn it_is_held_out_eighth_by_eighth() {
    let groups = groups();
    let left: Vec<f64> = (0..8)
        .flat_map(|fold| {
            let out = fold * groups.len() / 8..(fold + 1) * groups.len() / 8;
            let others = [&groups[..out.start], &groups[out.end..]].concat();
            let [a, b, c] = least_squares(&others);
            let left = move |[_, t, rate]: &[f64; 3]| {
                let x = (t - 25.0) / 40.0;
                rate - (a + b * x + c * x * x)
            };
            groups[out].iter().map(left).collect::<Vec<f64>>()
        })
        .collect();
    let fit = fitted(Model::Poly(2));
    let (deployed, own) = (fit.axes[0].calibration.fit.statistics.deployed.unwrap().rms, zeroed(&left));
    // The fit weighs each degree alike; the arithmetic here each group.
    assert!((deployed / own - 1.0).abs() < 0.05, "{deployed} {own}");
}

#[test]
fn a_verification_finds_the_same_number() {
    let fit = fitted(Model::Auto);
    let calibration = fit.to_calibration(Vec::new(), None).unwrap();
    let verified = verify(&log(), &calibration, &VerifyOptions::default()).unwrap();
    let statistics = &fit.axes[0].calibration.fit.statistics;
    for (found, told) in
        [(verified.axes[0].deployed, statistics.deployed), (verified.axes[0].uncorrected, statistics.uncorrected)]
    {
        assert!((found.rms / told.unwrap().rms - 1.0).abs() < 0.03, "{found:?} {told:?}");
    }
    assert_eq!(verified.axes[0].fit_told, statistics.deployed);
}
