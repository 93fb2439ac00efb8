//! Groups through the verilated acquisition block and through the simulated port.

#![allow(clippy::unwrap_used)] // what a test cannot do without

use zerorate_bench::instruments::Bench;
use zerorate_bench::plants::PlantKind;
use zerorate_bench::run::{Phase, Recorder, Session, Silent, Taken};
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated;
use zerorate_core::record::UnitSerial;
use zerorate_core::units::{Celsius, Taps};
use zerorate_core::wire::SampleWindow;
use zerorate_gateware_bench::GatewareAcquisition;

fn take(mut bench: Bench, setup: &SetUp, groups: u32) -> Vec<Taken> {
    let mut progress = Silent;
    let mut session = Session::new(&mut bench, setup, &mut progress);
    session.begin().unwrap();
    session.bench.chamber.set(Celsius(60.0)).unwrap();
    session.start(SampleWindow::ALL).unwrap();
    let mut taken = session.until(groups / 2, Phase::Heating, &mut Recorder::discarding()).unwrap();
    session.bench.device.set_taps([Taps::new(520).unwrap(), Taps::new(490).unwrap()]).unwrap();
    taken.extend(session.until(groups, Phase::Heating, &mut Recorder::discarding()).unwrap());
    taken
}

/// Groups through the port and through the gateware are the same in everything that the device reports.
fn compare(group_length: u16, oversampling: u8, groups: u32) {
    let mut setup = SetUp::paper();
    setup.acquisition.group_length = group_length;
    setup.acquisition.oversampling = oversampling;
    let serial = UnitSerial::new();
    let plant = || PlantKind::Paper.build(3);
    let by_port = take(simulated::bench(plant(), &setup, &serial), &setup, groups);
    let by_gateware = take(simulated::bench_on::<GatewareAcquisition>(plant(), &setup, &serial), &setup, groups);
    assert_eq!([by_port.len(), by_gateware.len()], [groups as usize; 2]);
    // Number, sums, taps, corrected readings and losses of both axes.
    for (port, gateware) in by_port.iter().zip(&by_gateware) {
        assert_eq!(port.report, gateware.report);
        assert_eq!(port.truth, gateware.truth);
    }
    let taps = [0, groups as usize - 1].map(|group| by_port[group].report.axes[0].tap);
    assert_eq!(taps, [Taps::MIDDLE, Taps::new(520).unwrap()], "the tap was changed on the way");
}

#[test]
fn sixty_groups_through_the_gateware_and_the_port_are_the_same_bit_for_bit() {
    compare(50, 1, 60);
}

#[test]
fn so_are_groups_of_the_paper_s_length() {
    compare(500, 1, 4);
}

#[test]
fn so_are_groups_of_means() {
    compare(20, 16, 24);
}
