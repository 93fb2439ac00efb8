use std::rc::Rc;
use std::vec::Vec;

use zerorate_core::compensate::Mode;
use zerorate_core::record::MAX_RECORD_BYTES;
use zerorate_core::units::{Axis, Taps};
use zerorate_core::wire::frame::{self, Receiver};
use zerorate_core::wire::{Answer, CalibrationState, Command, Identity, Message, Request, ResetCause, Stop, Upload};

use super::*;
use crate::restart::Reset;
use crate::tests::{MemoryStore, Part, Sets, record};
use crate::watchdog::NoWatchdog;

type TestApplication = Application<Sets, Part, MemoryStore, NoWatchdog, Rc<Kept>>;

fn start(sets: &Sets, part: &Part, store: &MemoryStore, kept: &Rc<Kept>) -> TestApplication {
    Application::start(Parts {
        acquisition: sets.clone(),
        trim: part.clone(),
        store: store.clone(),
        watchdog: NoWatchdog,
        kept: Rc::clone(kept),
        started: kept.started(Reset::Untold),
        unit: UnitSerial::default(),
        timing: Timing::PAPER,
        board: BoardNumbers::PAPER,
        health: Health::default,
    })
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
