//! Two readings of every fact: the driver and the simulated chip, the processor's acquisition and the port's.

#![allow(clippy::unwrap_used)] // what a test cannot do without

use max5494::{Channel, Channels, Max5494, Position};
use zerorate_bench::instruments::Bench;
use zerorate_bench::run::{Phase, Recorder, Session, Silent, Taken};
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated;
use zerorate_core::record::UnitSerial;
use zerorate_core::units::{Axis, Celsius, Taps};
use zerorate_core::wire::SampleWindow;
use zerorate_device::trim_part::{Max5494Trim, TrimPart};
use zerorate_sim::{Plant, PlantDelay, PlantParameters, PotentiometerParameters, PotentiometerSpi, SPI_BYTE_NS};

fn position(tap: u16) -> Position {
    Position::new(tap).unwrap()
}

#[test]
fn every_command_of_the_driver_is_understood_by_the_simulated_chip() {
    let plant = Plant::new(PlantParameters::paper(), 1).share();
    let mut delay = PlantDelay::new(&plant);
    let mut driver = Max5494::new(PotentiometerSpi::new(&plant));
    let wipers = || Axis::BOTH.map(|axis| plant.borrow().potentiometer().wiper(axis).get());
    let stored = || Axis::BOTH.map(|axis| plant.borrow().potentiometer().stored(axis).get());

    driver.write_wiper(Channel::One, position(500)).unwrap();
    driver.write_wiper(Channel::Two, position(1023)).unwrap();
    assert_eq!(wipers(), [500, 1023]);

    driver.write_nv(Channel::One, position(7), &mut delay).unwrap();
    driver.write_nv(Channel::Two, position(8), &mut delay).unwrap();
    assert_eq!((wipers(), stored()), ([500, 1023], [7, 8]), "a store does not move the wiper");

    driver.copy_nv_to_wiper(Channel::One).unwrap();
    assert_eq!(wipers(), [7, 1023]);
    driver.copy_nv_to_wiper(Channel::Two).unwrap();
    assert_eq!(wipers(), [7, 8]);

    driver.write_wiper(Channel::One, position(1)).unwrap();
    driver.write_wiper(Channel::Two, position(2)).unwrap();
    driver.copy_wiper_to_nv(Channel::One, &mut delay).unwrap();
    assert_eq!(stored(), [1, 8]);
    driver.copy_wiper_to_nv(Channel::Two, &mut delay).unwrap();
    assert_eq!(stored(), [1, 2]);
    driver.write_wiper(Channel::One, position(3)).unwrap();
    driver.copy_wiper_to_nv(Channels::Both, &mut delay).unwrap();
    assert_eq!(stored(), [3, 2]);
    driver.write_wiper(Channel::One, position(900)).unwrap();
    driver.copy_nv_to_wiper(Channels::Both).unwrap();
    assert_eq!(wipers(), [3, 2]);

    for tap in 0..=1023 {
        driver.write_wiper(Channel::One, position(tap)).unwrap();
        assert_eq!(wipers()[0], tap);
    }
    let plant = plant.borrow();
    let chip = plant.potentiometer();
    assert_eq!((chip.ignored_illegal(), chip.ignored_busy()), (0, 0), "nothing was said twice or too early");
}

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

#[test]
fn the_processor_driving_the_a_d_and_the_port_give_the_same_groups_bit_for_bit() {
    // On the bus before the port scans: it is stopped, asked who it is, set up with each register read back, and started. Where
    // the processor scans there is none of it: its plant is so much later, both by more than a scan's period, and the wipers
    // stand where a start writes them. So both scan at the same instants.
    const SETTING_UP_BYTES: u64 = 74;
    let setup = SetUp::paper();
    let serial = UnitSerial::new();
    let plant_after = |ns: u64| {
        let potentiometer = PotentiometerParameters { factory_tap: Taps::MIDDLE, ..PotentiometerParameters::default() };
        let mut plant = Plant::new(PlantParameters { potentiometer, ..PlantParameters::paper() }, 3);
        plant.pass_until_ns(10_000_000 + ns);
        plant
    };
    let by_port = take(simulated::bench(plant_after(0), &setup, &serial), &setup, 60);
    let direct = plant_after(SETTING_UP_BYTES * SPI_BYTE_NS);
    let direct = take(simulated::direct_bench(direct, &setup, &serial), &setup, 60);
    assert_eq!(by_port.len(), 60);
    for (port, direct) in by_port.iter().zip(&direct) {
        assert_eq!(port.report, direct.report);
    }
}

/// docs/paper.md: 511 is stored once, when a board is first set up, and checked by a power cycle.
#[test]
fn the_middle_tap_is_stored_once_and_survives_a_power_cycle() {
    let plant = Plant::new(PlantParameters::paper(), 1).share();
    let mut part = Max5494Trim::new(PotentiometerSpi::new(&plant), PlantDelay::new(&plant));
    for axis in Axis::BOTH {
        part.write(axis, Taps::MIDDLE).unwrap();
    }
    part.store_power_up().unwrap();
    part.write(Axis::X, Taps::LAST).unwrap();
    plant.borrow_mut().power_cycle();
    for axis in Axis::BOTH {
        assert_eq!(plant.borrow().potentiometer().wiper(axis), Taps::MIDDLE);
        assert_eq!(plant.borrow().potentiometer().stores(axis), 1);
    }
}
