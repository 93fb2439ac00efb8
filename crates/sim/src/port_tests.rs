use super::*;
use crate::spi::eight_clocks;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

fn exchange(port: &mut Port, byte: u8) -> u8 {
    eight_clocks(byte, |bit| port.clock(bit))
}

/// Does a transfer and gives what came back after the two head bytes, as words.
fn read(port: &mut Port, address: u8, words: usize) -> Vec<u32> {
    port.select();
    exchange(port, address);
    exchange(port, 0);
    let words = (0..words).map(|_| u32::from_be_bytes([0; 4].map(|zero: u8| exchange(port, zero)))).collect();
    port.deselect();
    words
}

/// The bytes of a write, its CRC by [`crc`].
fn frame(address: u8, word: u32) -> [u8; 10] {
    let [a, b, c, d] = word.to_be_bytes();
    let [e, f, g, h] = crc(&[0x80 | address, 0, a, b, c, d]).to_be_bytes();
    [0x80 | address, 0, a, b, c, d, e, f, g, h]
}

fn send(port: &mut Port, bytes: &[u8]) {
    port.select();
    bytes.iter().for_each(|&byte| _ = exchange(port, byte));
    port.deselect();
}

fn write(port: &mut Port, address: u8, word: u32) {
    send(port, &frame(address, word));
}

/// CRC-32/MPEG-2 bit by bit.
fn crc(bytes: &[u8]) -> u32 {
    let bits = bytes.iter().flat_map(|byte| (0..8).rev().map(move |place| u32::from(byte >> place & 1)));
    bits.fold(u32::MAX, |crc, bit| if (crc >> 31) ^ bit == 1 { crc << 1 ^ 0x04C1_1DB7 } else { crc << 1 })
}

fn crc_of_words(words: &[u32]) -> u32 {
    crc(&words.iter().flat_map(|word| word.to_be_bytes()).collect::<Vec<u8>>())
}

/// A port that runs with a set length.
fn running(length: u32) -> Port {
    let mut port = Port::new();
    write(&mut port, 0x04, length);
    write(&mut port, 0x02, RUN);
    port
}

/// Scans with samples that tell scan and channel.
fn scan(port: &mut Port, scans: core::ops::Range<u16>) -> Vec<u32> {
    scans.filter_map(|k| port.push([10 * k, 10 * k + 1, 10 * k + 2, 16_383 - k])).collect()
}

fn status(port: &mut Port) -> u32 {
    read(port, 0x05, 1)[0]
}

#[test]
fn the_registers_read_as_at_reset() {
    assert_eq!(read(&mut Port::new(), 0, 8), [0x5A52_4151, 0x0002_0002, 0, 3000, 500, 0, 1, 0]);
}

#[test]
fn settings_out_of_range_and_reserved_addresses_ignore_writes() {
    let mut port = Port::new();
    for (address, word) in [
        (0, 1),
        (1, 2),
        (3, 99),
        (3, 1_000_001),
        (4, 513),
        (4, 0),
        (5, 7),
        (6, 0),
        (6, 7),
        (6, 32),
        (7, 7),
        (0x10, 1),
        (0x7F, 7),
    ] {
        write(&mut port, address, word);
    }
    assert_eq!(read(&mut port, 0, 8), [0x5A52_4151, 0x0002_0002, 0, 3000, 500, 0, 1, 0]);
    write(&mut port, 0x03, 100);
    write(&mut port, 0x04, 512);
    assert_eq!(read(&mut port, 3, 2), [100, 512]);
    write(&mut port, 0x06, 16);
    assert_eq!(read(&mut port, 0x06, 1), [1], "100 us have room for no more");
    for (period_us, passes) in [(1600, 16), (1599, 8), (400, 4), (399, 2)] {
        write(&mut port, 0x03, period_us);
        assert_eq!(read(&mut port, 0x06, 1), [passes]);
    }
    assert_eq!(read(&mut port, 0x7E, 4), [0; 4]);
    assert_eq!(read(&mut port, 0x0F, 3), [0; 3], "a read that runs into the burst's address does not start it");
}

/// The CRCs are zlib's, which has the same polynomial the other way round:
///
///     python3 -c 'import sys, zlib
///     turn = lambda number, bits: int(format(number, f"0{bits}b")[::-1], 2)
///     turned = bytes(turn(byte, 8) for byte in bytes.fromhex(sys.argv[1]))
///     print(hex(turn(zlib.crc32(turned) ^ 0xFFFFFFFF, 32)))' 830000000BB8
#[test]
fn a_write_is_known_by_a_crc_that_is_not_our_own() {
    let mut port = Port::new();
    write(&mut port, 0x03, 200);
    send(&mut port, &[0x83, 0, 0, 0, 0x0B, 0xB8, 0xD1, 0x5C, 0xED, 0x6E]);
    send(&mut port, &[0x84, 0, 0, 0, 0x01, 0x2C, 0x8C, 0x27, 0x5F, 0x19]);
    assert_eq!(read(&mut port, 3, 2), [3000, 300]);
}

#[test]
fn a_write_takes_effect_as_chip_select_rises_after_exactly_its_bits() {
    for bits in 0..200 {
        let mut port = Port::new();
        let bytes = frame(0x04, 300);
        port.select();
        for bit in 0..bits {
            port.clock(bytes.get(bit / 8).is_some_and(|byte| byte << (bit % 8) & 0x80 != 0));
            assert_eq!(port.written.set_length, 500, "chip select is still low");
        }
        port.deselect();
        assert_eq!(port.written.set_length, if bits == 80 { 300 } else { 500 }, "{bits} bits");
    }
}

#[test]
fn two_words_in_one_write_are_none() {
    let mut port = Port::new();
    let head_and_words = [0x83, 0, 0, 0, 0, 200, 0, 0, 0, 2];
    send(&mut port, &head_and_words);
    send(&mut port, &[head_and_words.as_slice(), &crc(&head_and_words).to_be_bytes()].concat());
    send(&mut port, &[frame(0x03, 200), frame(0x04, 2)].concat());
    assert_eq!(read(&mut port, 3, 2), [3000, 500]);
}

#[test]
fn a_write_with_one_or_two_bits_flipped_changes_nothing() {
    let mut port = Port::new();
    for (one, other) in (0..80).flat_map(|one| (one..80).map(move |other| (one, other))) {
        let mut bytes = frame(0x03, 200);
        bytes[one / 8] ^= 0x80 >> (one % 8);
        // The same bit twice would be none.
        if other != one {
            bytes[other / 8] ^= 0x80 >> (other % 8);
        }
        send(&mut port, &bytes);
        assert_eq!(read(&mut port, 2, 3), [0, 3000, 500], "bits {one} and {other}");
    }
}

/// A word for a register that takes it: CONTROL, SCAN_PERIOD or SET_LENGTH.
fn setting(random: &mut Xoshiro256PlusPlus) -> (usize, u32) {
    let register = random.random_range(0..3);
    (register, random.random_range([0..2, 100..1_000_001, 1..513][register].clone()))
}

/// Half of what a master does has its chip select cut at any bit, half has bits flipped.
#[test]
fn no_cut_of_chip_select_and_no_flipped_bit_changes_a_register_that_was_not_written() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(14);
    let (mut port, mut registers) = (Port::new(), [0, 3000, 500]);
    let (mut taken, mut refused) = (0, 0);
    for _ in 0..100_000 {
        let (register, word) = setting(&mut random);
        let is_write = random.random();
        let mut bytes = match random.random() {
            _ if is_write => frame([2, 3, 4][register], word).to_vec(),
            true => [[0, 1, 2, 3, 4, 5][random.random_range(0..6)], 0, 0, 0, 0, 0].to_vec(),
            false => [[SET].as_slice(), &[0; 65]].concat(),
        };
        let bits = 8 * bytes.len();
        let flipped = if random.random() { random.random_range(1..5) } else { 0 };
        let whole = bytes.clone();
        for bit in (0..flipped).map(|_| random.random_range(0..bits)).collect::<Vec<_>>() {
            bytes[bit / 8] ^= 0x80 >> (bit % 8);
        }
        let cut: Option<usize> = random.random::<bool>().then(|| random.random_range(1..bits));
        let back = cut.map(|cut| cut + random.random_range(0..16));
        port.select();
        for bit in 0..bits {
            if Some(bit) == cut {
                port.deselect();
            }
            if Some(bit) == back {
                port.select();
            }
            port.clock(bytes[bit / 8] << (bit % 8) & 0x80 != 0);
        }
        port.deselect();
        if is_write && cut.is_none() && bytes == whole {
            registers[register] = word;
            taken += 1;
        } else if is_write {
            refused += 1;
        }
        assert_eq!(read(&mut port, 2, 3), registers);
    }
    assert!(taken > 10_000 && refused > 30_000, "{taken} taken, {refused} refused");
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
    assert_eq!(burst[15], crc_of_words(&burst[..15]));
    assert_eq!(burst[16..20], [1, 2 << 16 | 16_383, 10 << 16 | 11, 12 << 16 | 16_382]);
    assert_eq!(burst[22], crc_of_words(&burst[16..22]));
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
    (0..2 + 15 * 4 + 3).for_each(|k| _ = exchange(&mut port, if k == 0 { SET } else { 0 }));
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
    assert_ne!(burst[15], crc_of_words(&burst[..15]));
    assert_eq!(scan(&mut port, 1..2), [0], "the read released nothing");
    assert!(port.data_ready());
}

#[test]
fn the_latest_scan_is_read_again_and_again_and_neither_torn_nor_a_read_of_the_set() {
    let mut port = running(2);
    assert_eq!(read(&mut port, SCAN, 5), [0; 5]);
    assert_ne!(!crc_of_words(&[0; 3]), 0, "no scan cannot pass for one");
    scan(&mut port, 0..3);
    let third = [2, 20 << 16 | 21, 22 << 16 | 16_381];
    for _ in 0..2 {
        assert_eq!(read(&mut port, SCAN, 5), [&third[..], &[!crc_of_words(&third), 0]].concat());
    }
    assert!(port.data_ready(), "the set waits on");
    let in_place_of_a_set = read(&mut port, SCAN, 16);
    assert_ne!(in_place_of_a_set[15], crc_of_words(&in_place_of_a_set[..15]), "what follows it makes no set of it");
    // A scan and a set become full while it is read: the one that is being read stays, and neither set is lost.
    read(&mut port, SET, 16);
    port.select();
    (0..5).for_each(|_| _ = exchange(&mut port, SCAN));
    scan(&mut port, 3..6);
    let rest: Vec<u8> = (0..13).map(|_| exchange(&mut port, 0)).collect();
    port.deselect();
    let whole = [&third[..], &[!crc_of_words(&third)]].concat();
    assert_eq!(rest, whole.iter().flat_map(|word| word.to_be_bytes()).collect::<Vec<u8>>()[3..]);
    assert_eq!(read(&mut port, SCAN, 1), [5]);
    assert_eq!(read(&mut port, 0x1F, 3), [0; 3], "a read that runs into its address does not start it");
}

#[test]
fn scans_are_counted_from_restart_on_whatever_becomes_of_their_sets() {
    let mut port = running(2);
    scan(&mut port, 0..7);
    write(&mut port, 0x02, 0);
    write(&mut port, 0x02, RUN);
    scan(&mut port, 7..8);
    assert_eq!(read(&mut port, SCAN, 1), [7], "a stop drops a set and no number");
    write(&mut port, 0x02, RUN | RESTART);
    assert_eq!(read(&mut port, SCAN, 4), [0; 4]);
    scan(&mut port, 8..9);
    assert_eq!(read(&mut port, SCAN, 2), [0, 80 << 16 | 81]);
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
    exchange(&mut port, SET);
    exchange(&mut port, 0);
    let mut burst = Vec::new();
    for word in 0..21 {
        burst.push(u32::from_be_bytes([0; 4].map(|zero: u8| exchange(&mut port, zero))));
        if word == 5 {
            assert_eq!(scan(&mut port, 2..4), [1]);
        }
    }
    port.deselect();
    assert_eq!(burst[..3], [0, 2 << 16, 0]);
    assert_eq!((burst[15], burst[20]), (crc_of_words(&burst[..15]), crc_of_words(&burst[16..20])));
    assert_eq!(burst[16..20], [1, 2 << 16 | 16_383, 10 << 16 | 11, 12 << 16 | 16_382]);
    assert_eq!(status(&mut port), 1 << 16);
    scan(&mut port, 4..6);
    assert_eq!(read(&mut port, SET, 3), [2, 2 << 16 | 1, 1]);
}

#[test]
fn settings_are_taken_up_at_the_start_of_a_set() {
    let mut port = running(3);
    scan(&mut port, 0..1);
    write(&mut port, 0x03, 500);
    write(&mut port, 0x04, 2);
    assert_eq!(read(&mut port, 3, 2), [500, 2]);
    assert_eq!((scan(&mut port, 1..2), port.scan_period_ns()), (vec![], 3_000_000));
    assert_eq!((scan(&mut port, 2..3), port.scan_period_ns()), (vec![0], 500_000));
    assert_eq!(scan(&mut port, 3..5), [1]);
}

#[test]
fn clearing_run_drops_the_set_being_filled_and_keeps_the_one_that_waits() {
    let mut port = running(2);
    scan(&mut port, 0..3);
    write(&mut port, 0x02, 0);
    assert!(!port.running() && port.data_ready());
    write(&mut port, 0x02, RUN);
    assert_eq!(scan(&mut port, 10..11), Vec::<u32>::new());
    assert_eq!(read(&mut port, SET, 16)[0], 0);
    assert_eq!(scan(&mut port, 11..12), [1]);
    assert_eq!(read(&mut port, SET, 17)[16] >> 16, 100);
}

#[test]
fn restart_drops_all_banks_and_zeroes_the_counts_and_reads_back_0() {
    let mut port = running(2);
    scan(&mut port, 0..7);
    write(&mut port, 0x02, RUN | RESTART);
    assert_eq!(read(&mut port, 0x02, 1), [RUN]);
    assert_eq!(status(&mut port), 0);
    assert_eq!(scan(&mut port, 7..9), [0]);
    assert_eq!(read(&mut port, SET, 3), [0, 2 << 16, 0]);
}
