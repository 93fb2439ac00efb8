//! Samples that are means: what they are of, when, and what they leave of a vibration.

#![allow(clippy::unwrap_used)] // All of it is a test.

use std::cell::Cell;
use std::f64::consts::TAU;
use std::rc::Rc;

use zerorate_gateware::{Bench, Head, Port, Random, Scale, Timing, head, scans};

const SCAN_PERIOD: u8 = 0x03;
const OVERSAMPLING: u8 = 0x06;
const RATIOS: [u32; 5] = [1, 2, 4, 8, 16];
/// The shortest period that has room for 16 passes.
const PERIOD_US: u32 = 1600;

/// What the port is to make of its passes: means to the nearest count, from a half to the even one.
fn means(passes: &[[u16; 4]], ratio: u32) -> Vec<[u16; 4]> {
    let mean = |scan: &[[u16; 4]], channel: usize| {
        let sum: f64 = scan.iter().map(|pass| f64::from(pass[channel])).sum();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // No more than 14 bits.
        let mean = (sum / f64::from(ratio)).round_ties_even() as u16;
        mean
    };
    passes.chunks_exact(ratio as usize).map(|scan| [0, 1, 2, 3].map(|channel| mean(scan, channel))).collect()
}

/// Starts with RESTART by these settings.
fn start(port: &mut Port, ratio: u32, period_us: u32, length: u32) {
    port.write(OVERSAMPLING, ratio);
    port.start(period_us, length);
    assert_eq!(port.read(OVERSAMPLING, 1), [ratio]);
}

fn passes(port: &Port) -> Vec<[u16; 4]> {
    port.bench.scans().iter().map(|pass| pass.samples).collect()
}

#[test]
fn samples_are_the_means_of_their_passes_and_the_sums_are_those_samples() {
    for (seed, ratio) in (20..).zip(RATIOS) {
        // Now and then all conversions of a scan stand at the end of the range; often they are close by each other, where halves
        // are, and else anywhere.
        let mut random = Random::new(u64::from(seed));
        let input = move |_| match random.between(0, 3) {
            0 => 0x3FFF,
            1 => random.counts(),
            _ => 8200 + u16::try_from(random.between(0, 1)).unwrap(),
        };
        let mut port = Port::new(Bench::new(Scale::Fast, seed, input), Timing::QUICK, u64::from(seed));
        start(&mut port, ratio, PERIOD_US, 40);
        for number in 0..4 {
            assert!(port.wait_for_data_ready(100_000));
            let burst = port.read_set(40);
            let expected = &means(&passes(&port), ratio)[40 * number as usize..][..40];
            assert_eq!(scans(&burst, 40).unwrap(), expected, "{ratio}");
            assert_eq!(head(&burst), Some(Head::of(number, false, 0, expected)), "{ratio}");
        }
    }
}

#[test]
fn conversions_that_all_stand_at_the_end_of_the_range_have_it_for_their_mean() {
    for ratio in RATIOS {
        let mut port = Port::new(Bench::new(Scale::Fast, 3, |_| 0x3FFF), Timing::FASTEST, 3);
        start(&mut port, ratio, PERIOD_US, 2);
        assert!(port.wait_for_data_ready(10_000));
        assert_eq!(scans(&port.read_set(2), 2), Some(vec![[0x3FFF; 4]; 2]));
    }
}

#[test]
fn passes_are_evenly_spread_to_a_microsecond_and_a_scan_s_last_is_where_the_scan_would_be_without() {
    for ratio in RATIOS {
        for period_us in [1600, 1601, 1615, 1999] {
            let mut random = Random::new(5);
            let bench = Bench::new(Scale::Fast, 5, move |_| random.counts());
            let mut port = Port::new(bench, Timing::FASTEST, 5);
            start(&mut port, ratio, period_us, 10);
            assert!(port.wait_for_data_ready(30_000));
            let begun: Vec<u64> = port.bench.scans().iter().map(|pass| pass.began_ps).collect();
            let first_scan_ps = begun[ratio as usize - 1];
            let ratio = u64::from(ratio);
            for (pass, &began_ps) in (1..).zip(&begun) {
                // Of the passes' time in microseconds the part that is left over goes up.
                let due_us = (pass * u64::from(period_us)).div_ceil(ratio);
                let from_first_ps = port.bench.period_ps(due_us) + first_scan_ps;
                assert_eq!(
                    began_ps + port.bench.period_ps(u64::from(period_us)),
                    from_first_ps,
                    "{ratio}, pass {pass}"
                );
            }
        }
    }
}

#[test]
fn oversampling_is_taken_up_at_the_start_of_a_set() {
    let mut random = Random::new(6);
    let mut port = Port::new(Bench::new(Scale::Fast, 6, move |_| random.counts()), Timing::FASTEST, 6);
    start(&mut port, 4, PERIOD_US, 3);
    // The sets' ratios, each written while the set before fills; the last by a period that has no room for more.
    let mut first_pass = 0;
    for (ratio, next) in [(4, 16), (16, 1), (1, 8), (8, 16)] {
        port.bench.pass(port.bench.period_ps(u64::from(PERIOD_US)));
        port.write(OVERSAMPLING, next);
        if next == 16 && ratio == 8 {
            port.write(SCAN_PERIOD, 200);
            assert_eq!(port.read(OVERSAMPLING, 1), [2]);
        }
        assert!(port.wait_for_data_ready(30_000));
        let burst = port.read_set(3);
        let expected = means(&passes(&port)[first_pass..], ratio)[..3].to_vec();
        assert_eq!(scans(&burst, 3).unwrap(), expected, "{ratio}");
        first_pass += 3 * ratio as usize;
    }
    let times = port.bench.scans()[first_pass..].iter().map(|pass| pass.began_ps).collect::<Vec<_>>();
    assert!(times.windows(2).all(|pair| pair[1] - pair[0] == port.bench.period_ps(100)));
}

#[test]
fn a_scan_that_is_dropped_in_any_of_its_passes_leaves_nothing_in_the_next() {
    for pause_us in (0..2 * u64::from(PERIOD_US)).step_by(37) {
        let mut random = Random::new(7);
        let mut port = Port::new(Bench::new(Scale::Fast, 7, move |_| random.counts()), Timing::FASTEST, 7);
        start(&mut port, 16, PERIOD_US, 2);
        port.bench.pass(port.bench.period_ps(pause_us));
        port.write(0x02, 0b11);
        port.bench.pass(250_000);
        port.bench.count_scans();
        assert!(port.wait_for_data_ready(10_000));
        assert_eq!(scans(&port.read_set(2), 2).unwrap(), means(&passes(&port), 16)[..2], "after {pause_us} us");
    }
}

/// A sine's amplitude in a row of samples, and where in time it is: the phase at the row's beginning, in cycles.
fn sine(samples: &[f64], cycles: f64) -> (f64, f64) {
    let count = samples.len() as f64;
    let turn = |k: usize| TAU * cycles * k as f64 / count;
    let part = |of: fn(f64) -> f64| samples.iter().enumerate().map(|(k, s)| s * of(turn(k))).sum::<f64>() * 2.0 / count;
    let (real, imaginary) = (part(f64::cos), -part(f64::sin));
    (real.hypot(imaginary), imaginary.atan2(real) / TAU)
}

const SINES: usize = 1000;
const AMPLITUDE: f64 = 4000.0;

/// The port's samples of a constant (channel 0) and of three sines of so many cycles a scan, whose phase in cycles is 0 as the
/// first scan's last pass begins.
fn samples_of_sines(ratio: u32, cycles_a_scan: [f64; 3]) -> [Vec<f64>; 4] {
    let pass = Rc::new(Cell::new(0_u32));
    let now = Rc::clone(&pass);
    let input = move |channel: usize| {
        // Passes are counted as they begin, from 1.
        let scans = f64::from(now.get()) / f64::from(ratio) - 1.0;
        let sine = channel.checked_sub(1).map_or(0.0, |k| (TAU * cycles_a_scan[k] * scans).cos());
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // Within the converter's range.
        let counts = (8200.0 + AMPLITUDE * sine).round() as u16;
        counts
    };
    let mut bench = Bench::new(Scale::Fast, 8, input);
    bench.at_each_pass(move || pass.set(pass.get() + 1));
    let mut port = Port::new(bench, Timing::FASTEST, 8);
    start(&mut port, ratio, PERIOD_US, 500);
    let mut samples: [Vec<f64>; 4] = Default::default();
    for _ in 0..SINES / 500 {
        assert!(port.wait_for_data_ready(1_000_000));
        for scan in scans(&port.read_set(500), 500).unwrap() {
            samples.iter_mut().zip(scan).for_each(|(samples, counts)| samples.push(f64::from(counts) - 8200.0));
        }
    }
    samples
}

/// At the paper's 3 ms a scan: a vibration of 333.33 + 3 Hz, the band's 10 Hz, and 40 Hz. What passes was computed as the mean of
/// so many points on the unit circle:
///
///     python3 -c 'import cmath
///     for f in (1000 / 3 + 3, 10, 40):
///         print(abs(sum(cmath.exp(2j * cmath.pi * f * 0.003 / 16 * k) for k in range(16))) / 16)'
#[test]
fn a_vibration_at_the_scan_rate_folds_without_and_is_41_db_less_with_16_while_the_band_passes() {
    let cycles_a_scan = [1.009, 0.030, 0.120];
    for (ratio, passes) in [(1, [1.0; 3]), (16, [0.008_977, 0.998_526, 0.976_536])] {
        let samples = samples_of_sines(ratio, cycles_a_scan);
        assert!(samples[0].iter().all(|&off| off == 0.0), "a constant stays what it is, to the count");
        for (channel, (cycles, passes)) in cycles_a_scan.into_iter().zip(passes).enumerate() {
            // In 1000 scans, the scan rate itself folded away.
            let (amplitude, phase) = sine(&samples[channel + 1], (cycles * SINES as f64) % SINES as f64);
            // Conversions of a sine that comes round again after some scans are rounded alike each time.
            assert!((amplitude - AMPLITUDE * passes).abs() < 0.3, "{ratio}: {amplitude} of {passes}");
            // A sample is as it was in the middle of its passes, 7.5 of them before the last. A sine that folds turns beyond the
            // filter's first notch, where it comes out the other way round.
            let middle = -cycles * (f64::from(ratio) - 1.0) / (2.0 * f64::from(ratio));
            let turned = if cycles > 1.0 && ratio > 1 { 0.5 } else { 0.0 };
            let off = phase - middle - turned;
            assert!((off - off.round()).abs() < 2e-3, "{ratio}, {cycles}: {phase} cycles for {middle}");
        }
    }
}
