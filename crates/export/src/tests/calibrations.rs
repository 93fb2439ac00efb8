//! Calibrations to export.

use zerorate_core::drift::{Drift, Polynomial, Scale, Shape, Table, ValidRange};

use zerorate_fit::drift_fit::{DriftFit, FitStatistics};
use zerorate_fit::predict::DriftModel;

use zerorate_cal::calibration::{AxisCalibration, Calibration, Kind, Origin};
use zerorate_cal::units::{RateUnit, TemperatureUnit};

/// A drift by scaled coefficients or knots.
pub fn drift(values: &[f64], is_table: bool, min: f64, max: f64) -> Drift {
    let scale = Scale::spanning(min, max).unwrap();
    let shape = if is_table {
        Shape::Table(Table::new(scale, values).unwrap())
    } else {
        Shape::Polynomial(Polynomial::new(scale, values).unwrap())
    };
    Drift { shape, valid: ValidRange::new(min, max).unwrap() }
}

/// The cubic of an axis where it has none of its own, and nothing else known of the fit.
pub fn axis(drift: Drift, rate_unit: RateUnit) -> AxisCalibration {
    let statistics = FitStatistics::unknown();
    let measured = drift.valid;
    let model = DriftModel::of_curve(drift);
    AxisCalibration::of_fit(
        DriftFit { model, measured, static_cubic: None, band: Vec::new(), next_run_band: Vec::new(), statistics },
        rate_unit,
    )
}

pub fn calibration(axes: Vec<(&str, AxisCalibration)>) -> Calibration {
    let origin = Origin {
        content: "log".to_owned(),
        file: "log.ulg".to_owned(),
        sha256: "ab".repeat(32),
        started: None,
        changed: None,
        rows: Vec::new(),
    };
    let serial = Some("ZR */ 7\nsecond line".to_owned());
    let axes = axes.into_iter().map(|(name, axis)| (name.to_owned(), axis)).collect();
    Calibration::new(Kind::Log, serial, vec![origin], TemperatureUnit::C, axes)
}

/// Sizes of the real recording: 20, 53 and 11 mrad/s peak to peak; X of order 5, Y a cubic, Z a table.
pub fn three_axes() -> Calibration {
    let x = [3.1e-3, -8.2e-3, 4.4e-3, 1.7e-3, -2.3e-3, 0.9e-3];
    let y = [-0.012_345, 0.026, -0.003, 0.001_7];
    let z: Vec<f64> = (0..=16).map(|i| 0.005 * (f64::from(i) * 0.4).sin() - 0.001).collect();
    calibration(vec![
        ("gyro0.x", axis(drift(&x, false, -17.613, 74.021), RateUnit::RadPerS)),
        ("gyro0.y", axis(drift(&y, false, -17.613, 74.021), RateUnit::RadPerS)),
        ("gyro0.z", axis(drift(&z, true, -17.613, 74.021), RateUnit::RadPerS)),
    ])
}
