//! What the bench leaves: recordings and the calibration of a board.

use std::path::Path;

use serde_json::json;
use zerorate_bench::setup::SetUp;
use zerorate_cal::calibration::Calibration;
use zerorate_cal::recording::{GroupRow, Phase, RecordingInfo, RecordingWriter};

/// Both axes of a group.
pub fn group(number: u32) -> Vec<GroupRow> {
    ["X", "Y"]
        .map(|axis| GroupRow {
            group: number,
            t_s: 1.5 * f64::from(number),
            phase: if number < 20 { Phase::Soak } else { Phase::Heating },
            // The axes' type belongs to a crate that this one does not use, and its serde form is public.
            axis: serde_json::from_value(axis.into()).unwrap(),
            sums: sums(number),
            corrected_counts: 8200.0,
            tap: 511,
            mode: Default::default(),
            chamber_set_c: -40.0,
            chamber_c: f64::from(number).mul_add(0.01, -40.0),
            status_bits: 0,
        })
        .into()
}

/// Of 500 samples.
fn sums<Sums: serde::de::DeserializeOwned>(number: u32) -> Sums {
    let (n, temperature, zro) = (500_u64, 8500 + u64::from(number % 3000), 8200_u64);
    let sums = json!({
        "n": n,
        "temperature": n * temperature,
        "temperature_sq": n * temperature * temperature,
        "zro": n * zro,
        "zro_sq": n * zro * zro,
    });
    serde_json::from_value(sums).unwrap()
}

pub fn recording(path: &Path) -> RecordingWriter {
    let info = RecordingInfo {
        unit_serial: "ZR-0042".into(),
        procedure: "full-temperature".into(),
        set_up: SetUp::paper().to_toml(),
        firmware: "0.1.0".into(),
        seed: Some(7),
        ..RecordingInfo::default()
    };
    RecordingWriter::create(path, &info).unwrap()
}

/// The calibration of a board with the paper's X on both axes, as its file.
pub fn calibration() -> String {
    let trim = json!({
        "line": { "slope_taps_per_count": -0.032, "intercept_taps": 0.0, "centre_counts": 8200.0, "middle_tap": 511 },
        "dead_band_taps": 0.05,
        "low_pass": SetUp::paper().low_pass(),
        "start_up_mode": "hybrid",
    });
    let axis = json!({
        "model": "poly:2",
        "drift": {
            "temperature_centre": 10_200.0,
            "temperature_half_span": 1700.0,
            "valid_temperature": [8500.0, 11_900.0],
            "scaled_coefficients": [8200.0, -200.0, 100.0],
        },
        "rate_unit": "counts",
        "fit": null,
        "trim": trim,
    });
    let calibration = json!({
        "schema": 1,
        "kind": "analogue-board",
        "unit_serial": "ZR-0042",
        "created_by": "zerorate 0.1.0",
        "sources": [],
        "temperature_unit": "counts",
        "temperature_scale": { "zero": 0.0, "step": 0.25 },
        "axes": { "x": axis, "y": axis },
    });
    calibration.to_string()
}

/// The device record of that calibration.
pub fn device_record() -> Vec<u8> {
    record_of(&calibration())
}

pub fn record_of(calibration: &str) -> Vec<u8> {
    let calibration = Calibration::from_json(calibration).unwrap();
    let mut buffer = [0; 8192];
    calibration.to_device_record().unwrap().record.encode(&mut buffer).unwrap().to_vec()
}
