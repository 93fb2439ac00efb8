//! Faults of the acquisition, put there through the simulated bench and seen from the host: what is done, what is counted,
//! what is said. None moves a wiper.

#![allow(clippy::unwrap_used)] // what a test cannot do without

mod at_work;

use at_work::Rig;
use zerorate_core::compensate::Mode;
use zerorate_core::units::{Axis, Taps};
use zerorate_core::wire::{CalibrationState, Request, ResetCause, SampleWindow};
use zerorate_sim::Fault;

#[test]
fn an_overrun_loses_groups_which_are_counted_and_named_and_throws_nothing() {
    let mut rig = Rig::at_work();
    let before = rig.groups(5);
    rig.inject(Fault::Overrun { sets: 3 });
    let after = rig.groups(3);
    assert_eq!((before[4].group.0, after[0].group.0, after[0].lost), (4, 8, 3));
    assert_eq!(rig.device.take_lost_groups(), [5..=7]);
    assert_eq!(rig.device.faults().unwrap().lost_sets, 3);
    assert_eq!(after[2].axes[0].tap, before[4].axes[0].tap);
}

#[test]
fn a_failed_read_of_a_set_is_tried_again_and_a_dead_bus_loses_groups_by_name() {
    let mut rig = Rig::at_work();
    rig.groups(5);
    rig.inject(Fault::PortSpi { transfers: 1 });
    let again = rig.group();
    assert_eq!((again.group.0, again.acquisition_errors), (5, 1), "the same set, a little later");
    // Its edge asks for a set, and from then on each tick.
    rig.inject(Fault::PortSpi { transfers: 8 });
    let after = rig.groups(2);
    assert_eq!(after[0].group.0, 7, "a set could not be read before the next was full");
    assert_eq!(rig.device.take_lost_groups(), [6..=6]);
    let faults = rig.device.faults().unwrap();
    assert_eq!((faults.acquisition_errors, faults.lost_sets), (9, 1));
}

#[test]
fn a_set_whose_edge_was_served_in_vain_is_taken_with_the_next_tick() {
    let mut rig = Rig::at_work();
    rig.groups(5);
    // STATUS says that nothing waits; the line stays high, and no edge comes again.
    rig.inject(Fault::MutePort { transfers: 1 });
    let groups = rig.groups(3);
    assert_eq!(groups.iter().map(|group| group.group.0).collect::<Vec<_>>(), [5, 6, 7]);
    assert_eq!(rig.device.faults().unwrap(), Default::default());
}

#[test]
fn an_acquisition_that_forgets_its_work_is_set_up_anew_while_a_host_talks_and_the_groups_go_on() {
    let mut rig = Rig::at_work();
    rig.groups(5);
    let held = Axis::BOTH.map(|axis| rig.wiper(axis));
    rig.plant.borrow_mut().reset_port();
    let next = loop {
        assert!(rig.plant.borrow().time().0 < 15.0, "no set since 7.5 s");
        assert_eq!(rig.device.faults().unwrap().restarts, 0);
        if let Ok(group) = rig.device.next_group() {
            break group.report;
        }
    };
    assert_eq!((next.group.0, next.lost), (7, 2), "two periods without a set");
    assert_eq!(rig.device.take_lost_groups(), [5..=6]);
    let faults = rig.device.faults().unwrap();
    assert_eq!((faults.acquisition_errors, faults.lost_sets, faults.restarts), (1, 2, 0));
    assert_eq!(Axis::BOTH.map(|axis| rig.wiper(axis)), held);
    assert_eq!(rig.groups(2).iter().map(|group| group.group.0).collect::<Vec<_>>(), [8, 9]);
}

#[test]
fn sets_that_stop_coming_end_in_a_restart_after_which_the_device_compensates_again() {
    let mut rig = Rig::at_work();
    rig.groups(5);
    let held = Axis::BOTH.map(|axis| rig.wiper(axis));
    assert_ne!(held[0], Taps::MIDDLE.get());
    rig.inject(Fault::NoScans);
    for _ in 0..6 {
        assert!(rig.device.next_group().is_err());
        // A host that talks all the while keeps no watchdog quiet.
        let _ = rig.device.faults();
    }
    assert_eq!(Axis::BOTH.map(|axis| rig.wiper(axis)), held, "a restart moves no wiper");
    rig.plant.borrow_mut().clear_faults();
    rig.device.restarted();
    let identity = rig.device.identify().unwrap();
    assert_eq!(identity.reset, ResetCause::Watchdog);
    assert_eq!((identity.calibration, identity.running), (CalibrationState::InUse, true));
    assert_eq!(identity.modes, [Mode::Hybrid; 2], "those of start-up");
    assert_eq!(rig.device.faults().unwrap().restarts, 1);
    rig.device.order(Request::SetStream { groups: true, samples: SampleWindow::NONE }).unwrap();
    let groups = rig.groups(3);
    assert_eq!(groups[2].axes[0].tap, rig.asked(&groups[1], Axis::X), "it goes on by itself");
}
