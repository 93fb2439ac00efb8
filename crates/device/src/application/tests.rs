use std::rc::Rc;
use std::vec::Vec;

use zerorate_core::compensate::Mode;
use zerorate_core::record::MAX_RECORD_BYTES;
use zerorate_core::units::{Axis, Taps};

use super::*;
use crate::tests::{MemoryStore, Part, Sets, record};
use crate::watchdog::NoWatchdog;

/// A board whose power has just come, with its sets and its potentiometer.
struct Rig {
    application: Application<Sets, Part, MemoryStore, NoWatchdog, Rc<Kept>>,
    sets: Sets,
    part: Part,
}

impl Rig {
    fn starting_in(modes: [Mode; 2]) -> Self {
        let mut record = record("u");
        for (axis, mode) in record.axes.iter_mut().zip(modes) {
            axis.start_up_mode = mode;
        }
        let mut store = MemoryStore::default();
        store.commit(record.encode(&mut [0; MAX_RECORD_BYTES]).unwrap()).unwrap();
        Self::with(store)
    }

    fn with(store: MemoryStore) -> Self {
        let (sets, part) = (Sets::default(), Part::default());
        let application = Application::start(Parts {
            acquisition: sets.clone(),
            trim: part.clone(),
            store,
            watchdog: NoWatchdog,
            kept: Rc::new(Kept::default()),
            by_watchdog: false,
            unit: UnitSerial::default(),
            timing: Timing::PAPER,
        });
        Self { application, sets, part }
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
