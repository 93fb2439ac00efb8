//! The device record of a unit that drifts as the paper's X, on both axes.

use zerorate_core::compensate::{EdgeTable, LowPass, Mode};
use zerorate_core::drift::{Drift, Polynomial, Scale, Shape, ValidRange};
use zerorate_core::record::{AxisRecord, DeviceRecord, UnitSerial};
use zerorate_core::trim::{TapEffects, Trim, TrimLine};
use zerorate_core::units::{Counts, Taps, TemperatureScale};

/// Eq. (1) and (2) of the paper's X, calibrated over a range of temperature readings, as unit ZR-1.
pub fn record(valid: [f64; 2], measured: Option<TapEffects>, dead_band: f64) -> DeviceRecord {
    let scale = Scale::spanning(8500.0, 11_900.0).unwrap();
    let curve = Polynomial::from_raw_coefficients(scale, &[13_435.7, -0.894_782, 0.375_298e-4]).unwrap();
    let mut axis = AxisRecord {
        drift: Drift { shape: Shape::Polynomial(curve), valid: ValidRange::new(valid[0], valid[1]).unwrap() },
        trim: Trim { line: TrimLine::new(-0.032, 0.0, Counts(8200.0), Taps::MIDDLE).unwrap(), measured },
        dead_band,
        low_pass: LowPass::NONE,
        start_up_mode: Mode::Hybrid,
        edges: None,
        history: None,
    };
    axis.edges = Some(EdgeTable::solve(&axis.static_law(TemperatureScale::QUARTER_COUNTS)).unwrap());
    DeviceRecord {
        unit: UnitSerial::try_from("ZR-1").unwrap(),
        temperature_scale: TemperatureScale::QUARTER_COUNTS,
        axes: [axis.clone(), axis],
    }
}
