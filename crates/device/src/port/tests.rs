use std::vec;
use std::vec::Vec;

use super::*;
use embedded_hal_mock::eh1::spi::{Mock, Transaction};

/// Bytes and their CRC, by another reading of the rule: bit by bit, as the document says.
fn with_crc(mut bytes: Vec<u8>) -> Vec<u8> {
    let mut register = u32::MAX;
    for bit in bytes.iter().flat_map(|byte| (0..8).rev().map(move |k| byte >> k & 1)) {
        let feedback = (register >> 31) ^ u32::from(bit);
        register = register << 1 ^ (feedback * 0x04C1_1DB7);
    }
    bytes.extend(register.to_be_bytes());
    bytes
}

/// A burst of two scans, in its two parts.
fn burst(number: u32, scans: &[[u16; 4]]) -> (Vec<u8>, Vec<u8>) {
    let mut words = vec![number, u32::try_from(scans.len()).unwrap() << 16, 0];
    let channel = |k: usize| scans.iter().map(move |scan| u64::from(scan[k]));
    words.extend((0..4).map(|k| u32::try_from(channel(k).sum::<u64>()).unwrap()));
    for k in 0..4 {
        let squares: u64 = channel(k).map(|s| s * s).sum();
        words.extend([u32::try_from(squares >> 32).unwrap(), (squares & 0xFFFF_FFFF).try_into().unwrap()]);
    }
    let head = with_crc(words.iter().flat_map(|w| w.to_be_bytes()).collect());
    (head, with_crc(scans.iter().flatten().flat_map(|s| s.to_be_bytes()).collect()))
}

fn word_read(address: u8, word: u32) -> Vec<Transaction<u8>> {
    vec![
        Transaction::transaction_start(),
        Transaction::write_vec(vec![address, 0]),
        Transaction::read_vec(word.to_be_bytes().to_vec()),
        Transaction::transaction_end(),
    ]
}

fn word_write(address: u8, word: u32) -> Vec<Transaction<u8>> {
    let mut bytes = vec![0x80 | address, 0];
    bytes.extend(word.to_be_bytes());
    sent(with_crc(bytes))
}

fn sent(bytes: Vec<u8>) -> Vec<Transaction<u8>> {
    vec![Transaction::transaction_start(), Transaction::write_vec(bytes), Transaction::transaction_end()]
}

/// The burst with its scans, if there are any; the last four bytes are their CRC.
fn set_read(head: Vec<u8>, scans: Vec<u8>) -> Vec<Transaction<u8>> {
    let mut reads =
        vec![Transaction::transaction_start(), Transaction::write_vec(vec![0x10, 0]), Transaction::read_vec(head)];
    if let Some((samples, crc)) = scans.split_last_chunk::<4>() {
        reads.push(Transaction::read_vec(samples.to_vec()));
        reads.push(Transaction::read_vec(crc.to_vec()));
    }
    reads.push(Transaction::transaction_end());
    reads
}

const SCANS: [[u16; 4]; 2] = [[8500, 8541, 8501, 8763], [8502, 16_383, 8499, 0]];

/// Other than a port's at reset.
const TIMING: Timing = Timing { scan_period_us: 3000, set_length: 2, oversampling: 16 };

fn started() -> Vec<Transaction<u8>> {
    started_at(0x0002_0002)
}

fn started_at(version: u32) -> Vec<Transaction<u8>> {
    let mut expected = word_read(0x00, 0x5A52_4151);
    expected.extend(word_read(0x01, version));
    expected.extend(word_write(0x02, 0));
    expected.extend(word_write(0x03, 3000));
    expected.extend(word_read(0x03, 3000));
    expected.extend(word_write(0x04, 2));
    expected.extend(word_read(0x04, 2));
    if version >= 0x0002_0002 {
        expected.extend(word_write(0x06, 16));
        expected.extend(word_read(0x06, 16));
    }
    expected.extend(word_write(0x02, 3));
    expected.extend(word_read(0x02, 1));
    expected
}

fn run(reads: Vec<Transaction<u8>>, act: impl FnOnce(&mut PortAcquisition<&mut Mock<u8>>)) {
    run_at(0x0002_0002, reads, act);
}

fn run_at(version: u32, reads: Vec<Transaction<u8>>, act: impl FnOnce(&mut PortAcquisition<&mut Mock<u8>>)) {
    let mut expected = started_at(version);
    expected.extend(reads);
    let mut spi = Mock::new(&expected);
    let mut port = PortAcquisition::new(&mut spi);
    port.start(TIMING, 2).unwrap();
    act(&mut port);
    spi.done();
}

#[test]
fn a_set_is_read_with_its_sums_and_where_it_is_wanted_with_its_scans_after_them() {
    let (head, samples) = burst(41, &SCANS);
    let mut reads = word_read(0x05, 1);
    reads.extend(set_read(head.clone(), vec![]));
    reads.extend(word_read(0x05, 1));
    // The CRC's last byte would release the set.
    reads.extend(set_read(head[..63].to_vec(), vec![]));
    reads.extend(set_read(head, samples));
    run(reads, |port| {
        let mut set = Set::default();
        assert_eq!(port.read_set(&mut set, false), Ok(true));
        assert!(set.number == 41 && set.scans.is_empty());
        assert_eq!(port.read_set(&mut set, true), Ok(true));
        assert!(set.number == 41 && set.scans.is_empty());
        port.read_scans(&mut set).unwrap();
        assert_eq!(set.scans.as_slice(), SCANS);
        let mut sums = [GroupSums::default(); 2];
        for scan in SCANS {
            sums[0].push(scan[0], scan[1]);
            sums[1].push(scan[2], scan[3]);
        }
        assert_eq!(set.sums, sums);
    });
}

#[test]
fn no_set_waiting_is_no_error() {
    run(word_read(0x05, 0), |port| assert_eq!(port.read_set(&mut Set::default(), false), Ok(false)));
}

#[test]
fn a_flipped_bit_and_an_empty_bus_are_not_taken_for_a_set() {
    let (mut head, _) = burst(41, &SCANS);
    head[20] ^= 4;
    let mut reads = word_read(0x05, 1);
    reads.extend(set_read(head, vec![]));
    reads.extend(word_read(0x05, 0xFFFF_FFFF));
    reads.extend(set_read(vec![0; 64], vec![]));
    run(reads, |port| {
        assert_eq!(port.read_set(&mut Set::default(), false), Err(PortError::Damaged));
        assert_eq!(port.read_set(&mut Set::default(), false), Err(PortError::Damaged));
    });
}

#[test]
fn scans_that_are_damaged_or_another_sets_are_none() {
    let (head, samples) = burst(41, &SCANS);
    let (next, next_samples) = burst(42, &SCANS);
    let mut damaged = samples.clone();
    damaged[3] ^= 1;
    let mut reads = word_read(0x05, 1);
    reads.extend(set_read(head[..63].to_vec(), vec![]));
    reads.extend(set_read(head, damaged));
    reads.extend(set_read(next, next_samples));
    run(reads, |port| {
        let mut set = Set::default();
        assert_eq!(port.read_set(&mut set, true), Ok(true));
        assert_eq!(port.read_scans(&mut set), Err(PortError::Damaged));
        assert_eq!(port.read_scans(&mut set), Err(PortError::AnotherSet { number: 42 }));
        assert!(set.number == 41 && set.scans.is_empty());
    });
}

fn scan_read(bytes: Vec<u8>) -> Vec<Transaction<u8>> {
    vec![
        Transaction::transaction_start(),
        Transaction::write_vec(vec![0x20, 0]),
        Transaction::read_vec(bytes),
        Transaction::transaction_end(),
    ]
}

#[test]
fn the_latest_scan_is_read_alone_and_none_and_a_damaged_one_are_told_apart() {
    let number = 70_000_u32;
    let mut bytes =
        with_crc([number.to_be_bytes().to_vec(), SCANS[1].iter().flat_map(|s| s.to_be_bytes()).collect()].concat());
    bytes[12..].iter_mut().for_each(|byte| *byte = !*byte);
    let mut damaged = bytes.clone();
    damaged[6] ^= 0x10;
    let reads = [vec![0; 16], damaged, bytes].map(scan_read).concat();
    run(reads, |port| {
        assert_eq!(port.latest_scan(), Ok(None), "none since the start");
        assert_eq!(port.latest_scan(), Err(PortError::Damaged));
        assert_eq!(port.latest_scan(), Ok(Some(NumberedScan { number, scan: SCANS[1] })));
    });
}

/// A bit too many in its head makes 0x20 of 0x10; the scan's four words, and the zeros after them, are no set.
#[test]
fn a_scan_in_place_of_a_set_is_damage() {
    let words = [500_u32 << 16, 500 << 16 | 8200, 8500 << 16 | 8200];
    let mut bytes = with_crc(words.iter().flat_map(|word| word.to_be_bytes()).collect());
    bytes[12..].iter_mut().for_each(|byte| *byte = !*byte);
    bytes.resize(64, 0);
    run([word_read(0x05, 1), set_read(bytes, vec![])].concat(), |port| {
        assert_eq!(port.read_set(&mut Set::default(), false), Err(PortError::Damaged));
    });
}

#[test]
fn a_port_of_version_2_0_gives_its_sets_and_is_not_asked_for_scans() {
    let (head, _) = burst(41, &SCANS);
    run_at(0x0002_0000, [word_read(0x05, 1), set_read(head, vec![])].concat(), |port| {
        assert_eq!(port.latest_scan(), Ok(None));
        assert_eq!(port.read_set(&mut Set::default(), false), Ok(true));
    });
}

#[test]
fn a_port_of_version_2_1_is_not_asked_to_oversample() {
    run_at(0x0002_0001, word_read(0x05, 0), |port| assert_eq!(port.read_set(&mut Set::default(), false), Ok(false)));
}

#[test]
fn a_port_that_oversamples_less_than_it_was_told_is_named() {
    let mut expected = started();
    // What comes after OVERSAMPLING: the word read back, and the start.
    expected.truncate(expected.len() - 4 - 3 - 4);
    expected.extend(word_read(0x06, 8));
    let mut spi = Mock::new(&expected);
    let error = PortAcquisition::new(&mut spi).start(TIMING, 2).unwrap_err();
    assert_eq!(error, PortError::NotTaken { address: 6, found: 8 });
    spi.done();
}

#[test]
fn the_first_set_may_be_shorter_and_each_is_read_by_its_own_length() {
    let mut expected = started();
    // SET_LENGTH of the first set, before the start; the others' after it.
    let set_length = 4 + 4 + 3 + 3 + 4;
    expected.splice(set_length..set_length + 3 + 4, [word_write(0x04, 1), word_read(0x04, 1)].concat());
    expected.extend([word_write(0x04, 2), word_read(0x04, 2)].concat());
    let sets = [burst(0, &SCANS[..1]), burst(1, &SCANS)];
    for (head, samples) in sets.clone() {
        expected.extend([word_read(0x05, 1), set_read(head[..63].to_vec(), vec![]), set_read(head, samples)].concat());
    }
    // A set 1 as short as set 0 is none.
    expected.extend([word_read(0x05, 1), set_read(burst(1, &SCANS[..1]).0, vec![])].concat());
    let mut spi = Mock::new(&expected);
    let mut port = PortAcquisition::new(&mut spi);
    port.start(TIMING, 1).unwrap();
    let mut set = Set::default();
    for scans in [&SCANS[..1], &SCANS] {
        assert_eq!(port.read_set(&mut set, true), Ok(true));
        port.read_scans(&mut set).unwrap();
        assert_eq!(set.scans.as_slice(), scans);
    }
    assert_eq!(port.read_set(&mut set, false), Err(PortError::Length { found: 1 }));
    spi.done();
}

#[test]
fn something_else_on_the_bus_is_named() {
    let mut spi = Mock::new(&word_read(0x00, 0xFFFF_FFFF));
    let error = PortAcquisition::new(&mut spi).start(Timing::PAPER, 500).unwrap_err();
    assert_eq!(error, PortError::NotAPort { identity: 0xFFFF_FFFF });
    spi.done();
}

#[test]
fn a_port_of_another_major_version_is_named_and_nothing_is_written_to_it() {
    for version in [0x0001_0000, 0x0001_0007, 0x0003_0000] {
        let mut expected = word_read(0x00, 0x5A52_4151);
        expected.extend(word_read(0x01, version));
        let mut spi = Mock::new(&expected);
        let error = PortAcquisition::new(&mut spi).start(Timing::PAPER, 500).unwrap_err();
        assert_eq!(error, PortError::UnknownVersion { version });
        spi.done();
    }
}

/// The CRCs are zlib's, which has the same polynomial the other way round:
///
///     python3 -c 'import sys, zlib
///     turn = lambda number, bits: int(format(number, f"0{bits}b")[::-1], 2)
///     turned = bytes(turn(byte, 8) for byte in bytes.fromhex(sys.argv[1]))
///     print(hex(turn(zlib.crc32(turned) ^ 0xFFFFFFFF, 32)))' 830000000BB8
#[test]
fn a_write_goes_out_with_a_crc_that_is_not_our_own() {
    let mut expected = sent(vec![0x82, 0, 0, 0, 0, 0, 0xA9, 0xE1, 0x9C, 0x51]);
    expected.extend(sent(vec![0x83, 0, 0, 0, 0x0B, 0xB8, 0xD1, 0x5C, 0xED, 0x6E]));
    let mut spi = Mock::new(&expected);
    let mut port = PortAcquisition::new(&mut spi);
    port.stop().unwrap();
    port.write_word(SCAN_PERIOD, 3000).unwrap();
    spi.done();
}

#[test]
fn a_start_that_the_port_has_not_taken_is_named() {
    let mut expected = started();
    expected.truncate(expected.len() - 4);
    expected.extend(word_read(0x02, 0));
    let mut spi = Mock::new(&expected);
    let error = PortAcquisition::new(&mut spi).start(TIMING, 2).unwrap_err();
    assert_eq!(error, PortError::NotTaken { address: 2, found: 0 });
    spi.done();
}

#[test]
fn a_setting_that_the_port_has_not_taken_is_named_and_nothing_is_started() {
    let mut expected = started();
    // Identity and version, CONTROL, SCAN_PERIOD and its word read back; the rest never comes.
    expected.truncate(4 + 4 + 3 + 3);
    expected.extend(word_read(0x03, 3001));
    let mut spi = Mock::new(&expected);
    let error = PortAcquisition::new(&mut spi).start(TIMING, 2).unwrap_err();
    assert_eq!(error, PortError::NotTaken { address: 3, found: 3001 });
    spi.done();
}
