//! A drift that remembers, on a board: recorded in both directions, chosen by `auto`, run by the device, and held against
//! the same board with a static cubic.

#![allow(clippy::unwrap_used)] // what a test cannot do without

use zerorate_bench::measure::{Measured, first_time, measure};
use zerorate_bench::procedure::compensation_test::Extent;
use zerorate_bench::run::{Recorder, Session, Silent};
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated;
use zerorate_bench::verify::{deploy, test};
use zerorate_core::compensate::Mode;
use zerorate_core::record::UnitSerial;
use zerorate_core::units::Axis;
use zerorate_sim::{Plant, PlantParameters};

/// A typical unit whose dies follow their packages slowly, as in a large package (assumed: 25 s).
fn slow_die(seed: u64) -> Plant {
    let mut parameters = PlantParameters::typical(seed);
    parameters.axes.iter_mut().for_each(|axis| axis.thermal.die_time_constant_s = 25.0);
    Plant::new(parameters, seed)
}

/// X of such a unit compensated by a model: what is known of it, and the residual of the test that no fit has seen,
/// counts peak to peak over the noise's own, heating and cooling.
fn tested(seed: u64, model: &str) -> (Measured, [f64; 2]) {
    let setup =
        SetUp::parse(&format!("[chamber]\ncooling_ramp = true\n[drift]\nmodel = \"{model}\"\n"), "here").unwrap();
    let mut bench = simulated::bench(slow_die(seed), &setup, &UnitSerial::new());
    let mut progress = Silent;
    let mut session = Session::new(&mut bench, &setup, &mut progress);
    first_time(&mut session).unwrap();
    let measured = measure(&mut session, "", Recorder::discarding(), Recorder::discarding()).unwrap();
    deploy(&mut session, &measured).unwrap();
    let extent = Extent { cooling: true, samples: false };
    let verification =
        test(&mut session, &measured, Mode::Hybrid, Axis::X, extent, &mut Recorder::discarding()).unwrap();
    let floors = [0, 1].map(|ramp| {
        let result = &verification.results[ramp];
        result.residual_pp_counts / result.floor_pp_counts.unwrap()
    });
    (measured, floors)
}

#[test]
fn a_history_survives_hysteresis_where_a_static_curve_does_not() {
    let (mut auto, mut cubic, mut remembering) = ([0.0; 2], [0.0; 2], 0);
    for seed in 1..=8 {
        let (measured, floors) = tested(seed, "auto");
        let (_, of_cubic) = tested(seed, "poly:3");
        for ramp in 0..2 {
            auto[ramp] += floors[ramp] / 8.0;
            cubic[ramp] += of_cubic[ramp] / 8.0;
        }
        let record = &measured.record.axes[0];
        remembering += usize::from(record.law.history.is_some());
        assert_eq!(record.law.history.is_some(), measured.axes[0].drift.calibration.fit.model.history.is_some());
    }
    // 1.6 and 1.4 floors against 2.2 and 2.2. While it heats the board has just started.
    assert!(auto[0] < 0.8 * cubic[0] && auto[1] < 0.7 * cubic[1], "{auto:?} {cubic:?}");
    // What moves less than its own error is left out: of some of these units that is all of it.
    assert!(remembering >= 5, "{remembering}");
}
