//! Each scan as it comes: corrected as its group has it, and what is told with it.

use zerorate_core::group::GroupSums;

use super::*;
use crate::acquisition::NumberedScan;

/// Readings that no two neighbours share.
fn reading(scan: u32) -> u16 {
    8541 + u16::try_from(scan * 7919 % 13).unwrap()
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
    let give = |rig: &mut Rig, number| {
        rig.sets.latest.set(Some(NumberedScan { number, scan: scan(number) }));
        rig.compensator.scan()
    };
    let last = numbers.end - 1;
    let mut reported: Vec<ScanReport> = numbers.clone().filter_map(|k| (k != last).then(|| give(rig, k))?).collect();
    if !last_comes_late {
        reported.extend(give(rig, last));
    }
    let scans = numbers.map(scan).collect();
    rig.sets.waiting.borrow_mut().push_back(Set { number: set, lost: 0, sums, scans });
    rig.compensator.service();
    if last_comes_late {
        reported.extend(give(rig, last));
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

#[test]
fn the_samples_of_a_group_whose_scans_all_came_one_by_one_are_not_read_again() {
    let mut rig = Rig::calibrated();
    rig.order(None, Action::SetSamples(SampleWindow::ALL));
    rig.order(None, Action::SetAcquisition(true));
    rig.sets.scans_missing.set(true);
    let samples = |reports: &[Report]| reports.iter().filter(|report| matches!(report, Report::Samples(_))).count();
    let (_, reports) = set_of_scans(&mut rig, 0, 8500, false);
    assert_eq!((samples(&reports), rig.compensator.status().faults.dropped_uploads), (40, 0));
    // The last one is still to come when the set is served: they would have to be read.
    let (_, reports) = set_of_scans(&mut rig, 1, 8501, true);
    assert_eq!((samples(&reports), rig.compensator.status().faults.dropped_uploads), (0, 1));
    let (_, reports) = set_of_scans(&mut rig, 2, 8502, false);
    assert_eq!(samples(&reports), 40);
}
