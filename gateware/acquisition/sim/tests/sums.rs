//! Sums and samples against those that the A/D delivered.

#![allow(clippy::unwrap_used)] // All of it is a test.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use zerorate_device::acquisition::{self as device, Acquisition, Set};
use zerorate_device::direct::DirectAcquisition;
use zerorate_device::port::{PortAcquisition, PortError};
use zerorate_gateware::{
    Ad7949, Bench, ConverterDelay, ConverterSpi, Head, Limits, Port, Random, Scale, SharedPort, Timing, head, scans,
};

const SET: u8 = 0x10;

/// What the A/D reads: mostly anywhere, at times at the ends of its range, where sums are largest.
fn input(seed: u64) -> impl FnMut(usize) -> u16 {
    let mut random = Random::new(seed);
    move |_| match random.between(0, 7) {
        0 => 0x3FFF,
        1 => 0,
        _ => random.counts(),
    }
}

type Input = Box<dyn FnMut(usize) -> u16>;

/// The processor's own acquisition on an A/D whose inputs are held at given scans, and which scan it is at.
struct Direct {
    acquisition: DirectAcquisition<ConverterSpi<Input>, ConverterDelay>,
    held: Rc<Cell<[u16; 4]>>,
}

impl Direct {
    fn new() -> Self {
        let held = Rc::new(Cell::new([0; 4]));
        let inputs = Rc::clone(&held);
        let input: Input = Box::new(move |channel| inputs.get()[channel]);
        let spi = ConverterSpi::new(Ad7949::new(Limits::DATA_SHEET), input);
        let delay = spi.delay();
        Self { acquisition: DirectAcquisition::new(spi, delay), held }
    }

    /// The set that it makes of these scans.
    fn set(&mut self, timing: device::Timing, scans: &[[u16; 4]]) -> Set {
        self.acquisition.start(timing, timing.set_length).unwrap();
        for (index, scan) in scans.iter().enumerate() {
            self.held.set(*scan);
            assert_eq!(self.acquisition.tick(), Ok(index + 1 == scans.len()));
        }
        let mut set = Set::default();
        assert_eq!(self.acquisition.read_set(&mut set, true), Ok(true));
        set
    }
}

type Master = PortAcquisition<SharedPort>;

/// Starts the block, and counts its scans from there: it is scanning by the time that the master has read back what it wrote.
fn start(master: &mut Master, board: &RefCell<Port>, timing: device::Timing) {
    master.stop().unwrap();
    // A stop is taken within six of the block's clocks of chip select's rise: a scan that begins before is none of these.
    board.borrow_mut().bench.pass(250_000);
    board.borrow_mut().bench.count_scans();
    master.start(timing, timing.set_length).unwrap();
}

/// Reads the set that waits; `false` where another waits by the time that its scans are read.
fn read(master: &mut Master, set: &mut Set, with_scans: bool) -> bool {
    assert_eq!(master.read_set(set, with_scans), Ok(true));
    match with_scans.then(|| master.read_scans(set)) {
        None | Some(Ok(())) => true,
        Some(Err(PortError::AnotherSet { .. })) => false,
        Some(Err(error)) => panic!("{error:?}"),
    }
}

#[test]
fn sums_of_1000_sets_of_random_lengths_and_rates_are_the_direct_acquisition_s_bit_for_bit() {
    let mut random = Random::new(2012);
    let port = SharedPort::new(Port::new(Bench::new(Scale::Fast, 1, input(1)), Timing::UNEVEN, 1));
    let board = Rc::clone(&port.0);
    // The master as it runs on the board.
    let mut master = PortAcquisition::new(port);
    let mut direct = Direct::new();
    let mut longest = 0;
    for index in 0..1000 {
        // Short ones mostly, and one in ten of any length.
        let longest_here = if random.one_in(10) { 512 } else { 48 };
        let length = if index == 500 { 512 } else { random.between(1, longest_here) };
        // The rates at which a whole set is simulated in a moment; the longest period has a test of its own.
        let period_us = if random.one_in(20) { random.between(100, 2000) } else { random.between(100, 140) };
        let timing = device::Timing {
            scan_period_us: u32::try_from(period_us).unwrap(),
            set_length: u16::try_from(length).unwrap(),
            oversampling: 1,
        };
        longest = longest.max(length);
        start(&mut master, &board, timing);
        let mut set = Set::default();
        assert!(board.borrow_mut().wait_for_data_ready(period_us * (length + 1)));
        let with_scans = random.one_in(4);
        // Between sums and scans a newer set may take the place of one that is filled in a moment; that one is then gone, too.
        let mut gone = 0;
        while !read(&mut master, &mut set, with_scans) {
            gone += 1;
            assert!(board.borrow_mut().wait_for_data_ready(period_us * (length + 1)));
        }

        // Sets of a few scans may be full more than once before a slow master has asked for STATUS and begun to read.
        let bench = &board.borrow().bench;
        let first = set.number as usize * usize::from(timing.set_length);
        let taken = &bench.scans()[first..first + usize::from(timing.set_length)];
        let samples: Vec<[u16; 4]> = taken.iter().map(|scan| scan.samples).collect();
        let expected = direct.set(timing, &samples);
        assert_eq!(expected.scans[..], samples);
        assert_eq!((set.lost + gone, set.sums), (set.number, expected.sums), "set {index}");
        assert!(!with_scans && set.scans.is_empty() || set.scans == expected.scans, "set {index}");
        let period_ps = bench.period_ps(period_us);
        assert!(taken.windows(2).all(|pair| pair[1].began_ps - pair[0].began_ps == period_ps));
    }
    assert_eq!(longest, 512);
    assert_eq!(board.borrow().bench.converter_faults(), [""; 0]);
}

#[test]
fn the_master_sees_every_set_of_a_run_and_starts_and_stops_it() {
    let port = SharedPort::new(Port::new(Bench::new(Scale::Fast, 5, input(5)), Timing::QUICK, 5));
    let board = Rc::clone(&port.0);
    let mut master = PortAcquisition::new(port);
    let timing = device::Timing { scan_period_us: 300, set_length: 40, oversampling: 1 };
    for _ in 0..3 {
        start(&mut master, &board, timing);
        let mut scans = Vec::new();
        let mut set = Set::default();
        for number in 0..10 {
            assert!(board.borrow_mut().wait_for_data_ready(20_000));
            assert!(read(&mut master, &mut set, true));
            assert_eq!((set.number, set.lost), (number, 0));
            scans.extend_from_slice(&set.scans);
        }
        let taken: Vec<[u16; 4]> = board.borrow().bench.scans().iter().map(|scan| scan.samples).collect();
        assert_eq!(scans, taken[..400]);
        master.stop().unwrap();
        assert!(!board.borrow_mut().wait_for_data_ready(20_000));
        assert_eq!(master.read_set(&mut set, false), Ok(false));
    }
}

#[test]
fn the_largest_set_of_the_largest_samples_fits() {
    let mut port = Port::new(Bench::new(Scale::Fast, 2, |_| 0x3FFF), Timing::FASTEST, 2);
    port.start(100, 512);
    assert!(port.wait_for_data_ready(60_000));
    let burst = port.read(SET, 16 + 1024 + 1);
    let taken = [[0x3FFF; 4]; 512];
    assert_eq!(head(&burst), Some(Head::of(0, false, 0, &taken)));
    assert_eq!(scans(&burst, 512).unwrap(), taken);
}

#[test]
fn sets_that_follow_each_other_have_every_scan_once() {
    let mut port = Port::new(Bench::new(Scale::Fast, 3, input(3)), Timing::FASTEST, 3);
    // Read at 10 MHz a set of 50 takes 376 us, and fills in 625 (5000 of the fast scale's).
    port.start(100, 50);
    let mut read = Vec::new();
    for number in 0..60 {
        assert!(port.wait_for_data_ready(20_000));
        let burst = port.read(SET, 16 + 100 + 1);
        assert_eq!((head(&burst).unwrap().number, head(&burst).unwrap().lost), (number, 0));
        read.extend(scans(&burst, 50).unwrap());
    }
    let taken: Vec<[u16; 4]> = port.bench.scans().iter().map(|scan| scan.samples).collect();
    assert_eq!(read, taken[..read.len()]);
}

#[test]
fn the_longest_period_is_a_second() {
    let mut port = Port::new(Bench::new(Scale::Fast, 4, input(4)), Timing::FASTEST, 4);
    port.start(1_000_000, 2);
    assert!(port.wait_for_data_ready(2_100_000));
    let scans = port.bench.scans();
    assert_eq!(scans[1].began_ps - scans[0].began_ps, port.bench.period_ps(1_000_000));
}
