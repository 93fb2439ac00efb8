//! At the board's own scale: real microseconds, and the A/D's data sheet.

#![allow(clippy::unwrap_used)] // All of it is a test.

use zerorate_gateware::{Bench, Head, Port, Random, Scale, Timing, head};

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
