//! The models and the device record of a unit that drifts as the paper's X, on both axes.

#![allow(dead_code)] // a test takes what it needs

use zerorate_core::board::BoardNumbers;
use zerorate_core::compensate::{EdgeTable, LowPass, Mode};
use zerorate_core::drift::{Drift, Polynomial, Scale, Shape, ValidRange};
use zerorate_core::record::{AxisModel, DeviceRecord, UnitSerial};
use zerorate_core::trim::{TapEffects, Trim, TrimLine};
use zerorate_core::units::{Counts, Taps, TemperatureScale};

const SCALE: TemperatureScale = TemperatureScale::QUARTER_COUNTS;

/// Eq. (1) and (2) of the paper's X, calibrated over a range of temperature readings.
pub fn model(valid: [f64; 2], measured: Option<TapEffects>, dead_band: f64) -> AxisModel {
    let scale = Scale::spanning(8500.0, 11_900.0).unwrap();
    let curve = Polynomial::from_raw_coefficients(scale, &[13_435.7, -0.894_782, 0.375_298e-4]).unwrap();
    let mut axis = AxisModel {
        drift: Drift { shape: Shape::Polynomial(curve), valid: ValidRange::new(valid[0], valid[1]).unwrap() },
        trim: Trim { line: TrimLine::new(-0.032, 0.0, Counts(8200.0), Taps::MIDDLE).unwrap(), measured },
        dead_band,
        low_pass: LowPass::first_order(40.0, 0.003, 0.0001),
        start_up_mode: Mode::Hybrid,
        edges: None,
        history: None,
    };
    axis.edges = Some(EdgeTable::solve(&axis.static_law(SCALE)).unwrap());
    axis
}

/// The unit that the record is of.
pub const UNIT: &str = "ZR-1";

/// The same on both axes.
pub fn record(valid: [f64; 2], measured: Option<TapEffects>, dead_band: f64) -> DeviceRecord {
    let axis = model(valid, measured, dead_band);
    DeviceRecord::new(UnitSerial::try_from(UNIT).unwrap(), SCALE, BoardNumbers::PAPER, &[axis.clone(), axis]).unwrap()
}
