//! Resets and glitches at any moment: the block delivers the next whole set.

#![allow(clippy::unwrap_used, clippy::cast_possible_truncation)] // All of it is a test, and its numbers are small.

use zerorate_gateware::{Bench, Disturbance, Head, Port, Ps, Random, Scale, Timing, head, scans};

const CONTROL: u8 = 0x02;
const STATUS: u8 = 0x05;
const SET: u8 = 0x10;

/// One clock of the block.
const CLOCK_PS: Ps = 41_666;

fn bench(seed: u32) -> Bench {
    let mut samples = Random::new(u64::from(seed));
    Bench::new(Scale::Fast, seed, move |_| samples.counts())
}

/// A burst that has its CRCs is what the A/D delivered, whatever happened to it.
fn check(port: &Port, burst: &[u32], length: usize) -> Option<Head> {
    let found = head(burst)?;
    let first = found.number as usize * length;
    let taken: Vec<[u16; 4]> = port.bench.scans()[first..first + length].iter().map(|scan| scan.samples).collect();
    assert_eq!(found, Head::of(found.number, found.lost_before, found.lost, &taken));
    if let Some(samples) = scans(burst, length) {
        assert_eq!(samples, taken);
    }
    Some(found)
}

/// Reads the way that a disturbance may spoil: nothing is expected of what comes.
fn disturbed_read(port: &mut Port, address: u8, words: usize) -> Vec<u32> {
    port.select();
    port.byte(address);
    port.byte(0);
    let words = (0..words).map(|_| port.word()).collect();
    port.deselect();
    words
}

#[test]
fn after_a_glitch_on_any_spi_pin_at_any_moment_of_a_read_the_next_whole_set_comes() {
    const LENGTH: usize = 3;
    let mut random = Random::new(7);
    let mut spoilt = 0;
    for seed in 0..20 {
        let timing = [Timing::FASTEST, Timing::QUICK][seed as usize % 2];
        let mut port = Port::new(bench(seed), timing, u64::from(seed));
        port.start(700, LENGTH as u32);
        for _ in 0..150 {
            assert!(port.wait_for_data_ready(5000));
            let what = [Disturbance::Sck, Disturbance::ChipSelect, Disturbance::Mosi][random.between(0, 2) as usize];
            // A whole burst at 10 MHz takes 75 us. From a spike to longer than a clock of the block.
            let (in_ps, for_ps) = (random.between(0, 80_000_000), random.between(1_000, 300_000));
            port.bench.disturb(what, in_ps, for_ps);
            let status = disturbed_read(&mut port, STATUS, 1);
            let burst = disturbed_read(&mut port, SET, 16 + 2 * LENGTH + 1);
            let whole = check(&port, &burst, LENGTH).is_some() && scans(&burst, LENGTH).is_some();
            spoilt += u32::from(status[0] & 1 == 0 || !whole);
            // Undisturbed, the next is whole.
            port.bench.pass(1_000_000);
            assert_eq!(port.read(CONTROL, 3), [1, 700, LENGTH as u32], "no read is a write, however it is cut");
            assert!(port.wait_for_data_ready(5000));
            let burst = port.read(SET, 16 + 2 * LENGTH + 1);
            assert!(check(&port, &burst, LENGTH).is_some() && scans(&burst, LENGTH).is_some());
        }
        assert_eq!(port.bench.converter_faults(), [""; 0]);
    }
    assert!(spoilt > 500, "{spoilt} reads were spoilt: too few for this to mean anything");
    println!("{spoilt} of 3000 reads were spoilt, and no register changed");
}

#[test]
fn chip_select_s_rise_at_any_bit_leaves_the_next_whole_set() {
    const LENGTH: usize = 2;
    let bits_of_a_burst = 16 + 32 * (16 + 2 * 2 + 1);
    let mut port = Port::new(bench(3), Timing::FASTEST, 3);
    port.start(800, LENGTH as u32);
    for bits in 0..=bits_of_a_burst {
        assert!(port.wait_for_data_ready(5000));
        port.select();
        for byte in 0..bits / 8 {
            port.byte(if byte == 0 { SET } else { 0 });
        }
        port.bits(if bits < 8 { SET } else { 0 }, bits % 8);
        port.deselect();
        assert!(port.wait_for_data_ready(5000));
        let burst = port.read(SET, 16 + 2 * LENGTH + 1);
        assert!(check(&port, &burst, LENGTH).is_some() && scans(&burst, LENGTH).is_some(), "after {bits} bits");
    }
}

#[test]
fn clocks_while_chip_select_is_high_are_none_of_the_port_s() {
    let mut port = Port::new(bench(4), Timing::FASTEST, 4);
    port.start(800, 2);
    assert!(port.wait_for_data_ready(5000));
    for clock in 0..500 {
        port.bench.drive_spi(true, clock % 2 == 0, clock % 3 == 0);
        port.bench.pass(60_000);
    }
    port.bench.drive_spi(true, false, false);
    let burst = port.read_set(2);
    assert!(check(&port, &burst, 2).is_some());
}

#[test]
fn a_reset_at_any_clock_leaves_a_block_that_delivers_the_next_whole_set() {
    const LENGTH: usize = 2;
    let mut random = Random::new(11);
    let mut port = Port::new(bench(5), Timing::FASTEST, 5);
    // From before the set is full to after the end of its burst, 64 us at 10 MHz, every clock once.
    for clock in 0..2000 {
        port.start(100, LENGTH as u32);
        port.bench.pass(port.bench.period_ps(150));
        port.bench.disturb(Disturbance::Reset, clock * CLOCK_PS, random.between(1, 5) * CLOCK_PS);
        port.bench.pass(port.bench.period_ps(60));
        disturbed_read(&mut port, SET, 16 + 2 * LENGTH + 1);
        port.bench.pass(200 * CLOCK_PS);
        // Whatever was under way: the master's own start is all it takes.
        port.start(100, LENGTH as u32);
        assert!(port.wait_for_data_ready(1000), "reset at clock {clock}");
        let burst = port.read_set(LENGTH);
        assert!(check(&port, &burst, LENGTH).is_some(), "reset at clock {clock}");
    }
}

#[test]
fn a_restart_at_any_clock_of_a_scan_starts_with_a_whole_scan() {
    let mut port = Port::new(bench(6), Timing::FASTEST, 6);
    port.start(100, 2);
    // Longer than a scan and its period, by every clock.
    for clock in 0..310 {
        port.bench.pass(port.bench.period_ps(250) + clock * CLOCK_PS);
        let length = 1 + clock as usize % 4;
        port.start(100, length as u32);
        assert!(port.wait_for_data_ready(1000));
        let burst = port.read_set(length);
        assert!(check(&port, &burst, length).is_some());
    }
    assert_eq!(port.bench.converter_faults(), [""; 0]);
}

#[test]
fn a_write_with_a_glitch_on_any_spi_pin_is_taken_whole_or_not_at_all() {
    let mut random = Random::new(13);
    let (mut taken, mut refused) = (0, 0);
    for seed in 0..20 {
        let mut port = Port::new(bench(seed), [Timing::FASTEST, Timing::QUICK][seed as usize % 2], u64::from(seed));
        let mut registers = vec![0, 3000, 500];
        for _ in 0..150 {
            let what = [Disturbance::Sck, Disturbance::ChipSelect, Disturbance::Mosi][random.between(0, 2) as usize];
            // A write at 10 MHz takes 8 us.
            port.bench.disturb(what, random.between(0, 9_000_000), random.between(1_000, 300_000));
            let register = random.between(1, 2) as usize;
            let word = random.between(100, 512) as u32;
            port.write(CONTROL + register as u8, word);
            port.bench.pass(10_000_000);
            let found = port.read(CONTROL, 3);
            let is_taken = found[register] == word;
            if is_taken {
                registers[register] = word;
            }
            assert_eq!(found, registers, "{what:?}");
            taken += u32::from(is_taken);
            refused += u32::from(!is_taken);
        }
        // Undisturbed, it is set up.
        port.start(100, 2);
        assert_eq!(port.read(CONTROL, 3), [1, 100, 2]);
        assert!(port.wait_for_data_ready(1000));
        let burst = port.read_set(2);
        assert!(check(&port, &burst, 2).is_some());
    }
    assert!(taken > 200 && refused > 500, "{taken} taken, {refused} refused: too few for this to mean anything");
    println!("of 3000 writes {taken} were taken whole, {refused} not at all");
}

#[test]
fn a_master_beyond_10_mhz_gets_no_wrong_set_that_looks_right() {
    const LENGTH: usize = 4;
    let mut refused = 0;
    for seed in 0..200 {
        let mut samples = Random::new(u64::from(seed));
        let bench = Bench::without_assertions(Scale::Fast, seed, move |_| samples.counts());
        // From 12 to 80 MHz.
        let too_fast = Timing { period_ps: (12_500, 80_000), around_ps: (10_000, 100_000), ..Timing::FASTEST };
        let mut port = Port::new(bench, too_fast, u64::from(seed));
        port.set_timing(Timing::FASTEST);
        port.start(900, LENGTH as u32);
        assert!(port.wait_for_data_ready(5000));
        port.set_timing(too_fast);
        let burst = disturbed_read(&mut port, SET, 16 + 2 * LENGTH + 1);
        refused += u32::from(check(&port, &burst, LENGTH).is_none());
        port.set_timing(Timing::FASTEST);
        port.bench.pass(1_000_000);
        assert!(port.wait_for_data_ready(5000));
        let burst = port.read_set(LENGTH);
        assert!(check(&port, &burst, LENGTH).is_some());
    }
    assert!(refused > 50, "{refused} of 200 refused by their CRC");
}
