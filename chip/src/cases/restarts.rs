//! What starts the chip anew.

use anyhow::{Result, ensure};
use zerorate_core::units::Axis;
use zerorate_core::wire::{CalibrationState, ResetCause};

use super::{Given, paper, wipers};
use crate::bench::Bench;
use crate::chip::nvic;
use crate::chip::rcc::Reset;
use crate::chip::time::{MILLISECOND, SECOND, milliseconds};
use crate::machine::Ambush;

/// The watchdog runs before the clocks do.
pub fn dead_crystal(given: &Given) -> Result<String> {
    let mut bench = Bench::new(&given.image, paper(), Some(&given.records))?;
    let mut after = 0;
    bench.machine.chip().rcc.crystal_works = false;
    let mut began = bench.now();
    for n in 1..=3 {
        ensure!(
            bench.machine.run(began + 20 * SECOND, |machine| machine.resets.len() > n)?,
            "no reset {n} within 20 s"
        );
        (after, began) = (bench.now() - began, bench.now());
    }
    ensure!(bench.resets(Reset::Watchdog) == 3, "resets {:?}", bench.machine.resets);
    bench.machine.chip().rcc.crystal_works = true;
    bench.pass(50 * MILLISECOND)?;
    let identity = bench.identify()?;
    let restarts = bench.faults()?.restarts;
    ensure!(identity.reset == ResetCause::Watchdog && identity.running && restarts == 1, "{identity:?}, {restarts}");
    bench.nothing_wrong()?;
    Ok(format!(
        "a reset every {:.1} s, three times; with the crystal at work again: Watchdog, {restarts} restart counted",
        milliseconds(after) / 1e3
    ))
}

/// The program hangs in its highest interrupt.
pub fn hang(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    let held = wipers(&bench);
    let began = bench.now();
    bench.machine.ambush(nvic::EXTI0, Ambush::Hang)?;
    ensure!(bench.machine.run(began + 20 * SECOND, |machine| machine.resets.len() > 1)?, "no reset");
    let after = bench.now() - began;
    bench.pass(SECOND / 2)?;
    ensure!(wipers(&bench) == held, "the restart moved a wiper");
    let identity = bench.identify()?;
    ensure!(identity.reset == ResetCause::Watchdog && identity.running, "{identity:?}");
    let restarts = bench.faults()?.restarts;
    ensure!(restarts == 1 && bench.resets(Reset::Watchdog) == 1);
    bench.stream()?;
    let groups = bench.groups(2)?;
    ensure!(Some(groups[1].axes[0].tap) == given.asked(&groups[0], Axis::X), "it does not go on");
    bench.nothing_wrong()?;
    Ok(format!("reset {:.0} ms after, counted, wipers held, at work again", milliseconds(after)))
}

/// A hard fault, and a panic: the chip restarts itself.
pub fn panic(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    let held = wipers(&bench);
    let mut started_in = 0;
    for (ambush, n) in [(Ambush::HardFault, 1), (Ambush::Panic, 2)] {
        bench.machine.ambush(nvic::EXTI0, ambush)?;
        let until = bench.now() + 3 * SECOND;
        ensure!(bench.machine.run(until, |machine| machine.resets.len() > n)?, "no reset after {ambush:?}");
        let reset_at = bench.now();
        let runs = |machine: &mut crate::machine::Machine| machine.chip().board.plant.borrow().next_scan_ns().is_some();
        // The port scans on while the processor starts; it is started anew by the program.
        let odd = bench.machine.chip().board.odd_scans;
        bench.machine.run(reset_at + SECOND, |machine| runs(machine) && machine.chip().board.odd_scans > odd)?;
        started_in = started_in.max(bench.now() - reset_at);
        bench.pass(SECOND / 10)?;
        ensure!(wipers(&bench) == held, "a restart moved a wiper");
        let identity = bench.identify()?;
        ensure!(identity.reset == ResetCause::Panic && identity.running, "{identity:?}");
        ensure!(bench.faults()?.restarts == u32::try_from(n)?);
    }
    ensure!(bench.resets(Reset::Software) == 2 && bench.machine.hard_faults == 1);
    // A second reason to start is no panic.
    bench.power_cycle()?;
    bench.pass(SECOND / 10)?;
    let identity = bench.identify()?;
    ensure!(identity.reset == ResetCause::Power && bench.faults()?.restarts == 0, "{identity:?}");
    bench.nothing_wrong()?;
    Ok(format!(
        "a hard fault and a panic: told as Panic, counted, wipers held, groups being taken again {:.1} ms after",
        milliseconds(started_in)
    ))
}

/// With its record the program fails at its first group, three times.
pub fn three_in_a_row(given: &Given) -> Result<String> {
    let mut bench = given.calibrated()?;
    for n in 1..=3 {
        let ambush = if n == 2 { Ambush::Panic } else { Ambush::HardFault };
        bench.machine.ambush(nvic::EXTI0, ambush)?;
        let until = bench.now() + 3 * SECOND;
        ensure!(bench.machine.run(until, |machine| machine.resets.len() > n)?, "no reset {n}");
    }
    bench.pass(SECOND / 10)?;
    let identity = bench.identify()?;
    ensure!(identity.calibration == CalibrationState::SetAside && !identity.running, "{identity:?}");
    ensure!(identity.reset == ResetCause::Panic && wipers(&bench) == [511; 2], "{identity:?}");
    ensure!(bench.faults()?.restarts == 3);
    bench.deploy(&given.record)?;
    ensure!(bench.identify()?.calibration == CalibrationState::InUse, "a new record is not taken");
    bench.power_cycle()?;
    bench.pass(SECOND / 10)?;
    let identity = bench.identify()?;
    ensure!(identity.calibration == CalibrationState::InUse && identity.running, "{identity:?}");
    bench.nothing_wrong()?;
    Ok("the record is set aside, the wipers in the middle, 3 restarts counted; another record, or power, ends it"
        .into())
}
