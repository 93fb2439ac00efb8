//! A little master of the acquisition port, and a little least squares: the tests' own.
// Each test uses its part of it; clippy knows tests by their attribute, and these are their helpers.
#![allow(dead_code, clippy::unwrap_used)]

use embedded_hal::spi::SpiDevice;
use zerorate_core::units::{Axis, Celsius, Seconds, Taps};
use zerorate_sim::{Plant, PlantParameters, PortSpi, PotentiometerSpi, SharedPlant, Truth};

/// A plant with its wipers at N0 and its port running.
pub fn running(parameters: PlantParameters, seed: u64) -> (SharedPlant, PortSpi, PotentiometerSpi) {
    let plant = Plant::new(parameters, seed).share();
    let (mut port, mut potentiometer) = (PortSpi::new(&plant), PotentiometerSpi::new(&plant));
    for axis in Axis::BOTH {
        write_tap(&mut potentiometer, axis, 511);
    }
    run(&mut port, true);
    (plant, port, potentiometer)
}

/// Writes RUN; the last four bytes are the write's CRC-32/MPEG-2.
pub fn run(port: &mut PortSpi, run: bool) {
    let start = [0x82, 0, 0, 0, 0, 1, 0xAD, 0x20, 0x81, 0xE6];
    let stop = [0x82, 0, 0, 0, 0, 0, 0xA9, 0xE1, 0x9C, 0x51];
    port.write(if run { &start } else { &stop }).unwrap();
}

pub fn write_tap(potentiometer: &mut PotentiometerSpi, axis: Axis, tap: u16) {
    let [high, low] = (tap << 6).to_be_bytes();
    potentiometer.write(&[1 + u8::try_from(axis.index()).unwrap(), high, low]).unwrap();
}

pub fn tap(position: u16) -> Taps {
    Taps::new(position).unwrap()
}

/// One axis of a set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Group {
    pub temperature: f64,
    pub reading: f64,
    pub drift: f64,
    pub wiper: f64,
    pub true_temperature: f64,
}

/// Runs a set and reads its samples: scan by scan, four channels each.
pub fn samples(plant: &SharedPlant, port: &mut PortSpi) -> (Truth, Vec<[u16; 4]>) {
    let truth = plant.borrow_mut().run_set().unwrap();
    let scans = read_samples(port, truth.scans);
    (truth, scans)
}

/// Reads the samples of the set that waits, of so many scans.
pub fn read_samples(port: &mut PortSpi, scans: u32) -> Vec<[u16; 4]> {
    let mut burst = vec![0; 2 + 64 + 8 * scans as usize];
    burst[0] = 0x10;
    port.transfer_in_place(&mut burst).unwrap();
    let scans = burst[66..]
        .chunks_exact(8)
        .map(|scan| core::array::from_fn(|channel| u16::from_be_bytes([scan[2 * channel], scan[2 * channel + 1]])));
    scans.collect()
}

/// Runs a set and reads its means.
pub fn group(plant: &SharedPlant, port: &mut PortSpi) -> [Group; 2] {
    let truth = plant.borrow_mut().run_set().unwrap();
    let mut burst = [0; 66];
    burst[0] = 0x10;
    port.transfer_in_place(&mut burst).unwrap();
    let mean = |word: usize| {
        let at = 2 + 4 * word;
        f64::from(u32::from_be_bytes(burst[at..at + 4].try_into().unwrap())) / f64::from(truth.scans)
    };
    Axis::BOTH.map(|axis| {
        let (word, truth) = (3 + 2 * axis.index(), &truth.axes[axis.index()]);
        Group {
            temperature: mean(word),
            reading: mean(word + 1),
            drift: truth.drift_counts,
            wiper: truth.wiper_counts,
            true_temperature: truth.temperature_counts,
        }
    })
}

/// Soaks for an hour at one temperature with the port stopped, then records an hour on the way to the other.
pub fn ramp(parameters: PlantParameters, seed: u64, from_c: f64, to_c: f64) -> Vec<[Group; 2]> {
    let (plant, mut port, _) = running(parameters, seed);
    run(&mut port, false);
    plant.borrow_mut().chamber_set_point(Celsius(from_c)).unwrap();
    plant.borrow_mut().wait(Seconds(3600.0));
    hour(&plant, &mut port, to_c)
}

/// Sends the chamber to a temperature and records an hour.
pub fn hour(plant: &SharedPlant, port: &mut PortSpi, to_c: f64) -> Vec<[Group; 2]> {
    run(port, true);
    plant.borrow_mut().chamber_set_point(Celsius(to_c)).unwrap();
    let groups = (0..2400).map(|_| group(plant, port)).collect();
    run(port, false);
    groups
}

/// The least squares parabola through points, as a function.
pub fn parabola(points: impl Iterator<Item = (f64, f64)> + Clone) -> impl Fn(f64) -> f64 {
    let scaled = |t: f64| (t - 10_200.0) / 1700.0;
    let mut normal = [[0.0; 4]; 3];
    for (t, v) in points {
        let x = scaled(t);
        let powers = [1.0, x, x * x];
        for (row, power) in normal.iter_mut().zip(powers) {
            let terms = [1.0, x, x * x, v];
            row.iter_mut().zip(terms).for_each(|(sum, term)| *sum += power * term);
        }
    }
    for pivot in 0..3 {
        let row = normal[pivot].map(|term| term / normal[pivot][pivot]);
        for (index, other) in normal.iter_mut().enumerate() {
            let factor = other[pivot];
            if index == pivot {
                *other = row;
            } else {
                other.iter_mut().zip(row).for_each(|(term, of_row)| *term -= factor * of_row);
            }
        }
    }
    let [c0, c1, c2] = normal.map(|row| row[3]);
    move |t| c0 + scaled(t) * (c1 + scaled(t) * c2)
}

/// Largest less smallest.
pub fn peak_to_peak(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
    high - low
}
