use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::vec::Vec;

use zerorate_core::compensate::Mode;
use zerorate_core::record::MAX_RECORD_BYTES;
use zerorate_core::units::{Axis, Taps};
use zerorate_core::wire::frame::{self, Receiver};
use zerorate_core::wire::{
    Answer, CalibrationState, Command, Identity, Message, Request, ResetCause, SampleWindow, Stop, Upload,
};

use super::*;
use crate::restart::Reset;
use crate::tests::{MemoryStore, Part, Sets, record};
use crate::watchdog::NoWatchdog;

type TestApplication = Application<Sets, Part, MemoryStore, NoWatchdog, Rc<Kept>>;

fn start(sets: &Sets, part: &Part, store: &MemoryStore, kept: &Rc<Kept>) -> TestApplication {
    Application::start(parts(sets, part, store, kept, NoWatchdog))
}

fn parts<W>(
    sets: &Sets,
    part: &Part,
    store: &MemoryStore,
    kept: &Rc<Kept>,
    watchdog: W,
) -> Parts<Sets, Part, MemoryStore, W, Rc<Kept>> {
    Parts {
        acquisition: sets.clone(),
        trim: part.clone(),
        store: store.clone(),
        watchdog,
        kept: Rc::clone(kept),
        started: kept.started(Reset::Untold),
        unit: UnitSerial::default(),
        timing: Timing::PAPER,
        board: BoardNumbers::PAPER,
        health: Health::default,
        memory: compensator::Memory::new(),
        buffer: Buffer::new(),
    }
}

/// A board whose power has just come, with its sets and its potentiometer.
struct Rig {
    application: TestApplication,
    sets: Sets,
    part: Part,
    store: MemoryStore,
    kept: Rc<Kept>,
}

impl Rig {
    fn starting_in(modes: [Mode; 2]) -> Self {
        Self::with(Self::storing(modes))
    }

    fn storing(modes: [Mode; 2]) -> MemoryStore {
        let mut record = record("u");
        for (axis, mode) in record.axes.iter_mut().zip(modes) {
            axis.start_up_mode = mode;
        }
        let mut store = MemoryStore::default();
        store.commit(record.encode(&mut [0; MAX_RECORD_BYTES]).unwrap()).unwrap();
        store
    }

    fn with(store: MemoryStore) -> Self {
        Self::on(Sets::default(), store)
    }

    fn on(sets: Sets, store: MemoryStore) -> Self {
        let (part, kept) = (Part::default(), Rc::default());
        let application = start(&sets, &part, &store, &kept);
        Self { application, sets, part, store, kept }
    }

    /// The program stops itself, and starts anew.
    fn panic(&mut self) {
        self.kept.stopped(&Stop::panic_at("src/lib.rs", 1));
        self.sets.waiting.borrow_mut().clear();
        self.application = start(&self.sets, &self.part, &self.store, &self.kept);
    }

    fn ask(&mut self, request: Request) -> Answer {
        let mut said = Vec::new();
        let command = Command { sequence: 1, at: None, request };
        self.application.run(frame::encode(&command).unwrap(), &mut |bytes: &[u8]| {
            said.extend_from_slice(bytes);
            true
        });
        let mut receiver = Receiver::new();
        let upload: Upload = said.iter().find_map(|&byte| receiver.push(byte)).unwrap().unwrap();
        let Message::Answer { answer, .. } = upload.message else { panic!("an answer") };
        answer
    }

    fn identity(&mut self) -> Identity {
        let Answer::Identity(identity) = self.ask(Request::Identity) else { panic!("an identity") };
        identity
    }

    fn calibration(&mut self) -> CalibrationState {
        self.identity().calibration
    }

    /// Data ready, and nobody who speaks.
    fn set(&mut self, number: u32) {
        self.sets.push(number, 8500, 8541);
        self.application.compensator.service();
        self.application.run([], &mut |_: &[u8]| panic!("nobody asked for anything"));
    }

    fn writes(&self) -> Vec<(Axis, u16)> {
        core::mem::take(&mut *self.part.writes.borrow_mut())
    }
}

#[test]
fn with_a_record_the_wipers_follow_from_the_first_group_after_power_with_no_host() {
    let mut rig = Rig::starting_in([Mode::Hybrid, Mode::Trim]);
    assert_eq!(rig.writes(), [(Axis::X, 511), (Axis::Y, 511)]);
    rig.set(0);
    assert_eq!(rig.writes(), [(Axis::X, 500), (Axis::Y, 500)]);
    assert_eq!(rig.application.compensator.status().modes, [Mode::Hybrid, Mode::Trim]);
}

#[test]
fn a_record_that_is_off_on_both_axes_asks_for_silence_and_one_axis_is_enough_to_go_to_work() {
    for (modes, runs) in [([Mode::Off; 2], false), ([Mode::Off, Mode::Digital], true)] {
        let rig = Rig::starting_in(modes);
        assert_eq!(rig.application.compensator.status().running, runs, "{modes:?}");
    }
}

#[test]
fn a_board_without_a_record_waits_for_its_host_at_the_middle_taps() {
    let mut rig = Rig::with(MemoryStore::default());
    rig.set(0);
    let status = rig.application.compensator.status();
    assert_eq!((status.running, status.taps), (false, [Taps::MIDDLE; 2]));
}

#[test]
fn an_acquisition_that_is_not_there_yet_when_power_comes_is_tried_again_each_second() {
    let sets = Sets::default();
    sets.missing.set(true);
    let mut rig = Rig::on(sets, Rig::storing([Mode::Hybrid; 2]));
    rig.application.compensator.tick();
    assert_eq!(rig.application.compensator.status().faults.acquisition_errors, 2);
    rig.sets.missing.set(false);
    rig.application.compensator.tick();
    rig.application.compensator.tick();
    assert_eq!(rig.application.compensator.status().faults.acquisition_errors, 3, "reached, and left alone");
    rig.set(0);
    assert_eq!(rig.writes()[2..], [(Axis::X, 500), (Axis::Y, 500)]);
}

#[test]
fn an_acquisition_that_is_not_there_yet_is_tried_between_ticks_until_it_was_reached_once() {
    let sets = Sets::default();
    sets.missing.set(true);
    let mut rig = Rig::on(sets, Rig::storing([Mode::Hybrid; 2]));
    let starts = |rig: &Rig| rig.sets.starts.get();
    (0..10).for_each(|_| rig.application.compensator.look(false));
    assert_eq!((starts(&rig), rig.application.compensator.status().faults.acquisition_errors), (11, 1));
    rig.sets.missing.set(false);
    rig.application.compensator.look(false);
    assert_eq!(starts(&rig), 12);
    rig.set(0);
    assert_eq!(rig.writes()[2..], [(Axis::X, 500), (Axis::Y, 500)]);
    assert_eq!(rig.application.compensator.status().faults.lost_sets, 0);
    // It dies, and does not answer: that is for the tick.
    rig.sets.missing.set(true);
    (0..5).for_each(|_| rig.application.compensator.tick());
    let tried = starts(&rig);
    assert!(tried > 12);
    rig.application.compensator.look(false);
    assert_eq!(starts(&rig), tried);
}

#[test]
fn a_set_that_waits_without_an_edge_is_taken_between_ticks() {
    let mut rig = Rig::starting_in([Mode::Hybrid; 2]);
    rig.sets.push(0, 8500, 8541);
    rig.application.compensator.look(false);
    assert_eq!(rig.application.compensator.status().sets, 0);
    rig.application.compensator.look(true);
    assert_eq!(rig.application.compensator.status().sets, 1);
}

#[test]
fn a_record_with_which_the_program_stops_three_times_in_a_row_is_set_aside_and_that_is_said() {
    let mut rig = Rig::starting_in([Mode::Hybrid; 2]);
    rig.set(0);
    for _ in 0..2 {
        rig.panic();
        assert_eq!(rig.calibration(), CalibrationState::InUse);
        assert_eq!(rig.application.compensator.status().taps.map(Taps::get), [500; 2], "held");
    }
    rig.panic();
    assert_eq!(rig.calibration(), CalibrationState::SetAside);
    let status = rig.application.compensator.status();
    assert_eq!((status.running, status.modes, status.taps), (false, [Mode::Off; 2], [Taps::MIDDLE; 2]));
    // However long a host has it work without, and whatever stops it then.
    rig.application.compensator.begin_alone();
    (0..AT_WORK).for_each(|number| rig.set(number));
    rig.panic();
    assert_eq!(rig.calibration(), CalibrationState::SetAside);
    // The power goes, and with it what was kept.
    rig.kept = Rc::default();
    rig.application = start(&rig.sets, &rig.part, &rig.store, &rig.kept);
    assert_eq!(rig.calibration(), CalibrationState::InUse);
}

#[test]
fn a_program_that_was_at_work_for_a_minute_between_its_faults_keeps_its_record() {
    let mut rig = Rig::starting_in([Mode::Hybrid; 2]);
    for _ in 0..5 {
        (0..AT_WORK).for_each(|number| rig.set(number));
        rig.panic();
    }
    assert_eq!(rig.calibration(), CalibrationState::InUse);
}

#[test]
fn a_board_says_where_its_program_stopped_itself_and_how_often_its_supply_has_dipped() {
    let mut rig = Rig::starting_in([Mode::Hybrid; 2]);
    assert_eq!(rig.ask(Request::Stop), Answer::Stop(None));
    rig.kept.dipped();
    rig.panic();
    rig.kept.dipped();
    assert_eq!(rig.identity().reset, ResetCause::Panic);
    assert_eq!(rig.ask(Request::Stop), Answer::Stop(Some(Stop::panic_at("src/lib.rs", 1))));
    let Answer::Faults(faults) = rig.ask(Request::Faults) else { panic!("the faults") };
    assert_eq!((faults.restarts, faults.supply_dips), (1, 2));
}

/// Counts how often it is fed.
#[derive(Clone, Default)]
struct Fed(Rc<Cell<u32>>);

impl Watchdog for Fed {
    fn feed(&mut self) {
        self.0.set(self.0.get() + 1);
    }
}

type TestCompensator = Compensator<Sets, Keeping<Part, Rc<Kept>>>;

/// A compensator whose interrupt comes whenever it likes.
struct Interrupted(Rc<RefCell<TestCompensator>>);

impl Shared for Interrupted {
    type Acquisition = Sets;
    type Part = Keeping<Part, Rc<Kept>>;
    type Memory = compensator::Memory;

    fn lock<R>(&mut self, act: impl FnOnce(&mut TestCompensator) -> R) -> R {
        act(&mut self.0.borrow_mut())
    }
}

/// What a host hears that asks without end while sets come, with each of them how often the watchdog had been fed.
fn asked_without_end(samples: SampleWindow) -> (Vec<Message>, Vec<u32>) {
    const SETS: u32 = 5;
    const QUESTIONS: u32 = 100;
    let (sets, fed) = (Sets::default(), Fed::default());
    let store = Rig::storing([Mode::Hybrid; 2]);
    let Application { compensator, mut task } =
        Application::start(parts(&sets, &Part::default(), &store, &Rc::default(), fed.clone()));
    let compensator = Rc::new(RefCell::new(compensator));
    let frame = |sequence, request| frame::encode(&Command { sequence, at: None, request }).unwrap().to_vec();
    let begins = frame(1, Request::SetStream { groups: true, samples });
    let mut feedings = Vec::new();
    let questions = (0..SETS * QUESTIONS).flat_map(|n| {
        if n % QUESTIONS == 0 {
            feedings.push(fed.0.get());
            sets.push(n / QUESTIONS, 8500, 8541);
            compensator.borrow_mut().service();
        }
        frame(2, Request::Faults)
    });
    let (mut receiver, mut heard) = (Receiver::new(), Vec::new());
    let mut line = |bytes: &[u8]| {
        let uploads = bytes.iter().filter_map(|&byte| receiver.push::<Upload>(byte));
        heard.extend(uploads.map(|upload| upload.unwrap().message));
        true
    };
    task.run(&mut Interrupted(Rc::clone(&compensator)), begins.into_iter().chain(questions), &mut line);
    (heard, feedings)
}

#[test]
fn a_host_that_asks_without_end_neither_starves_the_watchdog_nor_keeps_groups_back() {
    let (heard, feedings) = asked_without_end(SampleWindow::NONE);
    assert_eq!(feedings, [0, 1, 2, 3, 4], "once a set");
    let groups: Vec<usize> = (0..heard.len()).filter(|&index| matches!(heard[index], Message::Group(_))).collect();
    // The answer to the first command comes before, and each group after the first question that follows its set.
    assert_eq!(groups, [2, 103, 204, 305, 406]);
}

#[test]
fn samples_wait_for_a_host_that_asks_without_end_and_their_groups_come_with_the_next_set() {
    let (heard, feedings) = asked_without_end(SampleWindow::ALL);
    assert_eq!(feedings, [0, 1, 2, 3, 4]);
    let is_group = |message: &&Message| matches!(message, Message::Group(_));
    let asked_last = heard.iter().rposition(|message| matches!(message, Message::Answer { .. })).unwrap();
    let (while_asked, after) = heard.split_at(asked_last);
    assert_eq!(while_asked.iter().filter(is_group).count(), 4);
    assert!(!while_asked.iter().any(|message| matches!(message, Message::Samples(_))));
    assert!(matches!(after, [_, Message::Samples(_), .., Message::Group(_)]));
}
