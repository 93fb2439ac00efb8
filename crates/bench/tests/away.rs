//! A chamber that does not answer for a while: every group is taken, and a soak is a soak.

#![allow(clippy::unwrap_used)] // what a test cannot do without

use std::cell::Cell;
use std::ops::Range;
use std::rc::Rc;

use zerorate_bench::error::BenchError;
use zerorate_bench::instruments::{Bench, Chamber, InstrumentError};
use zerorate_bench::plants::PlantKind;
use zerorate_bench::run::{Phase, Progress, Recorder, Session, Silent};
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated;
use zerorate_core::record::UnitSerial;
use zerorate_core::units::{Celsius, Kelvins, Seconds};
use zerorate_core::wire::SampleWindow;

/// The simulated chamber, which is away in some of the calls, and warmer than it should be in others.
struct Flaky {
    chamber: Box<dyn Chamber>,
    /// Calls so far.
    calls: Rc<Cell<u32>>,
    away: Range<u32>,
    strays: Range<u32>,
}

impl Flaky {
    fn is_away(&self) -> bool {
        self.calls.set(self.calls.get() + 1);
        self.away.contains(&self.calls.get())
    }
}

impl Chamber for Flaky {
    fn set(&mut self, set_point: Celsius) -> Result<(), InstrumentError> {
        if self.is_away() { Err(InstrumentError::Away("chamber")) } else { self.chamber.set(set_point) }
    }

    fn set_point(&self) -> Celsius {
        self.chamber.set_point()
    }

    fn air(&mut self) -> Result<Celsius, InstrumentError> {
        if self.is_away() {
            return Ok(Celsius(f64::NAN));
        }
        let strayed = if self.strays.contains(&self.calls.get()) { 3.0 } else { 0.0 };
        self.chamber.air().map(|air| air + Kelvins(strayed))
    }
}

/// The simulated chamber, which says at some of the times it is asked that it may have gone elsewhere.
struct Astray {
    chamber: Box<dyn Chamber>,
    asked: u32,
    /// What it is sent to, and how often.
    sent: Rc<Cell<u32>>,
    at: u32,
}

impl Chamber for Astray {
    fn set(&mut self, set_point: Celsius) -> Result<(), InstrumentError> {
        self.sent.set(self.sent.get() + 1);
        self.chamber.set(set_point)
    }

    fn set_point(&self) -> Celsius {
        self.chamber.set_point()
    }

    fn air(&mut self) -> Result<Celsius, InstrumentError> {
        self.chamber.air()
    }

    fn take_astray(&mut self) -> Result<bool, InstrumentError> {
        self.asked += 1;
        Ok(self.asked == self.at)
    }
}

/// A ramp of ten groups from 25 C, whose chamber says so the given time it is asked: how it ends, how often the chamber was sent
/// anywhere, what is told, and how long it took.
fn ramp_astray(at: u32) -> (Result<usize, BenchError>, u32, Vec<String>, f64) {
    let setup = SetUp::parse("[chamber]\nsoak_s = 600.0\n", "x").unwrap();
    let mut bench = simulated::bench(PlantKind::Paper.build(1), &setup, &UnitSerial::new());
    bench.clock = None;
    let sent = Rc::default();
    bench.chamber = Box::new(Astray { chamber: bench.chamber, asked: 0, sent: Rc::clone(&sent), at });
    let mut silent = Silent;
    let mut session = Session::new(&mut bench, &setup, &mut silent);
    session.begin().unwrap();
    session.start(SampleWindow::NONE).unwrap();
    let mut recorder = Recorder::discarding();
    session.until(4, Phase::Soak, &mut recorder).unwrap();
    let ramp = session.ramp(Celsius(40.0), 10, Phase::Heating, &mut recorder);
    let warnings = session.warnings.sentences().collect();
    (ramp.map(|ramp| ramp.len()), sent.get(), warnings, session.elapsed.0)
}

#[test]
fn a_chamber_that_may_have_left_before_its_ramp_is_held_once_more_and_one_that_was_elsewhere_in_it_makes_none() {
    let (ramp, sent, warnings, elapsed_s) = ramp_astray(u32::MAX);
    assert_eq!((ramp.unwrap(), sent, warnings.len()), (10, 1, 0));
    assert!((elapsed_s - 14.0 * 1.5).abs() < 1e-6, "{elapsed_s}");
    // Sent back before it was sent, or sent, sent back, sent again; ten minutes and the ramp.
    for (at, times) in [(1, 2), (2, 3)] {
        let (ramp, sent, warnings, elapsed_s) = ramp_astray(at);
        assert_eq!((ramp.unwrap(), sent), (10, times));
        assert!(
            warnings[0].contains("sent back and held there again") && elapsed_s > 600.0,
            "{warnings:?}, {elapsed_s}"
        );
    }
    let (ramp, _, _, _) = ramp_astray(3);
    assert!(matches!(ramp, Err(BenchError::OffCourse)));
}

/// The simulated bench on the time of the board's groups, as a real one is.
fn bench(away: Range<u32>, strays: Range<u32>) -> (Bench, Rc<Cell<u32>>) {
    let calls = Rc::default();
    let mut bench = simulated::bench(PlantKind::Paper.build(1), &SetUp::paper(), &UnitSerial::new());
    bench.clock = None;
    bench.chamber = Box::new(Flaky { chamber: bench.chamber, calls: Rc::clone(&calls), away, strays });
    (bench, calls)
}

#[test]
fn a_ramp_waits_for_a_chamber_that_is_away_and_takes_every_group() {
    // Four groups ask where it is; then it is sent, is away, and comes back after some groups that ask as well.
    let (mut bench, _) = bench(5..20, 0..0);
    let (setup, mut silent) = (SetUp::paper(), Silent);
    let mut session = Session::new(&mut bench, &setup, &mut silent);
    session.begin().unwrap();
    session.start(SampleWindow::NONE).unwrap();
    let mut recorder = Recorder::discarding();
    session.until(4, Phase::Soak, &mut recorder).unwrap();
    let ramp = session.ramp(Celsius(40.0), 50, Phase::Heating, &mut recorder).unwrap();
    // 15 calls, every other one of them of a group that went by meanwhile, and the first that is not away.
    let groups: Vec<u32> = ramp.iter().map(|taken| taken.report.group.0).collect();
    assert_eq!(groups, (12..62).collect::<Vec<_>>());
    assert!(ramp.iter().all(|taken| taken.phase == Phase::Heating));
}

#[test]
fn the_time_in_which_nobody_knows_where_the_chamber_is_does_not_count_as_held() {
    let elapsed = |away: Range<u32>| {
        let (mut bench, _) = bench(away, 0..0);
        let (setup, mut silent) = (SetUp::paper(), Silent);
        let mut session = Session::new(&mut bench, &setup, &mut silent);
        session.begin().unwrap();
        session.soak("a soak", Celsius(25.0), Seconds(600.0)).unwrap();
        session.elapsed.0
    };
    let (straight, with_a_gap) = (elapsed(0..0), elapsed(100..300));
    // 200 calls, seven of eight of them groups of 1.5 s: what is looked at besides asks as well.
    let lost = with_a_gap - straight;
    assert!((straight - 600.0).abs() < 60.0, "{straight}");
    assert!((200.0..320.0).contains(&lost), "{lost}");
}

#[test]
fn a_chamber_that_leaves_its_set_point_is_soaked_anew_and_that_is_told() {
    let (mut bench, _) = bench(0..0, 300..340);
    let (setup, mut told) = (SetUp::paper(), Told::default());
    let mut session = Session::new(&mut bench, &setup, &mut told);
    session.begin().unwrap();
    session.soak("a soak", Celsius(25.0), Seconds(600.0)).unwrap();
    // 340 calls, seven of eight of them groups, and ten minutes after them.
    assert!(session.elapsed.0 > 340.0 * 7.0 / 8.0 * 1.5 + 590.0, "{}", session.elapsed.0);
    let warnings: Vec<String> = session.warnings.sentences().collect();
    assert!(warnings.len() == 1 && warnings[0].contains("the soak begins anew once it is back"), "{warnings:?}");
    assert_eq!(told.0, 1);
}

#[derive(Default)]
struct Told(usize);

impl Progress for Told {
    fn phase(&mut self, _: &str, _: u32) {}
    fn step(&mut self, _: f64) {}
    fn note(&mut self, _: &str) {
        self.0 += 1;
    }
}
