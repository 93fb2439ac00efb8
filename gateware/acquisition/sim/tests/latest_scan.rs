//! The latest scan, read when and how a master likes: never torn, numbered, and no disturbance to the sets.

#![allow(clippy::unwrap_used)] // All of it is a test.

use zerorate_device::acquisition::{Acquisition, NumberedScan, Set, Timing as Sets};
use zerorate_device::port::PortAcquisition;
use zerorate_gateware::{Bench, Port, Random, Scale, Scan, SharedPort, Timing, checked};

const SCAN: u8 = 0x20;
const RUN: u32 = 1;
const RESTART: u32 = 2;

fn port(seed: u32, timing: Timing) -> Port {
    let mut samples = Random::new(u64::from(seed));
    Port::new(Bench::new(Scale::Fast, seed, move |_| samples.counts()), timing, u64::from(seed))
}

/// Number and samples of four words whose CRC is right; none of four zeros.
fn scan_of(words: &[u32]) -> Option<(u32, [u16; 4])> {
    if words == [0; 4] {
        return None;
    }
    assert!(checked(&[words[0], words[1], words[2], !words[3]]).is_some(), "{words:x?}");
    let sample = |word: u32, high: bool| u16::try_from(if high { word >> 16 } else { word & 0xFFFF }).unwrap();
    Some((words[0], [sample(words[1], true), sample(words[1], false), sample(words[2], true), sample(words[2], false)]))
}

#[test]
fn a_scan_that_is_read_at_any_moment_is_one_that_the_converter_gave_and_the_sets_go_on_beside_it() {
    for (seed, timing) in (1..).zip([Timing::FASTEST, Timing::QUICK, Timing::UNEVEN]) {
        let mut port = port(seed, timing);
        let mut random = Random::new(u64::from(seed));
        assert_eq!(port.read(SCAN, 6), [0; 6], "none was taken");
        port.start(3000, 7);
        let (mut last, mut kept, mut sets) = (None, 0, 0);
        for _ in 0..500 {
            let before = port.bench.scans().len();
            let found = scan_of(&port.read(SCAN, 4));
            if let Some((number, samples)) = found {
                assert_eq!(samples, port.bench.scans()[number as usize].samples, "scan {number}");
                // A scan is in the register a moment after its last frame.
                assert!(number as usize + 2 >= before && last <= Some(number), "{number} after {last:?} of {before}");
                kept += u32::from(last == Some(number));
            }
            last = found.map(|(number, _)| number).max(last);
            if port.bench.data_ready() {
                let burst = port.read_set(7);
                assert_eq!((burst[0], burst[2]), (sets, 0), "no set is lost or released by a scan's reading");
                sets += 1;
            }
            port.bench.pass(random.between(0, 600_000_000));
        }
        assert!(kept > 10 && sets > 50, "{kept} read twice, {sets} sets");
    }
}

#[test]
fn scan_ready_rises_once_a_scan_whether_anybody_reads_and_no_later_than_data_ready() {
    let mut port = port(9, Timing::QUICK);
    assert!(!port.bench.scan_ready());
    port.start(1000, 5);
    for set in 0..40 {
        assert!(!port.bench.data_ready());
        while !port.bench.data_ready() {
            port.bench.pass(10_000);
        }
        assert!(port.bench.scan_ready());
        assert_eq!(port.bench.scan_ready_rises(), 5 * (set + 1));
        port.read(0x10, 16);
        port.bench.pass(300_000);
    }
    port.write(0x02, 0);
    let (number, _) = scan_of(&port.read(SCAN, 4)).unwrap();
    assert_eq!(number, 199, "a stop leaves it");
    port.write(0x02, RUN | RESTART);
    port.bench.pass(1_000_000);
    assert!(!port.bench.scan_ready());
    assert_eq!(port.read(SCAN, 4), [0; 4]);
}

#[test]
fn a_read_longer_than_a_scan_period_is_not_torn_and_ends_in_zeros() {
    let mut port = port(11, Timing::FASTEST);
    port.start(100, 3);
    port.bench.pass(500_000_000);
    for _ in 0..50 {
        port.select();
        port.byte(SCAN);
        port.byte(0);
        let mut words = Vec::new();
        for _ in 0..6 {
            words.push(port.word());
            // A scan takes 93 us of this scale and begins each 100.
            port.bench.pass(31_000_000);
        }
        port.deselect();
        let (number, samples) = scan_of(&words[..4]).unwrap();
        assert_eq!(samples, port.bench.scans()[number as usize].samples);
        assert_eq!(words[4..], [0; 2]);
    }
}

/// Sixteen passes as one scan: their means, from a half to the even count.
fn mean(passes: &[Scan]) -> [u16; 4] {
    [0, 1, 2, 3].map(|channel| {
        let sum: u32 = passes.iter().map(|pass| u32::from(pass.samples[channel])).sum();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // A mean of 14 bits.
        let mean = (f64::from(sum) / 16.0).round_ties_even() as u16;
        mean
    })
}

#[test]
fn the_device_s_master_reads_each_scan_as_it_comes() {
    let board = SharedPort::new(port(5, Timing::QUICK));
    let mut master = PortAcquisition::new(board.clone());
    assert_eq!(master.latest_scan(), Ok(None));
    // Before the start: the first pass comes while the settings are still read back.
    board.0.borrow_mut().bench.count_scans();
    master.start(Sets { scan_period_us: 3000, set_length: 12, oversampling: 16 }, 5).unwrap();
    let (mut set, mut lengths) = (Set::default(), Vec::new());
    for number in 0..60 {
        while board.0.borrow().bench.scan_ready_rises() <= number {
            board.0.borrow_mut().bench.pass(100_000);
        }
        let scan = mean(&board.0.borrow().bench.scans()[16 * number as usize..][..16]);
        assert_eq!(master.latest_scan(), Ok(Some(NumberedScan { number, scan })));
        if board.0.borrow().bench.data_ready() {
            assert_eq!(master.read_set(&mut set, false), Ok(true));
            lengths.push(set.sums[0].n);
        }
    }
    assert_eq!(lengths, [5, 12, 12, 12, 12], "the first set is a short one");
}
