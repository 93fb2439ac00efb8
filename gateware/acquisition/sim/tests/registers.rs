//! Every register of docs/acquisition-port.md, and what transfers do.

#![allow(clippy::unwrap_used)] // All of it is a test.

use zerorate_gateware::{Bench, Disturbance, Head, Port, Random, Scale, Timing, checked, head, scans};

const CONTROL: u8 = 0x02;
const SCAN_PERIOD: u8 = 0x03;
const SET_LENGTH: u8 = 0x04;
const STATUS: u8 = 0x05;
const SET: u8 = 0x10;
const AT_RESET: [u32; 8] = [0x5A52_4151, 0x0001_0000, 0, 3000, 500, 0, 0, 0];
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
        port.write(SCAN_PERIOD, &[good]);
        assert_eq!(port.read(SCAN_PERIOD, 1), [good]);
        for bad in [0, 99, 1_000_001, 1 << 20, 1 << 31, (1 << 20) + 3000, u32::MAX] {
            port.write(SCAN_PERIOD, &[bad]);
            assert_eq!(port.read(SCAN_PERIOD, 1), [good], "{bad}");
        }
    }
    for good in [1, 2, 255, 511, 512] {
        port.write(SET_LENGTH, &[good]);
        assert_eq!(port.read(SET_LENGTH, 1), [good]);
        for bad in [0, 513, 1024, (1 << 10) + 5, 1 << 31, u32::MAX] {
            port.write(SET_LENGTH, &[bad]);
            assert_eq!(port.read(SET_LENGTH, 1), [good], "{bad}");
        }
    }
}

#[test]
fn reserved_and_read_only_addresses_ignore_writes_and_read_0() {
    let mut port = port(2, Timing::QUICK);
    port.write(0x00, &[1, 2]);
    port.write(STATUS, &[u32::MAX; 20]);
    port.write(SET, &[u32::MAX; 3]);
    // Were the address to come round after 0x7F, the last of these would be settings.
    port.write(0x7E, &[200; 8]);
    port.write(0x0E, &[200; 8]);
    for address in 0x11..=0x7F {
        port.write(address, &[1]);
        assert_eq!(port.read(address, 2), [0, 0], "{address:#x}");
    }
    assert_eq!(port.read(0, 8), AT_RESET);
    assert_eq!(port.read(6, 20), [0; 20], "a read that runs into the burst's address does not start it");
    assert_eq!(port.read(0x7E, 12), [0; 12], "nor does one come round to the registers");
}

#[test]
fn writing_one_register_after_another_in_one_transfer_goes_up_by_one_a_word() {
    let mut port = port(3, Timing::FASTEST);
    port.write(CONTROL, &[0, 200, 7, 99]);
    assert_eq!(port.read(CONTROL, 4), [0, 200, 7, 0]);
}

#[test]
fn a_part_of_a_word_is_dropped_and_a_whole_one_takes_effect_at_its_last_bit() {
    for bits in 0..32 {
        let mut port = port(bits, Timing::QUICK);
        port.select();
        let _ = [0x80 | SET_LENGTH, 0].map(|byte| port.byte(byte));
        // 300, cut short.
        for (index, byte) in [0, 0, 1, 44].into_iter().enumerate() {
            let count = bits.saturating_sub(8 * u32::try_from(index).unwrap()).min(8);
            port.bits(byte, count);
        }
        port.deselect();
        assert_eq!(port.read(SET_LENGTH, 1), [500], "{bits} bits");
    }
    let mut port = port(99, Timing::QUICK);
    port.write(SET_LENGTH, &[1]);
    port.select();
    let _ = [0x80 | CONTROL, 0, 0, 0, 0, 1].map(|byte| port.byte(byte));
    // Chip select stays low, and the set is filled.
    assert!(port.wait_for_data_ready(SOON));
    port.deselect();
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
    port.write(SCAN_PERIOD, &[200, 2]);
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
        port.write(CONTROL, &[0]);
        assert_eq!(port.read(CONTROL, 1), [0]);
        let first = samples_of(&port, 0..2);
        // In the last of these the second set may just have been full: then it is the one that waits.
        port.bench.pass(port.bench.period_ps(10_000));
        assert!(port.bench.scans().len() < 6, "it scans no more");
        assert!(port.bench.data_ready());
        port.write(CONTROL, &[1]);
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
    port.write(CONTROL, &[1]);
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
        port.write(CONTROL, &[0b11]);
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
    port.write(CONTROL, &[0b10]);
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
