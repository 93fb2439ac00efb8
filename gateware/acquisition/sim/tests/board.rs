//! At the board's own scale: real microseconds, and the A/D's data sheet.

#![allow(clippy::unwrap_used)] // All of it is a test.

use std::cell::Cell;
use std::rc::Rc;

use zerorate_gateware::{Bench, Head, Port, Random, Scale, Timing, head, scans};

fn port(seed: u32) -> Port {
    let mut samples = Random::new(u64::from(seed));
    Port::new(Bench::new(Scale::Board, seed, move |_| samples.counts()), Timing::FASTEST, u64::from(seed))
}

#[test]
fn the_paper_s_rate_is_a_scan_every_3000_microseconds() {
    let mut port = port(1);
    port.start(3000, 5);
    assert!(port.wait_for_data_ready(16_000));
    let scans = port.bench.scans();
    let three_milliseconds_ps = 3_000_000_000;
    for pair in scans.windows(2) {
        let period_ps = pair[1].began_ps - pair[0].began_ps;
        // The clock here is 24 MHz within 20 parts in a million, as its half period is a whole number of picoseconds.
        assert!(period_ps.abs_diff(three_milliseconds_ps) < 3_000_000_000 / 50_000, "{period_ps} ps");
    }
    let samples: Vec<[u16; 4]> = scans.iter().map(|scan| scan.samples).collect();
    assert_eq!(head(&port.read(0x10, 16)), Some(Head::of(0, false, 0, &samples)));
}

#[test]
fn the_a_d_s_data_sheet_is_kept_at_the_shortest_period() {
    let mut port = port(2);
    port.start(100, 60);
    assert!(port.wait_for_data_ready(6200));
    assert_eq!(port.bench.converter_faults(), [""; 0]);
    assert_eq!(port.bench.scans().len(), 60);
}

#[test]
fn a_simulated_board_moves_on_with_each_scan() {
    let mut random = Random::new(3);
    let held = Rc::new(Cell::new([0; 4]));
    let inputs = Rc::clone(&held);
    let mut bench = Bench::new(Scale::Board, 3, move |channel| inputs.get()[channel]);
    bench.at_each_pass(move || held.set(core::array::from_fn(|_| random.counts())));
    let mut port = Port::new(bench, Timing::FASTEST, 3);
    port.start(100, 4);
    assert!(port.wait_for_data_ready(500));
    let mut again = Random::new(3);
    let taken: Vec<[u16; 4]> = (0..4).map(|_| core::array::from_fn(|_| again.counts())).collect();
    assert_eq!(scans(&port.read_set(4), 4), Some(taken));
}
