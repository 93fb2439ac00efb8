//! What a board's test of itself finds, fault by fault, on a bench on which anything can be broken.

#![allow(clippy::unwrap_used)] // what a test cannot do without

use zerorate_bench::board::{Board, SelfTest, Verdict};
use zerorate_bench::client::DeviceClient;
use zerorate_bench::plants::PlantKind;
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated;
use zerorate_core::record::UnitSerial;
use zerorate_core::units::{Axis, Taps};
use zerorate_sim::Fault;

fn tested(faults: &[Fault], setup: &SetUp) -> SelfTest {
    let unit = UnitSerial::try_from("ZR-1").unwrap();
    let (link, plant) = simulated::bare_device(PlantKind::Paper.build(1), &SetUp::paper(), &unit);
    let mut board = Board::on(DeviceClient::new(link)).unwrap();
    board.store_power_up_tap(Taps::MIDDLE, &SetUp::paper()).unwrap();
    faults.iter().for_each(|&fault| plant.borrow_mut().inject(fault));
    board.self_test(setup).unwrap()
}

/// The checks that have failed; each says what to do.
fn failed(found: &SelfTest) -> Vec<&str> {
    let failed: Vec<_> = found.checks.iter().filter(|check| check.verdict == Verdict::Failed).collect();
    assert_eq!(found.passed, failed.is_empty());
    assert!(failed.iter().all(|check| check.remark.as_ref().is_some_and(|remark| remark.len() > 20)), "{failed:?}");
    failed.into_iter().map(|check| check.check.as_str()).collect()
}

#[track_caller]
fn finds(faults: &[Fault], what: &[&str]) -> SelfTest {
    let found = tested(faults, &SetUp::paper());
    let failed = failed(&found);
    for &what in what {
        assert!(failed.iter().any(|check| check.contains(what)), "{what} is not among {failed:?}");
    }
    found
}

#[test]
fn a_sound_board_passes_and_its_taps_are_of_31_counts() {
    let found = tested(&[], &SetUp::paper());
    assert_eq!(failed(&found), [""; 0]);
    let taps: Vec<f64> =
        found.checks.iter().filter(|check| check.check.ends_with("a tap")).map(|check| check.value.unwrap()).collect();
    // Equations (3) and (5): 31.26 counts of X and 31.64 of Y, by a part whose steps are uneven.
    assert_eq!(taps.len(), 4);
    assert!(taps.iter().all(|tap| (30.0..33.0).contains(tap)), "{taps:?}");
    let not_run: Vec<_> = found.checks.iter().filter(|check| check.verdict == Verdict::NotRun).collect();
    assert_eq!(not_run.len(), 2, "a native device has no stack of its own and counts no cycles: {not_run:?}");
}

#[test]
fn a_port_that_does_not_answer_is_found_and_nothing_is_said_of_what_hangs_on_it() {
    let found = finds(&[Fault::DeadSpi], &["acquisition port"]);
    let wipers = found.checks.iter().find(|check| check.check == "wipers").unwrap();
    assert_eq!(wipers.verdict, Verdict::NotRun);
}

#[test]
fn a_port_that_takes_no_scans_is_found() {
    finds(&[Fault::NoScans], &["sets of samples"]);
}

#[test]
fn a_potentiometer_that_does_not_hear_is_found() {
    finds(&[Fault::PotentiometerSpi { transfers: 10_000 }], &["wipers", "trim errors"]);
}

#[test]
fn a_potentiometer_that_keeps_no_tap_is_found_by_the_recall() {
    // Tap 511 was stored; a board with another middle shows that this one is not kept.
    let setup = SetUp::parse("[board]\nmiddle_tap = 520\n", "here").unwrap();
    let found = tested(&[], &setup);
    assert_eq!(failed(&found).len(), 2, "{found:?}");
    let off = found.checks.iter().find(|check| check.check.contains("recalled")).unwrap();
    assert!((off.value.unwrap() + 9.0).abs() < 0.5 && off.remark.as_ref().unwrap().contains("first-time"), "{off:?}");
}

#[test]
fn an_input_at_the_converters_end_is_found_and_its_wiper_moves_nothing() {
    finds(&[Fault::SaturatedInput(Axis::X)], &["reading X", "wiper X, plus"]);
}

#[test]
fn a_temperature_that_stands_still_or_is_torn_off_is_found() {
    finds(&[Fault::StuckTemperature(Axis::X)], &["temperature X"]);
    finds(&[Fault::FrozenTemperature(Axis::Y)], &["temperature Y"]);
    finds(&[Fault::TemperatureAt { axis: Axis::Y, counts: 0 }], &["temperature Y"]);
}

#[test]
fn a_tap_that_is_not_what_the_set_up_says_is_found() {
    let setup = SetUp::parse("[board]\ninput_volts_per_count = 120e-6\n", "here").unwrap();
    let found = tested(&[], &setup);
    assert_eq!(failed(&found).iter().filter(|check| check.contains("a tap")).count(), 4, "{found:?}");
}
