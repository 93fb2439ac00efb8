//! Client and device over a line that damages one byte in a thousand, each way: a deploy comes through by being sent
//! again, or fails with a reason, and what the device keeps is never anything but the old record or the new one.

#![allow(clippy::unwrap_used)] // what a test cannot do without

mod paper_record;

use std::cell::Cell;
use std::rc::Rc;
use std::time::{Duration, Instant};

use zerorate_bench::client::DeviceClient;
use zerorate_bench::link::{Link, LinkError};
use zerorate_bench::plants::PlantKind;
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated;
use zerorate_core::record::{DeviceRecord, MAX_RECORD_BYTES, UnitSerial};
use zerorate_core::trim::TapEffects;
use zerorate_core::units::{Counts, Taps};

/// A line that damages bytes, in real time: what is lost is noticed by the clock, which is the line's own.
struct Damaging {
    inner: Box<dyn Link>,
    now: Instant,
    /// One byte in so many; 0: none.
    one_in: Rc<Cell<u64>>,
    state: u64,
    damaged: Rc<Cell<u32>>,
}

impl Damaging {
    fn random(&mut self) -> u64 {
        self.state = self.state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.state >> 33
    }

    fn damage(&mut self, bytes: &mut [u8]) {
        let one_in = self.one_in.get();
        for byte in bytes {
            if one_in > 0 && self.random().is_multiple_of(one_in) {
                *byte ^= 1 + (self.random() % 255) as u8;
                self.damaged.set(self.damaged.get() + 1);
            }
        }
    }
}

impl Link for Damaging {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        let mut bytes = bytes.to_vec();
        self.damage(&mut bytes);
        self.inner.send(&bytes)
    }

    fn receive(&mut self, into: &mut Vec<u8>) -> Result<(), LinkError> {
        let mut bytes = Vec::new();
        match self.inner.receive(&mut bytes) {
            // The acquisition stands still: a native device says nothing, and a line in real time goes on waiting.
            Err(LinkError::Silent) => self.now += Duration::from_millis(20),
            other => other?,
        }
        self.damage(&mut bytes);
        into.extend_from_slice(&bytes);
        Ok(())
    }

    fn in_real_time(&self) -> bool {
        true
    }

    fn now(&self) -> Instant {
        self.now
    }
}

/// A record as a calibration makes it, with every tap of a working range in it.
fn record(dead_band: f64) -> DeviceRecord {
    let effects = (490..=530).map(|tap| Counts(31.25 * (f64::from(tap) - 511.0))).collect::<Vec<_>>();
    let measured = TapEffects::new(Taps::new(490).unwrap(), &effects);
    paper_record::record([8500.0, 11_900.0], measured, dead_band)
}

fn bytes(record: &DeviceRecord) -> Vec<u8> {
    let mut buffer = [0; MAX_RECORD_BYTES];
    record.encode(&mut buffer).unwrap().to_vec()
}

/// Deploys over a line with one damaged byte in so many; whether it was said to be done, and how many were damaged.
fn deploy(seed: u64, one_in: u64) -> (bool, u32) {
    let unit = UnitSerial::try_from("ZR-1").unwrap();
    let (inner, _) = simulated::bare_device(PlantKind::Paper.build(1), &SetUp::paper(), &unit);
    let (rate, damaged) = (Rc::new(Cell::new(0)), Rc::new(Cell::new(0)));
    let state = seed * 7919 + 1;
    let link = Damaging { inner, now: Instant::now(), one_in: Rc::clone(&rate), state, damaged: Rc::clone(&damaged) };
    let mut device = DeviceClient::new(Box::new(link));
    let (old, new) = (record(0.05), record(0.1));
    device.identify().unwrap();
    device.deploy(&old).unwrap();
    rate.set(one_in);
    let done = device.identify().and_then(|_| device.deploy(&new));
    // Looked at over a line that is good again.
    rate.set(0);
    device.identify().unwrap();
    let kept = device.read_calibration().unwrap();
    match &done {
        Ok(()) => assert_eq!(kept, bytes(&new), "seed {seed}: said to be done"),
        Err(error) => {
            assert!(kept == bytes(&old) || kept == bytes(&new), "seed {seed}: neither record");
            assert!(!error.to_string().is_empty());
        }
    }
    (done.is_ok(), damaged.get())
}

fn deploy_all(seeds: u64, one_in: u64) -> (usize, u32) {
    let threads: Vec<_> = (0..seeds).map(|seed| std::thread::spawn(move || deploy(seed, one_in))).collect();
    let results: Vec<(bool, u32)> = threads.into_iter().map(|thread| thread.join().unwrap()).collect();
    (results.iter().filter(|(done, _)| *done).count(), results.iter().map(|(_, damaged)| damaged).sum())
}

#[test]
fn a_deploy_over_a_line_that_damages_a_byte_in_a_thousand_comes_through() {
    let (done, damaged) = deploy_all(24, 1000);
    assert!(damaged > 48, "{damaged} bytes");
    assert_eq!(done, 24, "each chunk is sent up to eight times");
}

#[test]
fn on_a_hopeless_line_it_fails_with_a_reason_and_nothing_wrong_is_kept() {
    let (done, _) = deploy_all(6, 20);
    assert_eq!(done, 0);
}
