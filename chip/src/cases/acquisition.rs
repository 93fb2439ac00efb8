//! Faults of the acquisition, put there through the plant.

use anyhow::{Result, ensure};
use zerorate_core::units::Axis;
use zerorate_core::wire::{Answer, CalibrationState, FaultCounts, Refusal, Request, ResetCause, SampleWindow};
use zerorate_sim::Fault;

use super::{Given, consecutive, just_before_a_set, wipers};
use crate::chip::board::Cut;
use crate::chip::rcc::Reset;
use crate::chip::time::{MILLISECOND, SECOND, Ticks, milliseconds};

/// From one look at data ready's level to the next, and the reading.
const LOOK: Ticks = 21 * MILLISECOND;

/// STATUS read as zeros: no edge comes again, and the next look at the line's level takes the set.
pub fn served_in_vain(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    just_before_a_set(&mut bench)?;
    bench.plant.borrow_mut().inject(Fault::MutePort { transfers: 1 });
    bench.machine.chip().board.written_after.clear();
    let groups = bench.groups(3)?;
    consecutive(&groups)?;
    let late = bench.machine.chip().board.written_after.iter().copied().max().unwrap_or(0);
    ensure!(late > MILLISECOND && late <= LOOK, "taken {:.1} ms after its last scan", milliseconds(late));
    let faults = bench.faults()?;
    ensure!(
        faults == FaultCounts { repeated_commands: faults.repeated_commands, ..FaultCounts::default() },
        "{faults:?}"
    );
    bench.nothing_wrong()?;
    Ok(format!("taken by its level, {:.1} ms after its last scan; no group lost", milliseconds(late)))
}

/// The burst read as zeros: read once more at once.
pub fn damaged_set(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    just_before_a_set(&mut bench)?;
    // Within the burst, whose STATUS has taken six bytes.
    bench.machine.chip().board.cut = Some(Cut { after: 8 * 20, lasts: None });
    let groups = bench.groups(3)?;
    consecutive(&groups)?;
    let errors = bench.faults()?.acquisition_errors;
    ensure!(errors == 1, "{errors} errors");
    // A bit of it bent: it was read to its last byte all the same, and is not let go.
    for n in 2..6 {
        just_before_a_set(&mut bench)?;
        bench.machine.chip().board.bend_after = 8 * 16 * n;
        bench.forget_groups();
        consecutive(&bench.groups(2)?)?;
        let faults = bench.faults()?;
        ensure!(faults.acquisition_errors == n && faults.lost_sets == 0, "{faults:?}");
    }
    // A port that does not hear answers zeros: STATUS says that nothing waits. With each tick it is asked again.
    just_before_a_set(&mut bench)?;
    bench.plant.borrow_mut().inject(Fault::PortSpi { transfers: 2 });
    let began = bench.now();
    bench.forget_groups();
    let after = bench.groups(2)?;
    let took = bench.now() - began;
    let faults = bench.faults()?;
    ensure!(faults.acquisition_errors == 5 && faults.restarts == 0, "{faults:?}");
    bench.nothing_wrong()?;
    Ok(format!(
        "cut and bent: read once more, 1 error each counted, no group lost; 2 transfers that the port does not hear: two groups after {:.0} ms, \
         {} lost, no error seen",
        milliseconds(took),
        after[1].lost
    ))
}

/// The samples' burst cut off in its head, and read once more; then read as zeros to its end, by which the port has let the set
/// go.
pub fn damaged_samples(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    bench.order(Request::SetStream { groups: true, samples: SampleWindow::ALL })?;
    bench.groups(2)?;
    for (is_cut, errors, dropped) in [(true, 1, 0), (false, 2, 1)] {
        let before = bench.faults()?;
        just_before_a_set(&mut bench)?;
        // Once the wipers are written only the samples are left to read.
        bench.machine.chip().board.written_after.clear();
        let until = bench.now() + SECOND / 100;
        let written = bench.machine.run(until, |machine| machine.chip().board.written_after.len() == 2)?;
        ensure!(written, "the wipers are not written");
        if is_cut {
            bench.machine.chip().board.cut = Some(Cut { after: 8 * 20, lasts: None });
        } else {
            bench.plant.borrow_mut().inject(Fault::MutePort { transfers: 1 });
        }
        bench.forget_groups();
        consecutive(&bench.groups(3)?)?;
        let faults = bench.faults()?;
        let seen =
            (faults.acquisition_errors - before.acquisition_errors, faults.dropped_uploads - before.dropped_uploads);
        ensure!(seen == (errors, dropped) && faults.lost_sets == 0 && faults.restarts == 0, "{seen:?}, {faults:?}");
    }
    bench.nothing_wrong()?;
    Ok("cut off in the head: read once more, nothing dropped; zeros: their group alone, 1 counted as dropped; no group lost".into())
}

/// A port that takes no start: the command is refused, and done when it is given again.
pub fn start_not_taken(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    bench.order(Request::SetAcquisition { run: false })?;
    bench.plant.borrow_mut().inject(Fault::MutePort { transfers: 1 });
    let answer = bench.ask(Request::SetAcquisition { run: true })?;
    ensure!(answer == Answer::Refused(Refusal::AcquisitionFailed), "{answer:?}");
    ensure!(!bench.identify()?.running, "it says that it runs");
    bench.order(Request::SetAcquisition { run: true })?;
    bench.forget_groups();
    consecutive(&bench.groups(3)?)?;
    bench.nothing_wrong()?;
    Ok("refused with AcquisitionFailed, and not running; the next command starts it".into())
}

/// The port begins anew by itself: it is set up within two group periods, and the groups go on.
pub fn set_up_anew(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    let held = wipers(&bench);
    let before = bench.groups(1)?[0].group.0;
    bench.plant.borrow_mut().reset_port();
    let began = bench.now();
    let next = bench.group_within(10 * SECOND)?;
    let silence = bench.now() - began;
    let faults = bench.faults()?;
    ensure!(faults.acquisition_errors == 1 && faults.restarts == 0, "{faults:?}");
    ensure!(next.group.0 - before - 1 == faults.lost_sets && wipers(&bench) == held, "{faults:?}");
    consecutive(&bench.groups(3)?)?;
    bench.nothing_wrong()?;
    Ok(format!(
        "groups again after {:.0} ms, {} counted as lost, no wiper moved, no restart",
        milliseconds(silence),
        faults.lost_sets
    ))
}

/// The same on a chip whose watchdog is as fast as its sheet allows, at twenty moments of the second between ticks.
pub fn fast_watchdog(given: &Given) -> Result<String> {
    const MOMENTS: u64 = 20;
    let (mut restarts, mut longest, mut period) = (0, 0, 0);
    for moment in 0..MOMENTS {
        let mut bench = given.calibrated()?;
        bench.machine.chip().watchdog.clock_hz = 47_000;
        bench.power_cycle()?;
        bench.pass(SECOND / 10)?;
        bench.stream()?;
        bench.groups(2)?;
        // After an odd number of sets a set comes half a second later between two ticks; stopping the scans moves it on.
        bench.plant.borrow_mut().inject(Fault::NoScans);
        bench.pass(moment * SECOND / MOMENTS)?;
        bench.plant.borrow_mut().clear_faults();
        bench.groups(1)?;
        bench.plant.borrow_mut().reset_port();
        let (began, sets) = (bench.now(), bench.machine.chip().board.sets);
        let comes = bench.machine.run(began + 20 * SECOND, |machine| machine.chip().board.sets > sets)?;
        ensure!(comes, "no set within 20 s");
        longest = longest.max(bench.now() - began);
        bench.pass(SECOND / 2)?;
        restarts += bench.resets(Reset::Watchdog);
        period = bench.machine.chip().watchdog.period();
        bench.nothing_wrong()?;
    }
    ensure!(restarts == 0, "{restarts} restarts by the watchdog in {MOMENTS}");
    Ok(format!(
        "sets again after {:.0} ms at most, the watchdog's time {:.0} ms: no restart at {MOMENTS} moments",
        milliseconds(longest),
        milliseconds(period)
    ))
}

/// No scans at all: the watchdog restarts the chip, and it goes on by itself.
pub fn no_scans(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    let held = wipers(&bench);
    let began = bench.now();
    bench.plant.borrow_mut().inject(Fault::NoScans);
    let bites = bench.machine.run(began + 20 * SECOND, |machine| machine.resets.len() > 1)?;
    let after = bench.now() - began;
    ensure!(bites && bench.resets(Reset::Watchdog) == 1, "no reset by the watchdog within 20 s");
    bench.plant.borrow_mut().clear_faults();
    bench.pass(SECOND / 2)?;
    ensure!(wipers(&bench) == held, "the restart moved a wiper");
    let identity = bench.identify()?;
    ensure!(identity.reset == ResetCause::Watchdog && identity.running, "{identity:?}");
    ensure!(identity.calibration == CalibrationState::InUse, "{identity:?}");
    ensure!(bench.faults()?.restarts == 1);
    bench.stream()?;
    let groups = bench.groups(3)?;
    ensure!(Some(groups[2].axes[0].tap) == given.asked(&groups[1], Axis::X), "it does not go on");
    bench.nothing_wrong()?;
    Ok(format!("reset by the watchdog after {:.0} ms, counted, wipers held, at work again", milliseconds(after)))
}

/// While a debugger holds the core, groups are lost, counted and named.
pub fn overrun(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    let before = bench.groups(1)?[0].group.0;
    bench.machine.chip().clock += 4 * SECOND;
    bench.forget_groups();
    let groups = bench.groups(3)?;
    consecutive(&groups)?;
    let faults = bench.faults()?;
    ensure!(faults.lost_sets > 0 && groups[2].lost == faults.lost_sets && faults.restarts == 0, "{faults:?}");
    bench.nothing_wrong()?;
    Ok(format!("4 s: {} groups lost, counted and named, from {before} on", faults.lost_sets))
}
