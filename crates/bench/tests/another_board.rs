//! A board of another scale than the paper's, calibrated and compensated end to end: 16 bits, 100 counts a kelvin.

#![allow(clippy::unwrap_used)] // what a test cannot do without

use zerorate_bench::measure::{first_time, measure};
use zerorate_bench::procedure::compensation_test::Extent;
use zerorate_bench::run::{Recorder, Session, Silent};
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated;
use zerorate_bench::verify::{deploy, test};
use zerorate_core::board::BoardNumbers;
use zerorate_core::compensate::Mode;
use zerorate_core::record::UnitSerial;
use zerorate_core::units::Axis;
use zerorate_sim::{Plant, PlantParameters};

/// The paper's circuit on a converter of 16 bits: 62.5 uV a count where it is 250, and 6.25 mV a kelvin of the sensor.
const SET_UP: &str = "
[board]
converter_bits = 16
centre_counts = 32800.0
counts_per_dps = -153.6
counts_per_celsius = 100.0
counts_at_zero_celsius = 40340.0
temperature_noise_counts = 12.0
input_volts_per_count = 39.087e-6
[trim]
span_counts = 4000.0
[limits]
trim_residual_pp_counts = 160.0
mean_offset_counts = 64.0
soak_difference_counts = 80.0
";

fn plant() -> Plant {
    let mut parameters = PlantParameters::paper();
    parameters.converter.bits = 16;
    parameters.axes.iter_mut().for_each(|axis| axis.sensor.slope_v_per_k = 6.25e-3);
    Plant::new(parameters, 1)
}

#[test]
fn a_board_of_16_bits_is_calibrated_and_compensated_by_its_own_numbers() {
    let setup = SetUp::parse(SET_UP, "here").unwrap();
    let mut bench = simulated::bench(plant(), &setup, &UnitSerial::new());
    let mut progress = Silent;
    let mut session = Session::new(&mut bench, &setup, &mut progress);
    first_time(&mut session).unwrap();
    let measured = measure(&mut session, "", Recorder::discarding(), Recorder::discarding()).unwrap();
    assert_eq!(measured.record.board, BoardNumbers::new(16, 100.0, 12.0).unwrap());
    assert_eq!(measured.record.temperature_scale.step.to_bits(), 1.0_f64.to_bits(), "a code is a count");
    // Eq. (1) over 100 K: 440 counts of 14 bits, less what the die lags behind.
    let drift = measured.axes[0].drift_pp_counts / 4.0;
    assert!((380.0..480.0).contains(&drift), "{drift} counts of 14 bits");
    deploy(&mut session, &measured).unwrap();
    let extent = Extent { cooling: false, samples: false };
    let verification =
        test(&mut session, &measured, Mode::Hybrid, Axis::X, extent, &mut Recorder::discarding()).unwrap();
    let result = &verification.results[0];
    let floors = result.residual_pp_counts / result.floor_pp_counts.unwrap();
    assert!(floors < 2.0, "{floors} floors, {} counts peak to peak", result.residual_pp_counts);
    assert!((result.mean_counts - 32_800.0).abs() < 16.0, "above what 15 bits hold: {}", result.mean_counts);
    let faults = session.bench.device.faults().unwrap();
    let judged = [faults.temperature_stuck, faults.temperature_jumped, faults.temperature_saturated, faults.saturated];
    assert_eq!(judged, [0; 4], "nothing of it is out of order");
}
