//! What a platform's vibration does to the zero and to its noise, sample by sample through the port, at each OVERSAMPLING.
//!
//!     cargo test -p zerorate-device --test vibration -- --nocapture
//!
//! prints the figures that gateware/acquisition/README.md has.

#![allow(clippy::unwrap_used)] // what a test cannot do without

use std::f64::consts::{PI, TAU};

use zerorate_core::units::{Axis, Seconds};
use zerorate_device::acquisition::{Acquisition, Set, Timing};
use zerorate_device::port::PortAcquisition;
use zerorate_sim::{Plant, PlantParameters, PortSpi, Vibration};

/// The scan rate: what has it folds onto the zero itself.
const SCAN_HZ: f64 = 1e6 / 3000.0;
/// A vibration's amplitude, and the circuit's counts a deg/s and cut-off.
const RATE_DPS: f64 = 10.0;
const COUNTS_PER_DPS: f64 = 6e-3 * 1.599 / 250e-6;
const CUTOFF_HZ: f64 = 40.0;
/// 12 s: whole periods of what a vibration 3 Hz above the scan rate folds to.
const GROUPS: usize = 8;
const BESIDE_HZ: f64 = 3.0;

/// X's samples of some groups on a board at rest, whose platform vibrates at so many hertz.
fn samples(oversampling: u8, hz: Option<f64>) -> Vec<f64> {
    let plant = Plant::new(PlantParameters::paper(), 5).share();
    plant.borrow_mut().vibrate(Axis::X, hz.map(|hz| Vibration { rate_dps: RATE_DPS, hz }));
    // Scans meet the vibration behind the low-pass, which turns it, at its peaks: where it moves the zero most.
    plant.borrow_mut().wait(Seconds((SCAN_HZ / CUTOFF_HZ).atan() / TAU / SCAN_HZ));
    let mut port = PortAcquisition::new(PortSpi::new(&plant));
    port.start(Timing { oversampling, ..Timing::PAPER }, Timing::PAPER.set_length).unwrap();
    let mut samples = Vec::new();
    for _ in 0..GROUPS {
        plant.borrow_mut().run_set().unwrap();
        let mut set = Set::default();
        assert_eq!(port.read_set(&mut set, true), Ok(true));
        port.read_scans(&mut set).unwrap();
        samples.extend(set.scans.iter().map(|scan| f64::from(scan[1])));
    }
    samples
}

fn mean(samples: &[f64]) -> f64 {
    samples.iter().sum::<f64>() / samples.len() as f64
}

fn rms(samples: &[f64]) -> f64 {
    let mean = mean(samples);
    (samples.iter().map(|sample| (sample - mean).powi(2)).sum::<f64>() / samples.len() as f64).sqrt()
}

/// What two boards of one seed differ by: the vibration alone, but for the rounding of samples.
fn added(with: &[f64], without: &[f64]) -> Vec<f64> {
    with.iter().zip(without).map(|(with, without)| with - without).collect()
}

/// The amplitude of what is in them at so many hertz.
fn amplitude(samples: &[f64], hz: f64) -> f64 {
    let part = |of: fn(f64) -> f64| {
        let turned = |k: usize| of(TAU * hz * k as f64 / SCAN_HZ);
        samples.iter().enumerate().map(|(k, sample)| sample * turned(k)).sum::<f64>() * 2.0 / samples.len() as f64
    };
    part(f64::cos).hypot(part(f64::sin))
}

/// What docs/acquisition-port.md says that a mean of so many conversions lets pass.
fn passes(conversions: f64, hz: f64) -> f64 {
    let turned = PI * hz / SCAN_HZ;
    ((turned.sin()) / (conversions * (turned / conversions).sin())).abs()
}

#[test]
fn a_vibration_at_the_scan_rate_moves_the_zero_of_single_conversions_and_not_of_means() {
    println!("ratio  noise  zero moved  folded to 3 Hz  (counts, of a vibration of {RATE_DPS} deg/s)");
    for oversampling in [1, 2, 4, 8, 16] {
        let at_rest = samples(oversampling, None);
        let zero_moved = mean(&added(&samples(oversampling, Some(SCAN_HZ)), &at_rest));
        let folded = amplitude(&added(&samples(oversampling, Some(SCAN_HZ + BESIDE_HZ)), &at_rest), BESIDE_HZ);
        println!("{oversampling:5} {:6.2} {zero_moved:11.3} {folded:15.3}", rms(&at_rest));

        let before_the_mean = |hz: f64| RATE_DPS * COUNTS_PER_DPS / (hz / CUTOFF_HZ).hypot(1.0);
        let moved = if oversampling == 1 { before_the_mean(SCAN_HZ) } else { 0.0 };
        // To its scale's tolerance, and to what rounding leaves of 4000 samples. Where in its swing the scans fall is where it
        // stood when the board was started: they meet nearly all of it.
        let slack = 0.01 * moved + 0.03;
        assert!((0.9 * moved - slack..moved + slack).contains(&zero_moved.abs()), "{zero_moved} for {moved}");
        let hz = SCAN_HZ + BESIDE_HZ;
        let expected = before_the_mean(hz) * passes(f64::from(oversampling), hz);
        assert!((folded - expected).abs() < 0.01 * expected + 0.03, "{folded} for {expected}");
    }
}
