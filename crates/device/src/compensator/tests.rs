use std::vec;
use std::vec::Vec;

use zerorate_core::compensate::LowPass;
use zerorate_core::record::{DeviceRecord, MAX_RECORD_BYTES, laws_for};
use zerorate_core::wire::SampleWindow;

use super::*;
use crate::tests::{Part, Sets, record, record_with};

mod scans;

fn laws(record: &DeviceRecord) -> Laws {
    laws_for(None, record.encode(&mut [0; MAX_RECORD_BYTES]).unwrap()).unwrap()
}

/// A compensator with its parts.
struct Rig {
    compensator: Compensator<Sets, Part>,
    sets: Sets,
    part: Part,
}

impl Rig {
    fn calibrated() -> Self {
        Self::with(LowPass::NONE)
    }

    /// One whose record knows a low-pass.
    fn with(low_pass: LowPass) -> Self {
        let mut rig = Self::blank();
        let record = record_with("u", low_pass);
        rig.compensator.install(&laws(&record));
        rig
    }

    fn blank() -> Self {
        let (sets, part) = (Sets::default(), Part::default());
        let compensator = Compensator::new(sets.clone(), part.clone(), Memory::new(), Timing::PAPER);
        part.writes.borrow_mut().clear();
        Self { compensator, sets, part }
    }

    fn order(&mut self, at: Option<u32>, action: Action) -> Vec<Report> {
        self.compensator.order(Scheduled { sequence: 1, at: at.map(GroupNumber), action });
        self.reports()
    }

    fn set(&mut self, number: u32, temperature: u16, zro: u16) -> Vec<Report> {
        self.sets.push(number, temperature, zro);
        self.compensator.service();
        self.reports()
    }

    fn reports(&mut self) -> Vec<Report> {
        core::iter::from_fn(|| self.compensator.next_report()).collect()
    }

    fn writes(&self) -> Vec<(Axis, u16)> {
        core::mem::take(&mut *self.part.writes.borrow_mut())
    }
}

fn done(group: u32) -> Report {
    Report::Done(1, (GroupNumber(group), Ok(())))
}

fn refused(group: u32, refusal: Refusal) -> Report {
    Report::Done(1, (GroupNumber(group), Err(refusal)))
}

#[test]
fn at_start_up_both_wipers_are_commanded_to_the_middle_tap() {
    let part = Part::default();
    let _ = Compensator::new(Sets::default(), part.clone(), Memory::new(), Timing::PAPER);
    assert_eq!(*part.writes.borrow(), [(Axis::X, 511), (Axis::Y, 511)]);
}

#[test]
fn both_wipers_are_written_with_every_group_and_a_tap_that_stays_is_no_move() {
    let mut rig = Rig::calibrated();
    assert_eq!(rig.order(None, Action::SetMode(Axis::X, Mode::Trim)), [done(0)]);
    rig.order(None, Action::SetAcquisition(true));
    // Not faster than a temperature moves.
    let groups = [(8500, 500, true), (8501, 500, false), (8600, 501, true), (8700, 502, true), (8701, 502, false)];
    for (number, (temperature, tap, moves)) in (0..).zip(groups) {
        let Report::Group(group) = &rig.set(number, temperature, 8541)[0] else { panic!("a group comes first") };
        assert_eq!(rig.writes(), [(Axis::X, tap), (Axis::Y, 511)]);
        assert_eq!(group.axes[0].moved_to, Taps::new(tap).filter(|_| moves));
        assert_eq!((group.axes[1].moved_to, group.axes[1].trim_failed), (None, false));
    }
}

#[test]
fn a_command_takes_effect_between_groups_and_says_from_which() {
    let mut rig = Rig::calibrated();
    rig.order(None, Action::SetAcquisition(true));
    rig.set(0, 9000, 8400);
    let tap = Action::SetTap(Axis::Y, Taps::new(600).unwrap());
    assert_eq!(rig.order(Some(3), tap), [], "not yet");
    assert_eq!(rig.set(1, 9000, 8400).len(), 1);
    assert!(!rig.writes().contains(&(Axis::Y, 600)));
    let reports = rig.set(2, 9000, 8400);
    assert_eq!(reports[1], done(3));
    assert_eq!(rig.writes(), [(Axis::X, 511), (Axis::Y, 511), (Axis::Y, 600)]);
    let Report::Group(group) = &rig.set(3, 9000, 8400)[0] else { panic!("a group comes first") };
    assert_eq!(group.axes[1].tap.get(), 600);
    // Too late for group 2: it holds from the next.
    rig.order(Some(2), tap);
    assert_eq!(rig.set(4, 9000, 8400)[1], done(5));
}

#[test]
fn without_a_calibration_nothing_but_off_is_accepted() {
    let mut rig = Rig::blank();
    for mode in [Mode::Trim, Mode::Digital, Mode::Hybrid] {
        assert_eq!(rig.order(None, Action::SetMode(Axis::X, mode)), [refused(0, Refusal::NoCalibration)]);
    }
    assert_eq!(rig.order(None, Action::SetMode(Axis::X, Mode::Off)), [done(0)]);
}

#[test]
fn an_unplugged_potentiometer_is_counted_and_written_again_at_the_next_group() {
    let mut rig = Rig::calibrated();
    rig.order(None, Action::SetMode(Axis::X, Mode::Trim));
    rig.order(None, Action::SetAcquisition(true));
    rig.part.unplugged.set(true);
    let Report::Group(group) = &rig.set(0, 8500, 8541)[0] else { panic!("a group comes first") };
    assert_eq!(group.axes[0].moved_to, None, "a write that failed is no move");
    assert_eq!(rig.compensator.status().faults.trim_errors, 2, "neither wiper was written");
    assert_eq!(rig.order(None, Action::StorePowerUpTap), []);
    assert_eq!(rig.set(1, 8500, 8541)[1], refused(2, Refusal::TrimPartFailed));
    rig.part.unplugged.set(false);
    rig.set(2, 8500, 8541);
    assert_eq!(rig.writes(), [(Axis::X, 500), (Axis::Y, 511)]);
}

#[test]
fn recalled_wipers_are_left_alone_until_they_are_told_to_move() {
    let mut rig = Rig::calibrated();
    rig.order(None, Action::SetMode(Axis::X, Mode::Trim));
    rig.order(None, Action::SetAcquisition(true));
    rig.set(0, 8500, 8541);
    rig.order(None, Action::RecallPowerUpTap);
    assert_eq!(rig.set(1, 8500, 8541)[1], done(2));
    rig.writes();
    rig.set(2, 8500, 8541);
    rig.set(3, 8700, 8541);
    assert_eq!((rig.part.recalls.get(), rig.writes(), rig.compensator.status().modes), (1, vec![], [Mode::Off; 2]));
    rig.order(None, Action::SetTap(Axis::X, Taps::MIDDLE));
    rig.set(4, 8500, 8541);
    assert_eq!(rig.writes(), [(Axis::X, 511)], "Y was not told to move");
    rig.order(None, Action::SetMode(Axis::Y, Mode::Off));
    rig.set(5, 8500, 8541);
    rig.writes();
    rig.set(6, 8500, 8541);
    assert_eq!(rig.writes(), [(Axis::X, 511), (Axis::Y, 511)]);
}

#[test]
fn lost_sets_are_counted_and_the_groups_keep_their_numbers() {
    let mut rig = Rig::calibrated();
    rig.order(None, Action::SetAcquisition(true));
    rig.set(0, 9000, 8400);
    let Report::Group(group) = &rig.set(4, 9000, 8400)[0] else { panic!("a group comes first") };
    assert_eq!(group.group, GroupNumber(4));
    assert_eq!(rig.compensator.status().faults.lost_sets, 3);
    assert_eq!(rig.compensator.status().group, GroupNumber(5));
}

#[test]
fn every_sample_is_reported_when_asked_for_with_its_correction() {
    let mut rig = Rig::calibrated();
    rig.order(None, Action::SetMode(Axis::X, Mode::Digital));
    rig.order(None, Action::SetSamples(SampleWindow::ALL));
    rig.order(None, Action::SetAcquisition(true));
    rig.set(0, 8500, 8541);
    let reports = rig.set(1, 8500, 8541);
    let corrected: Vec<f64> = reports
        .iter()
        .filter_map(|report| match report {
            Report::Samples(block) if block.axis == Axis::X => Some(block),
            _ => None,
        })
        .flat_map(|block| block.samples.iter().map(|s| f64::from(s.corrected_q16) / 65_536.0))
        .collect();
    assert_eq!(corrected.len(), 500);
    assert!(corrected.iter().all(|c| (c - 8200.0).abs() < 1.0), "8541 is the drift at 8500");
}

/// Axis, first index and number of the blocks of samples.
fn blocks(reports: &[Report]) -> Vec<(Axis, u16, usize)> {
    reports
        .iter()
        .filter_map(|report| match report {
            Report::Samples(block) => Some((block.axis, block.index, block.samples.len())),
            _ => None,
        })
        .collect()
}

#[test]
fn a_window_of_samples_is_the_same_as_in_the_whole_group() {
    let mut whole = Rig::calibrated();
    let mut part = Rig::calibrated();
    let window = SampleWindow { axes: [false, true], first: 60, last: 20 };
    for (rig, window) in [(&mut whole, SampleWindow::ALL), (&mut part, window)] {
        rig.order(None, Action::SetMode(Axis::Y, Mode::Hybrid));
        rig.order(None, Action::SetSamples(window));
        rig.order(None, Action::SetAcquisition(true));
        rig.set(0, 8500, 8541);
    }
    let (all, some) = (whole.set(1, 8500, 8541), part.set(1, 8500, 8541));
    assert_eq!(blocks(&some), [(Axis::Y, 0, 25), (Axis::Y, 25, 25), (Axis::Y, 50, 10), (Axis::Y, 480, 20)]);
    assert_eq!(blocks(&all).len(), 40);
    let sample = |reports: &[Report], index: u16| {
        reports.iter().find_map(|report| match report {
            Report::Samples(block) if block.axis == Axis::Y && block.index <= index => {
                block.samples.get(usize::from(index - block.index)).copied()
            }
            _ => None,
        })
    };
    for index in (0..60).chain(480..500) {
        assert_eq!(sample(&all, index), sample(&some, index), "sample {index}");
        assert!(sample(&some, index).is_some());
    }
    assert_eq!(all.last(), some.last(), "the group follows its samples");
    assert!(matches!(all.last(), Some(Report::Group(_))));
}

#[test]
fn samples_that_a_new_set_overtakes_are_counted_and_their_group_is_reported() {
    let mut rig = Rig::calibrated();
    rig.order(None, Action::SetSamples(SampleWindow::ALL));
    rig.order(None, Action::SetAcquisition(true));
    rig.sets.push(0, 9000, 8400);
    rig.compensator.service();
    // Three are fetched, and nobody goes on.
    let fetched: Vec<Report> = (0..3).filter_map(|_| rig.compensator.next_report()).collect();
    assert_eq!(blocks(&fetched).len(), 3);
    let reports = rig.set(1, 9000, 8400);
    assert!(matches!(&reports[0], Report::Group(group) if group.group == GroupNumber(0)));
    assert_eq!(rig.compensator.status().faults.dropped_uploads, 37);
    assert_eq!(blocks(&reports).len(), 40);
}

#[test]
fn scans_that_cannot_be_read_cost_their_samples_and_not_their_group() {
    let mut rig = Rig::calibrated();
    rig.order(None, Action::SetSamples(SampleWindow::ALL));
    rig.order(None, Action::SetAcquisition(true));
    rig.sets.scans_missing.set(true);
    let [Report::Group(group)] = &rig.set(0, 9000, 8400)[..] else { panic!("the group alone") };
    assert_eq!((group.group, group.axes[0].sums.n), (GroupNumber(0), 500));
    assert_eq!(rig.writes().len(), 2, "both wipers");
    let faults = rig.compensator.status().faults;
    assert_eq!((faults.acquisition_errors, faults.dropped_uploads, faults.lost_sets), (2, 1, 0));
    // The set was let go.
    rig.compensator.tick();
    assert_eq!(rig.reports(), []);
    rig.sets.scans_missing.set(false);
    assert_eq!(blocks(&rig.set(1, 9000, 8400)).len(), 40);
}

#[test]
fn a_set_that_came_bent_still_waits_and_is_read_once_more_and_with_each_tick() {
    for window in [SampleWindow::NONE, SampleWindow::ALL] {
        for (bent, ticks) in [(1, 0), (2, 1), (5, 2)] {
            let mut rig = Rig::calibrated();
            rig.order(None, Action::SetSamples(window));
            rig.order(None, Action::SetAcquisition(true));
            rig.sets.bent.set(bent);
            let mut reports = rig.set(0, 9000, 8400);
            for _ in 0..ticks {
                assert_eq!(reports, []);
                rig.compensator.tick();
                reports = rig.reports();
            }
            let [.., Report::Group(group)] = &reports[..] else { panic!("{bent} times bent: no group") };
            assert_eq!((group.group, group.acquisition_errors), (GroupNumber(0), bent));
            assert_eq!(blocks(&reports).len(), if window.is_open() { 40 } else { 0 });
            assert!(rig.sets.waiting.borrow().is_empty(), "it was let go");
        }
    }
}

#[test]
fn a_set_that_comes_in_the_place_of_one_that_was_read_is_not_let_go_unseen() {
    let mut rig = Rig::calibrated();
    rig.order(None, Action::SetAcquisition(true));
    *rig.sets.overtaking.borrow_mut() = Some(Sets::set(1, 9001, 8400));
    let groups = rig.set(0, 9000, 8400).len();
    assert_eq!((groups, rig.compensator.status().faults.lost_sets), (2, 0));
    assert_eq!((rig.compensator.status().group, rig.compensator.status().sets), (GroupNumber(2), 2));
}

#[test]
fn groups_that_nobody_fetches_are_counted_not_waited_for_and_leave_room_for_every_answer() {
    let mut rig = Rig::calibrated();
    rig.order(None, Action::SetAcquisition(true));
    for sequence in 0..7 {
        let tap = Action::SetTap(Axis::Y, Taps::new(500 + sequence).unwrap());
        rig.compensator.order(Scheduled { sequence, at: Some(GroupNumber(20)), action: tap });
    }
    for number in 0..30 {
        rig.sets.push(number, 9000, 8400);
        rig.compensator.service();
    }
    assert_eq!(rig.compensator.status().faults.dropped_uploads, 30 - 11);
    let reports = rig.reports();
    let answered = reports.iter().filter_map(|report| match report {
        Report::Done(sequence, outcome) => Some((*sequence, *outcome)),
        _ => None,
    });
    assert!(answered.eq((0..7).map(|sequence| (sequence, (GroupNumber(20), Ok(()))))));
    assert_eq!(reports.len(), 11 + 7);
}

#[test]
fn the_status_says_taps_modes_and_whether_sets_arrive() {
    let mut rig = Rig::calibrated();
    assert_eq!((rig.compensator.status().running, rig.compensator.status().sets), (false, 0));
    rig.order(None, Action::SetMode(Axis::X, Mode::Trim));
    rig.order(None, Action::SetAcquisition(true));
    rig.set(0, 8500, 8541);
    let status = rig.compensator.status();
    assert_eq!((status.running, status.sets), (true, 1));
    assert_eq!(status.modes, [Mode::Trim, Mode::Off]);
    assert_eq!(status.taps.map(Taps::get), [500, 511]);
}

#[test]
fn commands_that_wait_when_the_acquisition_stops_are_answered() {
    let mut rig = Rig::calibrated();
    rig.order(None, Action::SetAcquisition(true));
    let tap = Action::SetTap(Axis::Y, Taps::new(600).unwrap());
    assert_eq!(rig.order(Some(900), tap), []);
    assert_eq!(rig.order(None, Action::SetAcquisition(false)), [refused(0, Refusal::Stopped), done(0)]);
    assert_eq!(rig.writes(), []);
}

#[test]
fn after_a_restart_the_wipers_are_held_until_the_first_group_and_then_written_what_they_should_have() {
    let mut rig = Rig::blank();
    let taps = [500, 512].map(|tap| Taps::new(tap).unwrap());
    rig.compensator = Compensator::holding(rig.sets.clone(), rig.part.clone(), Memory::new(), Timing::PAPER, taps);
    let record = record("u");
    rig.compensator.install(&laws(&record));
    rig.compensator.set_modes([Mode::Hybrid, Mode::Off]);
    rig.compensator.begin_alone();
    assert_eq!(rig.writes(), []);
    assert_eq!(rig.compensator.status().taps, taps);
    rig.set(0, 8500, 8200);
    assert_eq!(rig.writes(), [(Axis::X, 500), (Axis::Y, 512)]);
    assert_eq!(rig.compensator.status().taps.map(Taps::get), [500, 512]);
}
