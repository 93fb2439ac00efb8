//! Every register of docs/acquisition-port.md, and what transfers do.

#![allow(clippy::unwrap_used)] // All of it is a test.

use zerorate_gateware::{Bench, Disturbance, Head, Port, Random, Scale, Timing, checked, head, scans, written};

const CONTROL: u8 = 0x02;
const SCAN_PERIOD: u8 = 0x03;
const SET_LENGTH: u8 = 0x04;
const STATUS: u8 = 0x05;
const OVERSAMPLING: u8 = 0x06;
const SET: u8 = 0x10;
const AT_RESET: [u32; 8] = [0x5A52_4151, 0x0002_0002, 0, 3000, 500, 0, 1, 0];
const READY: u32 = 1;
const OVERRUN: u32 = 2;
/// A set of a few scans is there in less, microseconds.
const SOON: u64 = 10_000;

fn port(seed: u32, timing: Timing) -> Port {
    let mut samples = Random::new(u64::from(seed));
    Port::new(Bench::new(Scale::Fast, seed, move |_| samples.counts()), timing, u64::from(seed))
}

fn samples_of(port: &Port, range: core::ops::Range<usize>) -> Vec<[u16; 4]> {
    port.bench.scans()[range].iter().map(|scan| scan.samples).collect()
}

#[test]
fn the_registers_read_as_at_reset_at_any_clock() {
    for seed in 0..200 {
        for timing in [Timing::FASTEST, Timing::QUICK, Timing::UNEVEN] {
            let mut port = port(seed, timing);
            assert_eq!(port.read(0, 8), AT_RESET);
            for (address, value) in (0..).zip(AT_RESET) {
                assert_eq!(port.read(address, 1), [value]);
            }
            assert!(!port.bench.data_ready());
        }
    }
}

#[test]
fn settings_within_their_range_read_back_and_others_are_ignored() {
    let mut port = port(1, Timing::QUICK);
    for good in [100, 101, 3000, 65_536, 999_999, 1_000_000] {
        port.write(SCAN_PERIOD, good);
        assert_eq!(port.read(SCAN_PERIOD, 1), [good]);
        for bad in [0, 99, 1_000_001, 1 << 20, 1 << 31, (1 << 20) + 3000, u32::MAX] {
            port.write(SCAN_PERIOD, bad);
            assert_eq!(port.read(SCAN_PERIOD, 1), [good], "{bad}");
        }
    }
    for good in [1, 2, 255, 511, 512] {
        port.write(SET_LENGTH, good);
        assert_eq!(port.read(SET_LENGTH, 1), [good]);
        for bad in [0, 513, 1024, (1 << 10) + 5, 1 << 31, u32::MAX] {
            port.write(SET_LENGTH, bad);
            assert_eq!(port.read(SET_LENGTH, 1), [good], "{bad}");
        }
    }
    for good in [1, 2, 4, 8, 16] {
        port.write(OVERSAMPLING, good);
        assert_eq!(port.read(OVERSAMPLING, 1), [good]);
        for bad in [0, 3, 5, 15, 17, 32, 1 << 31, (1 << 16) + 2, u32::MAX] {
            port.write(OVERSAMPLING, bad);
            assert_eq!(port.read(OVERSAMPLING, 1), [good], "{bad}");
        }
    }
}

#[test]
fn oversampling_is_no_more_than_the_period_has_room_for_and_comes_back_with_a_longer_one() {
    let mut port = port(14, Timing::QUICK);
    port.write(OVERSAMPLING, 16);
    for (period_us, most) in
        [(1599, 8), (800, 8), (799, 4), (400, 4), (399, 2), (200, 2), (199, 1), (100, 1), (1600, 16)]
    {
        port.write(SCAN_PERIOD, period_us);
        assert_eq!(port.read(OVERSAMPLING, 1), [most], "{period_us} us");
    }
    port.write(OVERSAMPLING, 4);
    assert_eq!(port.read(OVERSAMPLING, 1), [4], "and no more than was asked for");
}

#[test]
fn reserved_and_read_only_addresses_ignore_writes_and_read_0() {
    let mut port = port(2, Timing::QUICK);
    for address in [0x00, 0x01, STATUS] {
        port.write(address, 200);
        port.write(address, u32::MAX);
    }
    // Their low bits are those of settings, too.
    for address in 0x07..=0x7F {
        port.write(address, 200);
        assert_eq!(port.read(address, 1), [0], "{address:#x}");
    }
    assert_eq!(port.read(0, 8), AT_RESET);
    assert_eq!(port.read(7, 20), [0; 20], "a read that runs into the burst's address does not start it");
    assert_eq!(port.read(0x7E, 12), [0; 12], "nor does one come round to the registers");
}

/// The CRCs are zlib's, by the command in zerorate-sim's port_tests.rs.
#[test]
fn a_write_is_known_by_a_crc_that_is_not_our_own() {
    let mut port = port(3, Timing::FASTEST);
    for bytes in
        [[0x83, 0, 0, 0, 0x0B, 0xB8, 0xD1, 0x5C, 0xED, 0x6E], [0x84, 0, 0, 0, 0x01, 0x2C, 0x8C, 0x27, 0x5F, 0x19]]
    {
        port.write(SCAN_PERIOD, 200);
        send(&mut port, &bytes);
    }
    assert_eq!(port.read(CONTROL, 4), [0, 200, 300, 0]);
    send(&mut port, &[0x83, 0, 0, 0, 0x0B, 0xB8, 0xD1, 0x5C, 0xED, 0x6E]);
    assert_eq!(port.read(SCAN_PERIOD, 1), [3000]);
}

fn send(port: &mut Port, bytes: &[u8]) {
    port.select();
    bytes.iter().for_each(|&byte| _ = port.byte(byte));
    port.deselect();
}

#[test]
fn a_write_takes_effect_as_chip_select_rises_after_exactly_its_bits() {
    for bits in 0..=200 {
        for timing in [Timing::FASTEST, Timing::QUICK] {
            let mut port = port(bits, timing);
            port.select();
            for (byte, from) in written(SET_LENGTH, 300).into_iter().chain([0; 15]).zip((0..).step_by(8)) {
                port.bits(byte, bits.saturating_sub(from).min(8));
            }
            port.deselect();
            assert_eq!(port.read(SET_LENGTH, 1), [if bits == 80 { 300 } else { 500 }], "{bits} bits");
        }
    }
    let mut port = port(99, Timing::QUICK);
    port.write(SET_LENGTH, 1);
    port.select();
    written(CONTROL, 1).into_iter().for_each(|byte| _ = port.byte(byte));
    assert!(!port.wait_for_data_ready(SOON), "chip select stays low");
    port.deselect();
    assert!(port.wait_for_data_ready(SOON));
}

#[test]
fn two_words_in_one_write_are_none() {
    let mut port = port(3, Timing::QUICK);
    send(&mut port, &[0x83, 0, 0, 0, 0, 200, 0, 0, 0, 2]);
    send(&mut port, &[written(SCAN_PERIOD, 200), written(SET_LENGTH, 2)].concat());
    assert_eq!(port.read(CONTROL, 3), [0, 3000, 500]);
}

#[test]
fn a_write_with_one_or_two_bits_flipped_changes_nothing() {
    let mut port = port(13, Timing::QUICK);
    for (one, other) in (0..80).flat_map(|one| (one..80).map(move |other| (one, other))) {
        let mut bytes = written(SCAN_PERIOD, 200);
        bytes[one / 8] ^= 0x80 >> (one % 8);
        // The same bit twice would be none.
        if other != one {
            bytes[other / 8] ^= 0x80 >> (other % 8);
        }
        send(&mut port, &bytes);
        assert_eq!(port.read(CONTROL, 3), [0, 3000, 500], "bits {one} and {other}");
    }
}

#[test]
fn a_set_and_its_header_and_both_crcs_come_in_one_burst_and_zeros_after_it() {
    let mut port = port(4, Timing::UNEVEN);
    port.start(1000, 3);
    assert!(port.wait_for_data_ready(SOON));
    assert_eq!(port.read(STATUS, 1), [READY]);
    let burst = port.read(SET, 16 + 6 + 1 + 5);
    let taken = samples_of(&port, 0..3);
    assert_eq!(head(&burst), Some(Head::of(0, false, 0, &taken)));
    assert_eq!(scans(&burst, 3), Some(taken));
    assert_eq!(burst[23..], [0; 5]);
}

#[test]
fn with_no_set_waiting_all_words_read_0_which_is_not_their_crc() {
    let mut port = port(5, Timing::QUICK);
    let burst = port.read(SET, 24);
    assert_eq!(burst, [0; 24]);
    assert_eq!(checked(&burst[..16]), None);
}

#[test]
fn a_set_that_fills_during_a_burst_of_nothing_waits_on() {
    let mut port = port(6, Timing::FASTEST);
    // The set is full after 100 us; the burst takes 130.
    port.start(800, 1);
    let burst = port.read(SET, 40);
    assert_eq!(burst, [0; 40]);
    port.bench.pass(1_000_000);
    assert_eq!(port.bench.scans().len(), 1);
    assert!(port.bench.data_ready(), "not released by a burst that did not send it");
}

#[test]
fn a_set_is_released_by_word_15_sent_whole_and_not_by_a_bit_less() {
    for bits in (0..16 * 32 + 16).step_by(7).chain([15 * 32 + 16 + 31]) {
        let mut port = port(bits, Timing::QUICK);
        port.start(100_000, 1);
        assert!(port.wait_for_data_ready(200_000));
        port.select();
        port.byte(SET);
        port.byte(0);
        let bits = bits.min(15 * 32 + 31);
        (0..bits / 8).for_each(|_| _ = port.byte(0));
        port.bits(0, bits % 8);
        port.deselect();
        port.bench.pass(1_000_000);
        assert!(port.bench.data_ready(), "after {bits} bits");
        let burst = port.read(SET, 16);
        assert_eq!(head(&burst), Some(Head::of(0, false, 0, &samples_of(&port, 0..1))));
        port.bench.pass(1_000_000);
        assert!(!port.bench.data_ready());
        assert_eq!(port.read(STATUS, 1), [0]);
    }
}

#[test]
fn settings_are_taken_up_at_the_start_of_a_set() {
    let mut port = port(7, Timing::FASTEST);
    port.start(500, 3);
    port.bench.pass(port.bench.period_ps(700));
    port.write(SCAN_PERIOD, 200);
    port.write(SET_LENGTH, 2);
    assert_eq!(port.read(SCAN_PERIOD, 2), [200, 2]);
    let mut lengths = Vec::new();
    for _ in 0..3 {
        assert!(port.wait_for_data_ready(SOON));
        lengths.push(head(&port.read(SET, 16)).unwrap().length);
    }
    assert_eq!(lengths, [3, 2, 2]);
    let begun: Vec<u64> = port.bench.scans().iter().map(|scan| scan.began_ps).collect();
    let periods: Vec<u64> = begun.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let (slow, fast) = (port.bench.period_ps(500), port.bench.period_ps(200));
    assert_eq!(periods[..6], [slow, slow, fast, fast, fast, fast]);
}

#[test]
fn clearing_run_drops_the_set_being_filled_and_keeps_the_one_that_waits() {
    for pause_us in (0..400).step_by(13) {
        let mut port = port(8, Timing::FASTEST);
        port.start(200, 2);
        assert!(port.wait_for_data_ready(SOON));
        port.bench.pass(port.bench.period_ps(pause_us));
        let status = port.read(STATUS, 1)[0];
        port.write(CONTROL, 0);
        assert_eq!(port.read(CONTROL, 1), [0]);
        let first = samples_of(&port, 0..2);
        // In the last of these the second set may just have been full: then it is the one that waits.
        port.bench.pass(port.bench.period_ps(10_000));
        assert!(port.bench.scans().len() < 6, "it scans no more");
        assert!(port.bench.data_ready());
        port.write(CONTROL, 1);
        port.bench.count_scans();
        let kept = head(&port.read(SET, 16)).unwrap();
        if kept.number == 0 {
            assert_eq!((kept, status), (Head::of(0, false, 0, &first), READY));
        }
        assert!(port.wait_for_data_ready(SOON));
        let next = head(&port.read(SET, 16)).unwrap();
        assert_eq!(next, Head::of(kept.number + 1, false, kept.lost, &samples_of(&port, 0..2)));
    }
}

#[test]
fn writing_run_again_while_it_runs_changes_nothing() {
    let mut port = port(9, Timing::FASTEST);
    port.start(200, 3);
    port.bench.pass(port.bench.period_ps(450));
    port.write(CONTROL, 1);
    assert!(port.wait_for_data_ready(SOON));
    assert_eq!(port.bench.scans().len(), 3);
    assert_eq!(head(&port.read(SET, 16)), Some(Head::of(0, false, 0, &samples_of(&port, 0..3))));
}

#[test]
fn restart_drops_all_banks_and_zeroes_number_count_and_flag_and_reads_back_0() {
    for pause_us in (1000..1600).step_by(17) {
        let mut port = port(10, Timing::FASTEST);
        port.start(200, 2);
        port.bench.pass(port.bench.period_ps(pause_us));
        assert_ne!(port.read(STATUS, 1)[0] & OVERRUN, 0);
        port.write(CONTROL, 0b11);
        // A scan that begins before the restart is seen, at most five clocks after chip select, is dropped with its set.
        port.bench.pass(250_000);
        port.bench.count_scans();
        assert_eq!(port.read(CONTROL, 1), [1]);
        assert_eq!(port.read(STATUS, 1), [0]);
        assert!(!port.bench.data_ready());
        assert!(port.wait_for_data_ready(SOON));
        assert_eq!(head(&port.read(SET, 16)), Some(Head::of(0, false, 0, &samples_of(&port, 0..2))));
    }
}

#[test]
fn restart_without_run_leaves_it_stopped_and_empty() {
    let mut port = port(11, Timing::FASTEST);
    port.start(200, 2);
    assert!(port.wait_for_data_ready(SOON));
    port.write(CONTROL, 0b10);
    assert_eq!(port.read(CONTROL, 4), [0, 200, 2, 0]);
    assert!(!port.wait_for_data_ready(SOON));
    assert_eq!(port.read(SET, 16), [0; 16]);
}

#[test]
fn a_reset_puts_everything_back() {
    let mut port = port(12, Timing::FASTEST);
    port.start(200, 2);
    assert!(port.wait_for_data_ready(SOON));
    port.bench.disturb(Disturbance::Reset, 100_000, 100_000);
    port.bench.pass(1_000_000);
    assert_eq!(port.read(0, 8), AT_RESET);
    assert!(!port.bench.data_ready());
}

#[test]
fn a_release_is_not_missed_however_soon_chip_select_rises_after_the_last_bit() {
    for seed in 0..60 {
        let mut port = port(seed, Timing::QUICK);
        port.start(3000, 1);
        for after_ps in (1_000..50_000).step_by(7_000) {
            assert!(port.wait_for_data_ready(SOON));
            port.select();
            port.byte(SET);
            port.byte(0);
            (0..15).for_each(|_| _ = port.word());
            (0..3).for_each(|_| _ = port.byte(0));
            port.bits(0, 7);
            port.bench.pass(50_000);
            port.bench.drive_spi(false, true, false);
            port.bench.pass(after_ps);
            port.bench.drive_spi(true, true, false);
            port.bench.pass(20_000);
            port.bench.drive_spi(true, false, false);
            port.bench.pass(1_000_000);
            assert!(!port.bench.data_ready(), "{after_ps} ps after the last bit");
        }
    }
}
