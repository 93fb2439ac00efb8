//! What starts the chip anew.

use anyhow::{Result, ensure};
use zerorate_core::units::Axis;
use zerorate_core::wire::{CalibrationState, ResetCause, Stop};
use zerorate_sim::Fault;

use super::{Given, paper, wipers};
use crate::bench::Bench;
use crate::chip::memory;
use crate::chip::nvic;
use crate::chip::rcc::Reset;
use crate::chip::time::{MICROSECOND, MILLISECOND, SECOND, milliseconds};
use crate::machine::Ambush;
use crate::machine::run::NOTHING;

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
    ensure!(identity.reset == ResetCause::Watchdog && identity.running && restarts == 3, "{identity:?}, {restarts}");
    bench.nothing_wrong()?;
    Ok(format!(
        "a reset every {:.1} s, three times; with the crystal at work again: Watchdog, {restarts} restarts counted",
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

/// A hard fault, and a panic: the chip restarts itself, and says where it was.
pub fn panic(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    ensure!(bench.stop()?.is_none(), "it has not stopped yet");
    let held = wipers(&bench);
    let mut started_in = 0;
    let site = &given.image.panic;
    for (ambush, cause, n) in [(Ambush::HardFault, ResetCause::Fault, 1), (Ambush::Panic, ResetCause::Panic, 2)] {
        bench.machine.ambush(nvic::EXTI0, ambush)?;
        let resets = bench.machine.resets.len();
        let until = bench.now() + 3 * SECOND;
        ensure!(bench.machine.run(until, |machine| machine.resets.len() > resets)?, "no reset after {ambush:?}");
        let reset_at = bench.now();
        let runs = |machine: &mut crate::machine::Machine| machine.chip().board.plant.borrow().next_scan_ns().is_some();
        // The port scans on while the processor starts; it is started anew by the program.
        let odd = bench.machine.chip().board.odd_scans;
        bench.machine.run(reset_at + SECOND, |machine| runs(machine) && machine.chip().board.odd_scans > odd)?;
        started_in = started_in.max(bench.now() - reset_at);
        bench.pass(SECOND / 10)?;
        ensure!(wipers(&bench) == held, "a restart moved a wiper");
        let identity = bench.identify()?;
        ensure!(identity.reset == cause && identity.running, "{identity:?}");
        ensure!(bench.faults()?.restarts == n);
        let stop = bench.stop()?;
        let is_told = match (&stop, ambush) {
            (Some(Stop::Fault(registers)), Ambush::HardFault) => {
                let seen = bench.machine.hard_faults == [(given.image.load, Some(NOTHING))];
                seen && (registers.pc, registers.bfar) == (given.image.load, NOTHING)
                    // PRECISERR and BFARVALID; FORCED.
                    && (registers.cfsr, registers.hfsr) == (1 << 9 | 1 << 15, 1 << 30)
            }
            (stop, _) => *stop == Some(Stop::panic_at(&site.file, site.line)),
        };
        ensure!(is_told, "{stop:x?} after {ambush:?}, {:x?}, {site:?}", bench.machine.hard_faults);
    }
    ensure!(bench.resets(Reset::Software) == 2);
    // A second reason to start is no panic.
    bench.power_cycle()?;
    bench.pass(SECOND / 10)?;
    let identity = bench.identify()?;
    ensure!(identity.reset == ResetCause::Power && bench.faults()?.restarts == 0, "{identity:?}");
    ensure!(bench.stop()?.is_none(), "power, and the place is still told");
    bench.nothing_wrong()?;
    Ok(format!(
        "a load from {NOTHING:#x} at {:#x} and a panic at line {}: told apart, with their places, counted, wipers held, groups \
         being taken again {:.1} ms after",
        given.image.load,
        site.line,
        milliseconds(started_in)
    ))
}

/// What resets the chip is told apart, and a dip that does not is counted.
pub fn causes(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    bench.machine.chip().flash.set_brown_out_level(3);
    bench.power_cycle()?;
    bench.pass(SECOND / 2)?;
    let chip = bench.machine.chip();
    let (level, programmed) = (chip.flash.brown_out_level(), chip.flash.options_programmed);
    ensure!((level, programmed) == (0, 1), "BOR_LEV is {level}, programmed {programmed} times");
    for (cause, volts) in [(ResetCause::BrownOut, 2.7), (ResetCause::Power, 0.0)] {
        bench.machine.dip(volts)?;
        bench.pass(SECOND / 10)?;
        let identity = bench.identify()?;
        ensure!(identity.reset == cause && identity.running, "{volts} V: {identity:?}");
        ensure!(bench.faults()?.restarts == 0 && bench.stop()?.is_none());
    }
    let resets = bench.machine.resets.len();
    for _ in 0..3 {
        bench.machine.dip(2.9)?;
        bench.pass(SECOND / 10)?;
    }
    ensure!(bench.machine.resets.len() == resets, "2.9 V have reset it");
    let dips = bench.faults()?.supply_dips;
    ensure!(dips == 3, "{dips} dips counted");
    for (reset, cause) in [(Reset::Pin, ResetCause::Pin), (Reset::Software, ResetCause::Software)] {
        bench.machine.reset(reset)?;
        bench.pass(SECOND / 10)?;
        let identity = bench.identify()?;
        ensure!(identity.reset == cause && identity.running, "{identity:?}");
        ensure!(bench.faults()?.supply_dips == 3, "the dips are forgotten");
    }
    let programmed = bench.machine.chip().flash.options_programmed;
    ensure!(programmed == 1, "the option bytes were programmed {programmed} times");
    bench.nothing_wrong()?;
    Ok(format!(
        "BOR at level 3, programmed once in {} starts; 2.7 V told as BrownOut, 0 V as Power, Pin, Software; 3 dips to 2.9 V \
         counted and no reset",
        bench.machine.resets.len()
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
    ensure!(identity.reset == ResetCause::Fault && wipers(&bench) == [511; 2], "{identity:?}");
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

/// With its record the program hangs at its first group, three times; between groups a hang is no matter of the record.
pub fn three_hangs(given: &Given) -> Result<String> {
    let hang = |bench: &mut Bench, within: bool| {
        let resets = bench.machine.resets.len();
        if within {
            bench.machine.ambush_at(given.image.within_set, Ambush::Hang);
        } else {
            bench.machine.ambush(nvic::EXTI0, Ambush::Hang)?;
        }
        let until = bench.now() + 20 * SECOND;
        ensure!(bench.machine.run(until, |machine| machine.resets.len() > resets)?, "no reset");
        bench.pass(SECOND / 10)
    };
    let mut bench = given.calibrated()?;
    for _ in 0..4 {
        hang(&mut bench, false)?;
    }
    let identity = bench.identify()?;
    ensure!(identity.calibration == CalibrationState::InUse && identity.running, "between groups: {identity:?}");
    for _ in 0..3 {
        hang(&mut bench, true)?;
    }
    let identity = bench.identify()?;
    ensure!(identity.calibration == CalibrationState::SetAside && !identity.running, "{identity:?}");
    ensure!(identity.reset == ResetCause::Watchdog && wipers(&bench) == [511; 2], "{identity:?}");
    ensure!(bench.faults()?.restarts == 7);
    bench.nothing_wrong()?;
    Ok("at the interrupt's beginning, four times: the record stays; at a set's temperature, three times: set aside, the wipers in \
        the middle"
        .into())
}

/// A port that is dead for days is asked again and again: a watchdog that bites while it is asked does not blame the record.
pub fn dead_port(given: &Given) -> Result<String> {
    const BITES: usize = 4;
    let mut bench = given.calibrated()?;
    bench.plant.borrow_mut().inject(Fault::MutePort { transfers: u32::MAX });
    for n in 1..=BITES {
        // Past the start, which is the record's.
        bench.pass(SECOND / 10)?;
        let (asked, until) = (bench.machine.chip().board.asked, bench.now() + SECOND);
        // A frame takes 9 us.
        while bench.machine.chip().board.asked == asked {
            ensure!(bench.now() < until, "not asked after {} bites", n - 1);
            bench.pass(MICROSECOND)?;
        }
        bench.machine.reset(Reset::Watchdog)?;
        ensure!(bench.machine.resets.len() == 1 + n, "resets {:?}", bench.machine.resets);
    }
    bench.plant.borrow_mut().clear_faults();
    bench.pass(SECOND)?;
    let identity = bench.identify()?;
    ensure!(identity.calibration == CalibrationState::InUse && identity.running, "{identity:?}");
    bench.stream()?;
    // Not held against it: chip select rose within a byte, with the resets.
    bench.groups(2)?;
    Ok(format!("{BITES} times while it was asked: the record stays in use, and is at work when the port is there"))
}

/// The stack's end is the memory's end: what does not fit is written nowhere, and the watchdog restarts what has locked up.
pub fn full_stack(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    let held = wipers(&bench);
    let statics = bench.machine.bytes(memory::RAM, memory::RAM_BYTES)?;
    bench.machine.end_the_stack()?;
    let until = bench.now() + 20 * SECOND;
    let reset = bench.machine.run(until, |machine| machine.resets.len() > 1)?;
    ensure!(reset, "no reset");
    ensure!(bench.machine.bytes(memory::RAM, memory::RAM_BYTES)? == statics, "it has written into the statics");
    bench.pass(SECOND / 10)?;
    let identity = bench.identify()?;
    ensure!(identity.reset == ResetCause::Watchdog && identity.running && wipers(&bench) == held, "{identity:?}");
    Ok("nothing is written, the watchdog restarts it, the wipers are held, groups are taken".into())
}
