//! A board that does its work alone: what it does when its power comes, and that a procedure still finds it at rest.

#![allow(clippy::unwrap_used)] // what a test cannot do without

mod paper_record;

use zerorate_bench::instruments::Bench;
use zerorate_bench::plants::PlantKind;
use zerorate_bench::run::{Session, Silent};
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated;
use zerorate_core::compensate::Mode;
use zerorate_core::group::CODES_PER_COUNT;
use zerorate_core::record::UnitSerial;
use zerorate_core::units::{Axis, Taps, TemperatureScale};
use zerorate_core::wire::{Request, ResetCause, SampleWindow};

const VALID: [f64; 2] = [8500.0, 11_900.0];

/// A bench whose board holds a calibration, its power off and on.
fn switched_on() -> Bench {
    let unit = UnitSerial::try_from("ZR-1").unwrap();
    let mut bench = simulated::bench(PlantKind::Paper.build(1), &SetUp::paper(), &unit);
    bench.device.identify().unwrap();
    bench.device.deploy(&paper_record::record(VALID, None, 0.05)).unwrap();
    bench.power.cycle().unwrap();
    bench.device.restarted();
    bench
}

#[test]
fn a_calibrated_board_is_at_work_when_its_power_has_come_and_its_wipers_follow_from_the_first_group() {
    let mut bench = switched_on();
    let identity = bench.device.identify().unwrap();
    assert_eq!((identity.running, identity.reset), (true, ResetCause::Power));
    assert_eq!((identity.modes, identity.taps), ([Mode::Hybrid; 2], [Taps::MIDDLE; 2]));
    bench.device.order(Request::SetStream { groups: true, samples: SampleWindow::NONE }).unwrap();
    let groups = [(); 2].map(|()| bench.device.next_group().unwrap().report);
    let law = paper_record::model(VALID, None, 0.05).static_law(TemperatureScale::QUARTER_COUNTS);
    for axis in Axis::BOTH {
        let asked = law.tap(groups[0].axes[axis.index()].sums.temperature_code(CODES_PER_COUNT).unwrap());
        assert_eq!(groups[0].group.0, 0);
        assert_eq!(groups[0].axes[axis.index()].moved_to, asked);
        assert_eq!(Some(groups[1].axes[axis.index()].tap), asked);
    }
}

#[test]
fn a_procedure_puts_a_board_at_work_to_rest_before_it_begins() {
    let mut bench = switched_on();
    let (setup, mut progress) = (SetUp::paper(), Silent);
    let mut session = Session::new(&mut bench, &setup, &mut progress);
    session.begin().unwrap();
    let identity = session.bench.device.identify().unwrap();
    assert_eq!((identity.running, identity.modes, identity.taps), (false, [Mode::Off; 2], [Taps::MIDDLE; 2]));
    session.start(SampleWindow::NONE).unwrap();
    for expected in 0..3 {
        let group = session.bench.device.next_group().unwrap().report;
        assert_eq!((group.group.0, group.axes[0].tap, group.axes[0].mode), (expected, Taps::MIDDLE, Mode::Off));
    }
    assert!(session.bench.device.take_lost_groups().is_empty());
}

#[test]
fn whoever_waits_for_groups_that_were_not_asked_for_is_told() {
    let mut bench = switched_on();
    bench.device.identify().unwrap();
    assert!(bench.device.next_group().is_err(), "a board that works alone says nothing of it");
}
