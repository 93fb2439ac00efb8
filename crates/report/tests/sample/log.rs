//! The fit of an invented log: a chamber cycle, warm to cold and back, in which the unit was moved for a while.

use std::f64::consts::PI;
use std::fmt::Write;
use std::sync::LazyLock;

use zerorate_cal::fit::fit;
use zerorate_cal::log_fit::{FitOptions, LogFit};
use zerorate_cal::source::Source;

use super::noise;

/// Rows of the log, two seconds apart.
const ROWS: u32 = 8000;

/// A rate of this size, rad/s: a cubic with some hysteresis, noise, and the rotation while the unit was moved.
fn rate(row: u32, seed: u64, size: f64) -> f64 {
    let phase = f64::from(row) / f64::from(ROWS);
    let u = (2.0 * PI * phase).cos();
    let curve = 0.4 - 1.1 * u + 0.5 * u * u * u;
    let hysteresis = 0.12 * (1.0 - u * u) * if phase > 0.5 { 1.0 } else { -1.0 };
    let moved = if (2600..3050).contains(&row) { 80.0 * (f64::from(row) / 5.0).sin() } else { 0.0 };
    size * (curve + hysteresis + moved + 0.05 * noise(seed + u64::from(row)))
}

fn text() -> String {
    let mut text = String::from("time_s,temperature_c,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s\n");
    for row in 0..ROWS {
        let temperature = 12.0 + 45.0 * (2.0 * PI * f64::from(row) / f64::from(ROWS)).cos();
        let temperature = temperature + 0.05 * noise(u64::from(row));
        let [x, y, z] =
            [(100_000, 4.1e-3), (200_000, 1.9e-3), (300_000, 2.6e-3)].map(|(seed, size)| rate(row, seed, size));
        // A rate is lost now and then.
        let x = if row % 300 == 7 { f64::NAN } else { x };
        let _ = writeln!(text, "{},{temperature},{x},{y},{z}", 2 * row);
    }
    text
}

/// A log that is good for something, with warnings.
pub fn log() -> LogFit {
    static FIT: LazyLock<LogFit> = LazyLock::new(|| {
        let log = Source::bytes("logs/chamber-cycle.csv", text().into_bytes());
        fit(&[log], &FitOptions::default()).expect("a log of numbers")
    });
    FIT.clone()
}
