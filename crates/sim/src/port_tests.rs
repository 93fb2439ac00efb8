use super::*;

/// Does a transfer and gives what came back after the two head bytes, as words.
fn read(port: &mut Port, address: u8, words: usize) -> Vec<u32> {
    port.select();
    port.exchange(address);
    port.exchange(0);
    let words = (0..words).map(|_| u32::from_be_bytes([0; 4].map(|zero: u8| port.exchange(zero)))).collect();
    port.deselect();
    words
}

fn write(port: &mut Port, address: u8, words: &[u32]) {
    port.select();
    port.exchange(0x80 | address);
    port.exchange(0);
    words.iter().flat_map(|word| word.to_be_bytes()).for_each(|byte| _ = port.exchange(byte));
    port.deselect();
}

/// A port that runs with a set length.
fn running(length: u32) -> Port {
    let mut port = Port::new();
    write(&mut port, 0x04, &[length]);
    write(&mut port, 0x02, &[RUN]);
    port
}

/// Scans with samples that tell scan and channel.
fn scan(port: &mut Port, scans: core::ops::Range<u16>) -> Vec<u32> {
    scans.filter_map(|k| port.push([10 * k, 10 * k + 1, 10 * k + 2, 16_383 - k])).collect()
}

/// CRC-32/MPEG-2 bit by bit, over words.
fn crc(words: &[u32]) -> u32 {
    let bits = words.iter().flat_map(|word| (0..32).rev().map(move |place| word >> place & 1));
    bits.fold(u32::MAX, |crc, bit| if (crc >> 31) ^ bit == 1 { crc << 1 ^ 0x04C1_1DB7 } else { crc << 1 })
}

fn status(port: &mut Port) -> u32 {
    read(port, 0x05, 1)[0]
}

#[test]
fn the_registers_read_as_at_reset() {
    assert_eq!(read(&mut Port::new(), 0, 8), [0x5A52_4151, 0x0001_0000, 0, 3000, 500, 0, 0, 0]);
}

#[test]
fn settings_out_of_range_and_reserved_addresses_ignore_writes() {
    let mut port = Port::new();
    write(&mut port, 0x00, &[1, 2, 0, 99, 513, 7, 7, 7]);
    write(&mut port, 0x03, &[1_000_001, 0]);
    assert_eq!(read(&mut port, 0, 8), [0x5A52_4151, 0x0001_0000, 0, 3000, 500, 0, 0, 0]);
    write(&mut port, 0x03, &[100, 512]);
    assert_eq!(read(&mut port, 3, 2), [100, 512]);
    write(&mut port, 0x10, &[1]);
    assert_eq!(read(&mut port, 0x7E, 4), [0; 4]);
    assert_eq!(read(&mut port, 0x0F, 3), [0; 3], "a read that runs into the burst's address does not start it");
}

#[test]
fn a_part_of_a_word_is_dropped_at_the_rise_of_chip_select() {
    let mut port = Port::new();
    port.select();
    [0x84, 0, 0, 0, 0].into_iter().for_each(|byte| _ = port.exchange(byte));
    port.deselect();
    assert_eq!(read(&mut port, 4, 1), [500]);
    port.select();
    [0x84, 0, 0, 0, 0, 9].into_iter().for_each(|byte| _ = port.exchange(byte));
    assert_eq!(port.written.set_length, 9, "the last bit is in, chip select is still low");
}

#[test]
fn the_burst_holds_number_length_sums_squares_samples_and_both_crcs() {
    let mut port = running(3);
    assert_eq!(scan(&mut port, 0..3), [0]);
    assert_eq!(status(&mut port), READY);
    let burst = read(&mut port, SET, 16 + 6 + 1 + 3);
    assert_eq!(burst[..3], [0, 3 << 16, 0]);
    assert_eq!(burst[3..7], [30, 33, 36, 3 * 16_383 - 3]);
    let square = |k: u64| (16_383 - k) * (16_383 - k);
    assert_eq!(burst[7..13], [0, 500, 0, 1 + 121 + 441, 0, 4 + 144 + 484]);
    assert_eq!(u64::from(burst[13]) << 32 | u64::from(burst[14]), square(0) + square(1) + square(2));
    assert_eq!(burst[15], crc(&burst[..15]));
    assert_eq!(burst[16..20], [1, 2 << 16 | 16_383, 10 << 16 | 11, 12 << 16 | 16_382]);
    assert_eq!(burst[22], crc(&burst[16..22]));
    assert_eq!(burst[23..], [0; 3]);
}

#[test]
fn squares_of_a_long_set_take_both_halves_of_their_64_bits() {
    let mut port = running(512);
    (0..512).for_each(|_| _ = port.push([16_383; 4]));
    let burst = read(&mut port, SET, 16);
    assert_eq!(u64::from(burst[7]) << 32 | u64::from(burst[8]), 512 * 16_383 * 16_383);
    assert_ne!(burst[7], 0);
}

#[test]
fn a_set_is_released_once_word_15_was_sent_whole_and_waits_on_otherwise() {
    let mut port = running(2);
    scan(&mut port, 0..2);
    let first = read(&mut port, SET, 15);
    assert!(port.data_ready());
    port.select();
    (0..2 + 15 * 4 + 3).for_each(|k| _ = port.exchange(if k == 0 { SET } else { 0 }));
    port.deselect();
    assert!(port.data_ready(), "three bytes of word 15 are not the whole");
    assert_eq!(read(&mut port, SET, 16)[..15], first);
    assert!(!port.data_ready());
}

#[test]
fn with_no_set_waiting_all_words_read_0_which_is_not_their_crc() {
    let mut port = running(2);
    scan(&mut port, 0..1);
    let burst = read(&mut port, SET, 20);
    assert_eq!(burst, [0; 20]);
    assert_ne!(burst[15], crc(&burst[..15]));
    assert_eq!(scan(&mut port, 1..2), [0], "the read released nothing");
    assert!(port.data_ready());
}

#[test]
fn an_unread_set_is_lost_to_the_newer_one_and_leaves_a_gap() {
    let mut port = running(2);
    assert_eq!(scan(&mut port, 0..6), [0, 1, 2]);
    assert_eq!(status(&mut port), 2 << 16 | OVERRUN | READY);
    let burst = read(&mut port, SET, 17);
    assert_eq!(burst[..3], [2, 2 << 16 | 1, 2]);
    assert_eq!(burst[16] >> 16, 40, "scan 4 is the newest set's first");
    assert_eq!(status(&mut port), 2 << 16, "released: no overrun since");
    scan(&mut port, 6..8);
    assert_eq!(read(&mut port, SET, 3), [3, 2 << 16, 2]);
}

#[test]
fn a_set_that_fills_while_the_other_is_read_is_lost_and_the_read_one_is_not_torn() {
    let mut port = running(2);
    scan(&mut port, 0..2);
    port.select();
    port.exchange(SET);
    port.exchange(0);
    let mut burst = Vec::new();
    for word in 0..21 {
        burst.push(u32::from_be_bytes([0; 4].map(|zero: u8| port.exchange(zero))));
        if word == 5 {
            assert_eq!(scan(&mut port, 2..4), [1]);
        }
    }
    port.deselect();
    assert_eq!(burst[..3], [0, 2 << 16, 0]);
    assert_eq!((burst[15], burst[20]), (crc(&burst[..15]), crc(&burst[16..20])));
    assert_eq!(burst[16..20], [1, 2 << 16 | 16_383, 10 << 16 | 11, 12 << 16 | 16_382]);
    assert_eq!(status(&mut port), 1 << 16);
    scan(&mut port, 4..6);
    assert_eq!(read(&mut port, SET, 3), [2, 2 << 16 | 1, 1]);
}

#[test]
fn settings_are_taken_up_at_the_start_of_a_set() {
    let mut port = running(3);
    scan(&mut port, 0..1);
    write(&mut port, 0x03, &[500, 2]);
    assert_eq!(read(&mut port, 3, 2), [500, 2]);
    assert_eq!((scan(&mut port, 1..2), port.scan_period_ns()), (vec![], 3_000_000));
    assert_eq!((scan(&mut port, 2..3), port.scan_period_ns()), (vec![0], 500_000));
    assert_eq!(scan(&mut port, 3..5), [1]);
}

#[test]
fn clearing_run_drops_the_set_being_filled_and_keeps_the_one_that_waits() {
    let mut port = running(2);
    scan(&mut port, 0..3);
    write(&mut port, 0x02, &[0]);
    assert!(!port.running() && port.data_ready());
    write(&mut port, 0x02, &[RUN]);
    assert_eq!(scan(&mut port, 10..11), Vec::<u32>::new());
    assert_eq!(read(&mut port, SET, 16)[0], 0);
    assert_eq!(scan(&mut port, 11..12), [1]);
    assert_eq!(read(&mut port, SET, 17)[16] >> 16, 100);
}

#[test]
fn restart_drops_all_banks_and_zeroes_the_counts_and_reads_back_0() {
    let mut port = running(2);
    scan(&mut port, 0..7);
    write(&mut port, 0x02, &[RUN | RESTART]);
    assert_eq!(read(&mut port, 0x02, 1), [RUN]);
    assert_eq!(status(&mut port), 0);
    assert_eq!(scan(&mut port, 7..9), [0]);
    assert_eq!(read(&mut port, SET, 3), [0, 2 << 16, 0]);
}
