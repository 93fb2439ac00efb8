//! The bench as a processor and a procedure meet it.

// Clippy knows tests by their attribute; there are helpers among them.
#![allow(clippy::unwrap_used)]

mod support;

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::{Error, ErrorKind, Operation, SpiDevice};
use support::{group, read_samples, run, running, samples, tap, write_tap};
use zerorate_core::units::{Axis, Celsius, DegreesPerSecond, Seconds, Volts};
use zerorate_sim::{
    BusFault, ConverterSpi, Fault, Plant, PlantDelay, PlantParameters, PortSpi, SPI_BYTE_NS, SharedPlant,
};

/// The paper's plant without any noise.
fn silent() -> PlantParameters {
    let mut parameters = PlantParameters::paper();
    for axis in &mut parameters.axes {
        axis.gyro.white_dps_per_root_hz = 0.0;
        axis.gyro.flicker_dps = 0.0;
        axis.gyro.rate_walk_dps_per_root_s = 0.0;
        axis.circuit.noise_v = 0.0;
        axis.sensor.noise_v = 0.0;
    }
    parameters.converter.noise_lsb = 0.0;
    parameters.supply.noise_v = 0.0;
    parameters
}

/// Reads the four held channels through the A/D's own protocol: four configurations, two frames behind.
fn convert(converter: &mut ConverterSpi, delay: &mut PlantDelay) -> [u16; 4] {
    let frames = [0_u16, 1, 2, 3, 0, 0].map(|channel| {
        let word: u16 = 1 << 13 | 0b111 << 10 | channel << 7 | 1 << 6 | 0b110 << 3 | 1;
        let mut frame = (word << 2).to_be_bytes();
        converter.transfer_in_place(&mut frame).unwrap();
        delay.delay_ns(2200);
        u16::from_be_bytes(frame) >> 2
    });
    [frames[2], frames[3], frames[4], frames[5]]
}

#[test]
fn a_processor_that_drives_the_converter_sees_the_port_s_samples() {
    let (through_port, mut port, mut port_wiper) = running(PlantParameters::typical(5), 5);
    let (direct, mut idle, mut direct_wiper) = running(PlantParameters::typical(5), 5);
    run(&mut idle, false);
    let (mut converter, mut delay) = (ConverterSpi::new(&direct), PlantDelay::new(&direct));
    // Both scan from one instant on, more than a period after all before.
    run(&mut port, false);
    through_port.borrow_mut().wait(Seconds(0.01));
    run(&mut port, true);
    let ahead = through_port.borrow().time() - direct.borrow().time();
    direct.borrow_mut().wait(ahead);
    for plant in [&through_port, &direct] {
        plant.borrow_mut().chamber_set_point(Celsius(60.0)).unwrap();
    }
    for set in 0..3 {
        let truth = through_port.borrow_mut().run_set().unwrap();
        // Before the samples are read, which takes two scans.
        write_tap(&mut port_wiper, Axis::Y, 505 + set);
        let of_port = read_samples(&mut port, 500);
        for (index, scan) in of_port.iter().enumerate() {
            direct.borrow_mut().next_scan();
            assert_eq!(convert(&mut converter, &mut delay), *scan, "set {set}, scan {index}");
        }
        assert_eq!(direct.borrow_mut().take_truth(), Some(truth));
        write_tap(&mut direct_wiper, Axis::Y, 505 + set);
    }
}

#[test]
fn a_reading_is_drift_and_wiper_and_rotation_and_noise() {
    let (plant, mut port, mut potentiometer) = running(PlantParameters::paper(), 3);
    write_tap(&mut potentiometer, Axis::X, 520);
    write_tap(&mut potentiometer, Axis::Y, 490);
    plant.borrow_mut().turn(Axis::Y, DegreesPerSecond(20.0));
    plant.borrow_mut().chamber_set_point(Celsius(0.0)).unwrap();
    for _ in 0..40 {
        let (truth, scans) = samples(&plant, &mut port);
        for (axis, rotation) in Axis::BOTH.into_iter().zip([0.0, -20.0 * 6e-3 * 31.64 * 1023.0 / 5.0]) {
            let mean = |channel: usize| {
                scans.iter().map(|scan| f64::from(scan[2 * axis.index() + channel])).sum::<f64>() / 500.0
            };
            let of = &truth.axes[axis.index()];
            assert!((of.rotation_counts - rotation).abs() < 0.01 * rotation.abs() + 1e-9, "{of:?}");
            let noise = mean(1) - of.drift_counts - of.wiper_counts - of.rotation_counts;
            // 0.015 deg/s per root hertz is 0.33 counts over a set; flicker and walk come to 0.25.
            assert!(noise.abs() < 2.5, "set {} {}: {noise} counts", truth.set, axis.name());
            assert!((mean(0) - of.temperature_counts).abs() < 0.8);
        }
    }
}

#[test]
fn a_step_of_the_wiper_settles_with_the_low_pass_from_the_latency_on() {
    let (plant, mut port, mut potentiometer) = running(silent(), 1);
    let before = group(&plant, &mut port)[0].reading;
    write_tap(&mut potentiometer, Axis::X, 551);
    let step = plant.borrow().true_tap_counts(Axis::X, tap(551));
    let (truth, scans) = samples(&plant, &mut port);
    let settled = |scan: f64| 1.0 - (-(scan * 3e-3 - 170e-6) * 2.0 * core::f64::consts::PI * 40.0).exp();
    for (k, scan) in (1_u32..=10).zip(&scans) {
        let expected = before + step * settled(f64::from(k));
        assert!((f64::from(scan[1]) - expected).abs() < 1.1, "scan {k}: {} for {expected}", scan[1]);
    }
    let mean = (1..=500).map(|k| settled(f64::from(k))).sum::<f64>() / 500.0;
    assert!((truth.axes[0].wiper_counts / step - mean).abs() < 1e-4);
    assert!(truth.axes[1].wiper_counts.abs() < 1e-9);
}

#[test]
fn one_tap_moves_the_reading_by_31_26_and_31_64_counts_within_the_part_s_dnl() {
    let plant = Plant::new(PlantParameters::paper(), 2);
    for (axis, counts) in Axis::BOTH.into_iter().zip([31.26, 31.64]) {
        let at = |position| plant.true_tap_counts(axis, tap(position));
        assert!(at(511).abs() < 1e-12);
        let steps: Vec<f64> = (412..612).map(|position| at(position + 1) - at(position)).collect();
        let mean = steps.iter().sum::<f64>() / steps.len() as f64;
        let spread = (steps.iter().map(|step| (step - mean).powi(2)).sum::<f64>() / steps.len() as f64).sqrt();
        assert!((mean / counts - 1.0).abs() < 0.06 * 4.0 / 200_f64.sqrt(), "{mean}");
        assert!((spread / counts - 0.06).abs() < 0.015, "{spread}");
    }
}

#[test]
fn a_unit_repeats_bit_for_bit_by_its_seed() {
    let record = |seed| {
        let (plant, mut port, _) = running(PlantParameters::typical(seed), seed);
        plant.borrow_mut().wait(Seconds(4.5));
        (samples(&plant, &mut port), samples(&plant, &mut port))
    };
    assert_eq!(record(11), record(11));
    assert_ne!(record(11).0.1, record(12).0.1);
}

#[test]
fn a_parameter_of_one_source_leaves_the_other_sources_numbers_alone() {
    let mut other = PlantParameters::paper();
    other.axes[0].circuit.noise_v = 0.0;
    other.axes[0].gyro.flicker_dps = 0.0;
    let record = |parameters| {
        let (plant, mut port, _) = running(parameters, 1);
        samples(&plant, &mut port).1
    };
    let changed = record(PlantParameters::paper()).into_iter().zip(record(other));
    let mut differ = false;
    for (one, two) in changed {
        assert_eq!([one[0], one[2], one[3]], [two[0], two[2], two[3]]);
        differ |= one[1] != two[1];
    }
    assert!(differ);
}

#[test]
fn bytes_take_the_time_of_their_clock_and_scans_come_within_a_transfer() {
    let (plant, mut port, mut potentiometer) = running(PlantParameters::paper(), 1);
    let began = plant.borrow().next_scan_ns().unwrap() - 3_000_000;
    // Sixteen bytes have started it: 8 x 16 clocks of 5.25 MHz.
    assert!(began.abs_diff(128 * 1_000_000_000 / 5_250_000) < 16, "{began} ns");
    plant.borrow_mut().run_set();
    let scans = read_samples(&mut port, 500);
    assert_eq!(plant.borrow().next_scan_ns(), Some(began + 503 * 3_000_000), "two scans came while 6.2 ms were read");
    assert_eq!(scans.len(), 500);
    write_tap(&mut potentiometer, Axis::X, 500);
    let took = (66 + 4000 + 3) * SPI_BYTE_NS;
    let at_ns = (plant.borrow().time().0 * 1e9).round();
    assert!((at_ns - (began + 1_500_000_000 + took) as f64).abs() < 1.0, "{at_ns}");
}

#[test]
fn a_driver_s_delay_outlasts_a_store_while_the_port_scans_on_time() {
    let (plant, mut port, mut potentiometer) = running(PlantParameters::paper(), 1);
    let started = plant.borrow().time().0;
    group(&plant, &mut port);
    potentiometer.write(&[0x23]).unwrap();
    write_tap(&mut potentiometer, Axis::X, 600);
    assert_eq!(plant.borrow().potentiometer().ignored_busy(), 1);
    PlantDelay::new(&plant).delay_ms(12);
    write_tap(&mut potentiometer, Axis::X, 600);
    assert_eq!(plant.borrow().potentiometer().wiper(Axis::X), tap(600));
    assert_eq!(plant.borrow().potentiometer().stored(Axis::X), tap(511));
    let second = group(&plant, &mut port);
    let read = 66.0 * SPI_BYTE_NS as f64 * 1e-9;
    assert!((plant.borrow().time().0 - started - 3.0 - read).abs() < 1e-9, "the second set ends where it would have");
    // Four scans had passed, the last one a moment ago, and 496 saw the new tap.
    assert!((second[0].wiper / (31.26 * 89.0) - 496.0 / 500.0).abs() < 0.05);
}

#[test]
fn power_off_and_on_loads_the_stored_taps_resets_the_port_and_draws_a_new_offset() {
    let (plant, mut port, mut potentiometer) = running(silent(), 1);
    potentiometer.write(&[0x11, 0x7F, 0xC0]).unwrap(); // 511 into wiper 1's memory
    write_tap(&mut potentiometer, Axis::X, 700);
    let first = group(&plant, &mut port)[0].drift;
    plant.borrow_mut().power_cycle();
    assert_eq!(plant.borrow().potentiometer().wiper(Axis::X), tap(511));
    assert_eq!(plant.borrow().potentiometer().wiper(Axis::Y), tap(512));
    assert!(!port.data_ready() && plant.borrow_mut().run_set().is_none());
    run(&mut port, true);
    let second = group(&plant, &mut port)[0];
    assert!(second.wiper.abs() < 1e-9);
    assert!((1e-3..6.0).contains(&(second.drift - first).abs()), "{first} {}", second.drift);
}

#[test]
fn the_supply_stands_in_for_both_gyros_and_the_rails_end_its_span() {
    let (plant, mut port, _) = running(PlantParameters::paper(), 1);
    let with_gyro = group(&plant, &mut port);
    let volts = plant.borrow().rate_volts(Axis::X);
    plant.borrow_mut().connect_supply(volts);
    group(&plant, &mut port);
    let with_supply = group(&plant, &mut port);
    assert!((with_supply[0].reading - with_gyro[0].reading).abs() < 3.0);
    assert!((with_supply[0].reading - with_supply[0].drift).abs() < 0.2, "the supply is quiet");
    let raised = Volts(volts.0 + 0.1);
    plant.borrow_mut().connect_supply(raised);
    group(&plant, &mut port);
    let fell = with_supply[1].reading - group(&plant, &mut port)[1].reading;
    assert!((fell - 0.1 * 31.64 * 1023.0 / 5.0).abs() < 2.0, "{fell}");
    for (volts, reading) in [(0.0, 16_383.0), (5.0, 0.02 / 250e-6)] {
        plant.borrow_mut().connect_supply(Volts(volts));
        group(&plant, &mut port);
        let group = group(&plant, &mut port)[0];
        assert!((group.reading - reading).abs() < 1.0 && (group.drift - reading).abs() < 1.0, "{group:?}");
    }
    plant.borrow_mut().connect_gyro();
    group(&plant, &mut port);
    assert!((group(&plant, &mut port)[0].reading - with_gyro[0].reading).abs() < 2.0);
}

#[test]
fn waiting_and_scanning_arrive_at_the_same_temperature() {
    let after = |wait: bool| {
        let (plant, mut port, _) = running(silent(), 1);
        plant.borrow_mut().chamber_set_point(Celsius(-40.0)).unwrap();
        run(&mut port, !wait);
        if wait {
            plant.borrow_mut().wait(Seconds(300.0));
            run(&mut port, true);
        } else {
            (0..200).for_each(|_| _ = plant.borrow_mut().run_set());
        }
        plant.borrow_mut().run_set().unwrap()
    };
    let (waited, scanned) = (after(true), after(false));
    for (one, two) in waited.axes.iter().zip(&scanned.axes) {
        assert!((one.package_c - two.package_c).abs() < 0.005, "{} {}", one.package_c, two.package_c);
        assert!((one.drift_counts - two.drift_counts).abs() < 0.05);
    }
}

#[test]
fn a_wait_while_the_port_runs_fills_and_loses_sets() {
    let (plant, mut port, _) = running(PlantParameters::paper(), 1);
    plant.borrow_mut().wait(Seconds(4.6));
    assert!(port.data_ready());
    let mut status = [0x05, 0, 0, 0, 0, 0];
    port.transfer_in_place(&mut status).unwrap();
    assert_eq!(status[2..], [0, 2, 0, 0b11]);
    assert_eq!(plant.borrow_mut().run_set().unwrap().set, 3);
}

#[test]
fn the_chamber_refuses_what_it_cannot_do() {
    let mut plant = Plant::new(PlantParameters::paper(), 1);
    assert!(plant.chamber_set_point(Celsius(151.0)).is_err());
    plant.wait(Seconds(600.0));
    assert!((plant.chamber_air().0 - 25.0).abs() < 0.11);
}

#[test]
fn every_spi_operation_clocks_the_same_bytes() {
    let plant = Plant::new(PlantParameters::paper(), 1).share();
    let mut port = PortSpi::new(&plant);
    let (mut whole, mut parts, mut padded) = ([0, 0, 0, 0, 0, 0], [0; 4], [0; 6]);
    port.transfer_in_place(&mut whole).unwrap();
    port.transaction(&mut [Operation::Write(&[0]), Operation::Write(&[0]), Operation::Read(&mut parts)]).unwrap();
    port.transfer(&mut padded, &[0]).unwrap();
    assert_eq!((whole[2..].to_vec(), whole), (parts.to_vec(), padded));
    assert_eq!(&whole[2..], b"ZRAQ");
}

fn faulty(fault: Fault) -> (SharedPlant, PortSpi) {
    let (plant, mut port, _) = running(PlantParameters::paper(), 1);
    group(&plant, &mut port);
    plant.borrow_mut().inject(fault);
    (plant, port)
}

#[test]
fn a_stuck_temperature_repeats_and_leaves_the_other_axis_alone() {
    let (plant, mut port) = faulty(Fault::StuckTemperature(Axis::X));
    let (_, scans) = samples(&plant, &mut port);
    assert!(scans.iter().all(|scan| scan[0] == scans[0][0]));
    assert!(scans.iter().any(|scan| scan[2] != scans[0][2]));
    plant.borrow_mut().clear_faults();
    let (_, scans) = samples(&plant, &mut port);
    assert!(scans.iter().any(|scan| scan[0] != scans[0][0]));
}

#[test]
fn a_saturated_input_reads_full_scale() {
    let (plant, mut port) = faulty(Fault::SaturatedInput(Axis::Y));
    let (_, scans) = samples(&plant, &mut port);
    assert!(scans.iter().all(|scan| scan[3] == 16_383 && scan[1] < 9000));
}

#[test]
fn a_dead_bus_fails_every_transfer_and_says_so() {
    let (plant, mut port) = faulty(Fault::DeadSpi);
    assert_eq!(port.read(&mut [0; 4]), Err(BusFault));
    assert_eq!(ConverterSpi::new(&plant).write(&[0; 2]), Err(BusFault));
    assert_eq!(BusFault.kind(), ErrorKind::Other);
    assert_eq!(BusFault.to_string(), "the bench's SPI bus is dead");
}
