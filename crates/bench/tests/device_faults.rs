//! The faults of the device's table, put there through the simulated bench and seen from the host: what is done, what is
//! counted, what is said. No fault moves the wiper by more than the model asks. Those of the acquisition are in
//! `acquisition_faults.rs`.

#![allow(clippy::unwrap_used)] // what a test cannot do without

mod at_work;

use at_work::{Rig, record};
use zerorate_bench::client::{ClientError, DeviceClient};
use zerorate_bench::plants::PlantKind;
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated;
use zerorate_core::compensate::Mode;
use zerorate_core::drift::Coverage;
use zerorate_core::record::UnitSerial;
use zerorate_core::units::{Axis, Celsius, Taps, TemperatureCode};
use zerorate_core::wire::{CalibrationState, GroupReport, Refusal, Request, TemperatureCheck};
use zerorate_sim::Fault;

/// Scans a group.
const GROUP: u32 = 500;

fn taps(groups: &[GroupReport], axis: Axis) -> Vec<u16> {
    groups.iter().map(|group| group.axes[axis.index()].tap.get()).collect()
}

fn checks(groups: &[GroupReport], axis: Axis) -> Vec<TemperatureCheck> {
    groups.iter().map(|group| group.axes[axis.index()].temperature).collect()
}

#[test]
fn without_a_fault_nothing_is_counted_and_every_temperature_is_believed() {
    let mut rig = Rig::at_work();
    rig.plant.borrow_mut().chamber_set_point(Celsius(60.0)).unwrap();
    let groups = rig.groups(200);
    for axis in Axis::BOTH {
        assert!(checks(&groups, axis).iter().all(|&check| check == TemperatureCheck::Believed));
    }
    let faults = rig.device.faults().unwrap();
    assert_eq!(faults, zerorate_core::wire::FaultCounts::default());
}

#[test]
fn a_stuck_temperature_holds_its_tap_is_said_and_is_believed_again_when_it_moves() {
    let mut rig = Rig::at_work();
    rig.groups(5);
    rig.inject(Fault::StuckTemperature(Axis::X));
    rig.plant.borrow_mut().chamber_set_point(Celsius(60.0)).unwrap();
    // Five minutes of the ramp: Y follows it, X does not know of it.
    let stuck = rig.groups(200);
    assert!(checks(&stuck[1..], Axis::X).iter().all(|&check| check == TemperatureCheck::Stuck));
    let (x, y) = (taps(&stuck[1..], Axis::X), taps(&stuck[1..], Axis::Y));
    assert!(x.iter().all(|&tap| tap == x[0]), "{x:?}");
    assert!(y[0] != y[198], "Y's tap follows the ramp: {y:?}");
    assert_eq!(rig.device.faults().unwrap().temperature_stuck, 199, "from the second group on");
    rig.plant.borrow_mut().clear_faults();
    let mended = rig.groups(6);
    assert_eq!(*checks(&mended, Axis::X).last().unwrap(), TemperatureCheck::Believed);
    assert_eq!(mended[5].axes[0].tap, rig.asked(&mended[4], Axis::X));
}

#[test]
fn a_sensor_that_stands_still_in_its_own_noise_is_found_by_the_other_axis() {
    let mut rig = Rig::at_work();
    rig.groups(5);
    rig.inject(Fault::FrozenTemperature(Axis::X));
    rig.plant.borrow_mut().chamber_set_point(Celsius(60.0)).unwrap();
    let frozen = rig.groups(200);
    let checks = (checks(&frozen, Axis::X), checks(&frozen, Axis::Y));
    assert!(checks.0[150..].iter().all(|&check| check == TemperatureCheck::Stuck), "{:?}", checks.0);
    assert!(checks.1.iter().all(|&check| check == TemperatureCheck::Believed), "{:?}", checks.1);
    rig.plant.borrow_mut().clear_faults();
    assert_eq!(self::checks(&rig.groups(6), Axis::X).last(), Some(&TemperatureCheck::Believed));
}

#[test]
fn one_bad_group_does_not_throw_the_tap_and_a_jump_that_stays_moves_it_to_what_the_model_asks() {
    let mut rig = Rig::at_work();
    let before = rig.groups(5)[4].axes[0].tap;
    rig.inject(Fault::TemperatureOff { axis: Axis::X, counts: -2000, scans: GROUP });
    let glitch = rig.groups(5);
    assert!(checks(&glitch, Axis::X).contains(&TemperatureCheck::Jumped));
    assert!(taps(&glitch, Axis::X).iter().all(|&tap| tap == before.get()), "{:?}", taps(&glitch, Axis::X));
    assert_eq!(*checks(&glitch, Axis::X).last().unwrap(), TemperatureCheck::Believed);
    assert!(checks(&glitch, Axis::Y).iter().all(|&check| check == TemperatureCheck::Believed), "Y is another sensor");

    rig.inject(Fault::TemperatureOff { axis: Axis::X, counts: -2000, scans: 10 * GROUP });
    let stays = rig.groups(9);
    let jumped = checks(&stays, Axis::X).iter().filter(|&&check| check == TemperatureCheck::Jumped).count();
    assert_eq!(jumped, 2, "{:?}", checks(&stays, Axis::X));
    let asked = rig.asked(&stays[7], Axis::X);
    assert_ne!(asked, before);
    // From the old tap to the one that the model asks for, at once, and nowhere else.
    let seen = taps(&stays, Axis::X);
    assert!(seen.iter().all(|&tap| tap == before.get() || tap == asked.get()), "{seen:?}");
    assert_eq!(seen[8], asked.get());
    assert!(rig.device.faults().unwrap().temperature_jumped >= 3);
}

#[test]
fn a_temperature_sensor_that_is_torn_off_is_never_believed() {
    let mut rig = Rig::at_work();
    let before = rig.groups(5)[4].axes[0].tap;
    rig.inject(Fault::TemperatureAt { axis: Axis::X, counts: 0 });
    let groups = rig.groups(20);
    assert_eq!(checks(&groups[1..], Axis::X), [TemperatureCheck::Saturated; 19]);
    assert!(taps(&groups, Axis::X).iter().all(|&tap| tap == before.get()));
    assert!(rig.device.faults().unwrap().temperature_saturated >= 19);
}

#[test]
fn outside_the_calibrated_range_the_temperature_is_clamped_and_it_is_said() {
    // The room is at 10 710 counts.
    let mut rig = Rig::calibrated_over([8500.0, 10_000.0]);
    let groups = rig.groups(5);
    let at_the_end = rig.law.tap(TemperatureCode(40_000)).unwrap();
    for group in &groups[1..] {
        assert_eq!((group.axes[0].coverage, group.axes[0].tap), (Coverage::Above, at_the_end));
    }
    assert_eq!(rig.device.faults().unwrap().out_of_range, 10, "two axes, five groups");
}

#[test]
fn a_saturated_reading_is_marked_and_the_tap_goes_on_following_the_temperature() {
    let mut rig = Rig::at_work();
    rig.groups(5);
    rig.inject(Fault::SaturatedInput(Axis::Y));
    rig.plant.borrow_mut().chamber_set_point(Celsius(60.0)).unwrap();
    let groups = rig.groups(200);
    assert!(groups[1..].iter().all(|group| group.axes[1].saturated && !group.axes[0].saturated));
    assert!(rig.device.faults().unwrap().saturated >= 199);
    assert_ne!(taps(&groups, Axis::Y)[2], taps(&groups, Axis::Y)[199]);
}

#[test]
fn a_wiper_that_cannot_be_written_is_said_and_written_again() {
    let mut rig = Rig::at_work();
    let held = rig.groups(5)[4].axes[0].tap;
    // Both wipers are written as a group closes, then the command is done. One that fails is refused; the wiper, wherever it
    // stands now, is put back at the next group.
    rig.inject(Fault::PotentiometerSpi { transfers: 3 });
    let tap = Taps::new(600).unwrap();
    let refused = rig.device.order(Request::SetTap { axis: Axis::X, tap });
    assert!(matches!(refused, Err(ClientError::Refused(Refusal::TrimPartFailed))), "{refused:?}");
    rig.groups(2);
    assert_eq!(rig.wiper(Axis::X), held.get());
    // A write that fails is tried at every group, and the report says so.
    for axis in Axis::BOTH {
        rig.device.order(Request::SetMode { axis, mode: Mode::Off }).unwrap();
    }
    rig.device.discard_groups();
    rig.inject(Fault::PotentiometerSpi { transfers: 5 });
    let moved = rig.device.order(Request::SetTap { axis: Axis::X, tap });
    assert!(matches!(moved, Err(ClientError::Refused(Refusal::TrimPartFailed))), "{moved:?}");
    let groups = rig.groups(6);
    let failed = groups.iter().filter(|group| group.axes[0].trim_failed).count();
    assert_eq!(failed, 2, "of three failures one was the command's");
    assert_eq!(rig.wiper(Axis::X), held.get());
    assert_eq!(rig.device.faults().unwrap().trim_errors, 8);
}

#[test]
fn a_wiper_that_a_dip_of_the_analogue_supply_puts_back_is_where_it_should_be_within_a_group() {
    let mut rig = Rig::at_work();
    for axis in Axis::BOTH {
        rig.device.order(Request::SetMode { axis, mode: Mode::Off }).unwrap();
    }
    rig.device.set_taps([Taps::new(300).unwrap(); 2]).unwrap();
    rig.device.order(Request::StorePowerUpTap).unwrap();
    rig.device.order(Request::SetMode { axis: Axis::X, mode: Mode::Trim }).unwrap();
    rig.device.order(Request::SetTap { axis: Axis::Y, tap: Taps::new(600).unwrap() }).unwrap();
    rig.device.discard_groups();
    rig.groups(3);
    let held = Axis::BOTH.map(|axis| rig.wiper(axis));
    rig.plant.borrow_mut().brown_out();
    assert_eq!(Axis::BOTH.map(|axis| rig.wiper(axis)), [300, 300], "as when its power comes");
    assert!(!held.contains(&300), "{held:?}");
    let group = rig.group();
    assert_eq!(Axis::BOTH.map(|axis| rig.wiper(axis)), held, "a law's tap and a host's");
    assert!(group.axes.iter().all(|axis| axis.moved_to.is_none()), "to be put back is no move");
    assert_eq!(rig.device.faults().unwrap(), Default::default());
}

#[test]
fn a_blank_device_and_another_units_record_run_at_the_middle_tap_and_say_why() {
    let unit = UnitSerial::try_from("ZR-2").unwrap();
    let (link, _) = simulated::bare_device(PlantKind::Paper.build(1), &SetUp::paper(), &unit);
    let mut device = DeviceClient::new(link);
    let identity = device.identify().unwrap();
    assert_eq!((identity.calibration, identity.taps), (CalibrationState::Blank, [Taps::MIDDLE; 2]));
    let refused = device.deploy(&record([8500.0, 11_900.0]));
    assert!(matches!(refused, Err(ClientError::Refused(Refusal::OtherUnit))), "{refused:?}");
    assert_eq!(device.identify().unwrap().calibration, CalibrationState::Blank);
}
