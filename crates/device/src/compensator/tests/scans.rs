//! Each scan as it comes: corrected as its group has it, and what is told with it.

use zerorate_core::group::GroupSums;

use super::*;
use crate::acquisition::{NumberedScan, Set};

/// Readings that no two neighbours share.
fn reading(scan: u32) -> u16 {
    8541 + u16::try_from(scan * 7919 % 13).unwrap()
}

/// The scan of a number is taken.
fn taken(rig: &Rig, number: u32, scan: [u16; 4]) {
    rig.sets.latest.set(Some(NumberedScan { number, scan }));
}

/// A set of such readings, its scans given one by one before it, or the last of them only after it was served.
fn set_of_scans(rig: &mut Rig, set: u32, temperature: u16, last_comes_late: bool) -> (Vec<ScanReport>, Vec<Report>) {
    let scan = |k: u32| [temperature, reading(k), temperature, 8000 + reading(k) % 5];
    let numbers = 500 * set..500 * (set + 1);
    let mut sums = [GroupSums::default(); 2];
    numbers.clone().map(scan).for_each(|[tx, x, ty, y]| {
        sums[0].push(tx, x);
        sums[1].push(ty, y);
    });
    let last = numbers.end - 1;
    let mut reported = Vec::new();
    for number in numbers.clone() {
        taken(rig, number, scan(number));
        if number != last || !last_comes_late {
            reported.extend(rig.compensator.scan());
        }
    }
    let scans = numbers.map(scan).collect();
    rig.sets.waiting.borrow_mut().push_back(Set { number: set, lost: 0, sums, scans });
    rig.compensator.service();
    if last_comes_late {
        reported.extend(rig.compensator.scan());
    }
    (reported, rig.reports())
}

#[test]
fn each_scan_is_corrected_to_the_bits_of_the_sample_that_its_group_reports_later() {
    let low_pass = LowPass::first_order(40.0, 0.003, 0.0001);
    let mut rig = Rig::with(low_pass);
    for (axis, mode) in [(Axis::X, Mode::Hybrid), (Axis::Y, Mode::Digital)] {
        rig.order(None, Action::SetMode(axis, mode));
    }
    rig.order(None, Action::SetSamples(SampleWindow::ALL));
    rig.order(None, Action::SetAcquisition(true));
    let (mut taps, mut settling) = (Vec::new(), 0);
    // Not faster than a temperature moves.
    for (set, temperature) in (0..8).zip((8500..).step_by(100)) {
        let (scans, reports) = set_of_scans(&mut rig, set, temperature, set % 3 == 2);
        assert_eq!(
            scans.iter().map(|report| report.scan).collect::<Vec<_>>(),
            (500 * set..500 * (set + 1)).collect::<Vec<_>>()
        );
        settling += scans.iter().filter(|report| report.axes[0].flags.has(ScanFlags::SETTLING)).count();
        for axis in Axis::BOTH {
            let samples: Vec<i32> = reports
                .iter()
                .filter_map(|report| match report {
                    Report::Samples(block) if block.axis == axis => Some(block.samples.iter()),
                    _ => None,
                })
                .flatten()
                .map(|sample| sample.corrected_q16)
                .collect();
            let one_by_one: Vec<i32> = scans.iter().map(|report| report.axes[axis.index()].corrected_q16).collect();
            assert_eq!(one_by_one, samples, "set {set}, {}", axis.name());
        }
        taps.extend(rig.writes().into_iter().filter(|&(axis, _)| axis == Axis::X));
    }
    taps.dedup();
    assert!(taps.len() > 4 && settling > 20, "{taps:?}, {settling} scans in which X's wiper was on its way");
}

#[test]
fn a_scan_that_was_missed_passes_in_the_settling_all_the_same_and_none_is_reported_twice() {
    let low_pass = LowPass::first_order(40.0, 0.003, 0.0001);
    let [mut all, mut some] = [(); 2].map(|()| Rig::with(low_pass));
    for rig in [&mut all, &mut some] {
        rig.order(None, Action::SetMode(Axis::X, Mode::Hybrid));
        rig.order(None, Action::SetAcquisition(true));
        set_of_scans(rig, 0, 8500, false);
    }
    let give = |rig: &mut Rig, number| {
        rig.sets.latest.set(Some(NumberedScan { number, scan: [8500, 8541, 8500, 8541] }));
        rig.compensator.scan()
    };
    for number in 500..540 {
        let report = give(&mut all, number);
        if number % 7 == 3 {
            assert_eq!(give(&mut some, number), report);
            assert_eq!(give(&mut some, number), None, "read again");
        }
    }
    some.sets.missing.set(true);
    assert_eq!(give(&mut some, 540), None);
    assert_eq!(some.compensator.status().faults.acquisition_errors, 2, "read once more");
}

#[test]
fn a_scan_says_in_its_flags_whether_the_law_is_in_force_and_its_temperature_believed() {
    let mut rig = Rig::calibrated();
    rig.order(None, Action::SetMode(Axis::X, Mode::Digital));
    assert_eq!(rig.compensator.scan(), None, "the acquisition stands still");
    rig.order(None, Action::SetAcquisition(true));
    assert_eq!(rig.compensator.scan(), None, "none was taken");
    let flags = |rig: &mut Rig, number, zro| {
        rig.sets.latest.set(Some(NumberedScan { number, scan: [8500, zro, 8500, 8541] }));
        rig.compensator.scan().unwrap().axes.map(|axis| axis.flags)
    };
    let (digital, off) = (ScanFlags::of(Mode::Digital), ScanFlags::of(Mode::Off));
    assert_eq!(flags(&mut rig, 0, 8541), [digital, off], "no temperature yet");
    rig.set(0, 8500, 8541);
    let at_work = digital.and(ScanFlags::AT_WORK);
    assert_eq!(flags(&mut rig, 500, 8541), [at_work, off]);
    assert_eq!(flags(&mut rig, 501, 16_383), [at_work.and(ScanFlags::SATURATED), off]);
    assert_eq!(flags(&mut rig, 502, 73), [at_work.and(ScanFlags::SATURATED), off], "the amplifier's rail");
    assert_eq!(flags(&mut rig, 503, 81), [at_work, off]);
    rig.set(1, 12_000, 8541);
    assert_eq!(flags(&mut rig, 1000, 8541), [at_work.and(ScanFlags::HELD), off.and(ScanFlags::HELD)], "it jumped");
    // By more than a last bit, or it stands still.
    (2..4).for_each(|number| _ = rig.set(number, 11_996 + 4 * u16::try_from(number).unwrap(), 8541));
    assert_eq!(flags(&mut rig, 2000, 0)[0], at_work.and(ScanFlags::OUTSIDE).and(ScanFlags::SATURATED));
}

#[test]
fn a_board_that_begins_alone_takes_a_short_group_first_and_a_host_s_groups_are_all_alike() {
    let mut rig = Rig::calibrated();
    rig.compensator.set_modes([Mode::Hybrid; 2]);
    rig.sets.missing.set(true);
    rig.compensator.begin_alone();
    rig.sets.missing.set(false);
    rig.compensator.tick();
    assert_eq!(rig.sets.first.get(), 50, "tried again, and no group taken yet");
    // Scan 50 is the second group's first.
    let give = |rig: &mut Rig, number| {
        rig.sets.latest.set(Some(NumberedScan { number, scan: [8500, 8541, 8500, 8541] }));
        rig.compensator.scan().unwrap().axes[0].flags
    };
    assert!(!give(&mut rig, 48).has(ScanFlags::AT_WORK));
    rig.set(0, 8500, 8541);
    assert!(rig.writes().contains(&(Axis::X, 500)) && give(&mut rig, 50).has(ScanFlags::AT_WORK));
    // The acquisition dies, and is set up anew.
    (0..5).for_each(|_| rig.compensator.tick());
    assert_eq!(rig.sets.first.get(), 500);
    rig.order(None, Action::SetAcquisition(true));
    assert_eq!(rig.sets.first.get(), 500);
}

fn samples(reports: &[Report]) -> usize {
    reports.iter().filter(|report| matches!(report, Report::Samples(_))).count()
}

/// A board whose samples are asked for, and cannot be read from its port.
fn with_samples_one_by_one() -> Rig {
    let mut rig = Rig::calibrated();
    rig.order(None, Action::SetSamples(SampleWindow::ALL));
    rig.order(None, Action::SetAcquisition(true));
    rig.sets.scans_missing.set(true);
    rig
}

#[test]
fn the_samples_of_a_group_whose_scans_all_came_one_by_one_are_not_read_again() {
    let mut rig = with_samples_one_by_one();
    for set in 0..3 {
        // The last one of the second set is still to be read when the set is served.
        let (scans, reports) = set_of_scans(&mut rig, set, 8500, set == 1);
        assert_eq!((scans.len(), samples(&reports)), (500, 40));
    }
    let faults = rig.compensator.status().faults;
    assert_eq!((faults.dropped_uploads, faults.acquisition_errors), (0, 0));
}

#[test]
fn a_scan_that_was_missed_costs_the_samples_of_its_group_alone() {
    for missed in [0, 250, 498] {
        let mut rig = with_samples_one_by_one();
        set_of_scans(&mut rig, 0, 8500, false);
        // Group 1 as it should be, but for one of its scans.
        for number in (500..1000).filter(|number| number - 500 != missed) {
            taken(&rig, number, [8500, 8541, 8500, 8541]);
            assert!(rig.compensator.scan().is_some());
        }
        let reports = rig.set(1, 8500, 8541);
        assert!(matches!(reports[..], [Report::Group(_)]), "scan {missed}");
        for set in 2..5 {
            let (scans, reports) = set_of_scans(&mut rig, set, 8500, false);
            assert_eq!((scans.len(), samples(&reports)), (500, 40), "set {set} after scan {missed}");
        }
        let faults = rig.compensator.status().faults;
        assert_eq!((faults.dropped_uploads, faults.acquisition_errors, faults.lost_sets), (1, 0, 0));
    }
}

#[test]
fn a_set_that_is_served_late_has_all_its_samples_and_so_has_the_next() {
    let mut rig = with_samples_one_by_one();
    rig.sets.push(0, 8500, 8541);
    let give = |rig: &mut Rig, numbers: core::ops::Range<u32>| {
        for number in numbers {
            taken(rig, number, [8500, 8541, 8500, 8541]);
            assert!(rig.compensator.scan().is_some());
        }
    };
    give(&mut rig, 0..507);
    rig.compensator.service();
    assert_eq!(samples(&rig.reports()), 40);
    give(&mut rig, 507..1000);
    assert_eq!(samples(&rig.set(1, 8500, 8541)), 40);
    // Later than there is room for: then the next one is not whole.
    give(&mut rig, 1000..1520);
    assert_eq!(samples(&rig.set(2, 8500, 8541)), 40);
    give(&mut rig, 1520..2000);
    assert_eq!(samples(&rig.set(3, 8500, 8541)), 0);
    give(&mut rig, 2000..2500);
    assert_eq!(samples(&rig.set(4, 8500, 8541)), 40);
}

#[test]
fn where_scans_stop_coming_samples_are_read_from_the_port_again() {
    let mut rig = with_samples_one_by_one();
    rig.sets.scans_missing.set(false);
    set_of_scans(&mut rig, 0, 8500, false);
    taken(&rig, 500, [8500, 8541, 8500, 8541]);
    assert!(rig.compensator.scan().is_some());
    assert_eq!(samples(&rig.set(1, 8500, 8541)), 0);
    assert_eq!(samples(&rig.set(2, 8500, 8541)), 40);
}

#[test]
fn scans_go_on_where_their_numbers_go_round() {
    let mut rig = Rig::calibrated();
    rig.order(None, Action::SetMode(Axis::X, Mode::Digital));
    rig.order(None, Action::SetAcquisition(true));
    rig.set(0, 8500, 8541);
    // 149 days of 3 ms.
    let last_set = u32::MAX / 500 - 1;
    taken(&rig, 500 * last_set, [8500, 8541, 8500, 8541]);
    assert!(rig.compensator.scan().is_some());
    rig.set(last_set, 8500, 8541);
    for number in [u32::MAX - 1, u32::MAX, 0, 1, 3] {
        taken(&rig, number, [8500, 8541, 8500, 8541]);
        assert_eq!(rig.compensator.scan().map(|report| report.scan), Some(number));
        assert_eq!(rig.compensator.scan(), None, "read again");
    }
    // The set in which they do: the port numbers its scans on from there.
    rig.set(last_set + 1, 8500, 8541);
    taken(&rig, 500_u32.wrapping_mul(last_set + 2), [8500, 8541, 8500, 8541]);
    assert!(rig.compensator.scan().is_some());
}
