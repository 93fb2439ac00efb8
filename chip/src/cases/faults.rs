//! Faults of the temperature, the reading and the potentiometer.

use anyhow::{Result, ensure};
use zerorate_core::compensate::Mode;
use zerorate_core::drift::Coverage;
use zerorate_core::units::{Axis, Celsius, Taps};
use zerorate_core::wire::{GroupReport, Request, TemperatureCheck};
use zerorate_sim::Fault;

use super::{Given, wipers};
use crate::chip::time::{MILLISECOND, SECOND, milliseconds};
use crate::paper_record;

/// Scans a group.
const GROUP: u32 = 500;

fn checks(groups: &[GroupReport], axis: Axis) -> Vec<TemperatureCheck> {
    groups.iter().map(|group| group.axes[axis.index()].temperature).collect()
}

fn taps(groups: &[GroupReport], axis: Axis) -> Vec<u16> {
    groups.iter().map(|group| group.axes[axis.index()].tap.get()).collect()
}

/// The potentiometer loads its power-up taps; the wipers are back within a group.
pub fn brown_out(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    for axis in Axis::BOTH {
        bench.order(Request::SetMode { axis, mode: Mode::Off })?;
        bench.order(Request::SetTap { axis, tap: Taps::new(300).unwrap_or(Taps::FIRST) })?;
    }
    let began = bench.now();
    bench.order(Request::StorePowerUpTap)?;
    let stored_in = bench.now() - began;
    bench.order(Request::SetMode { axis: Axis::X, mode: Mode::Trim })?;
    bench.order(Request::SetTap { axis: Axis::Y, tap: Taps::new(600).unwrap_or(Taps::LAST) })?;
    bench.groups(3)?;
    let held = wipers(&bench);
    let mut longest = 0;
    for phase in 0..20 {
        bench.pass(phase * 77 * MILLISECOND)?;
        bench.plant.borrow_mut().brown_out();
        ensure!(wipers(&bench) == [300; 2] && !held.contains(&300), "{held:?}");
        let fell = bench.now();
        let plant = std::rc::Rc::clone(&bench.plant);
        let is_back = move || Axis::BOTH.map(|axis| plant.borrow().potentiometer().wiper(axis).get()) == held;
        ensure!(bench.machine.run(fell + 2 * SECOND, |_| is_back())?, "the wipers are not put back");
        longest = longest.max(bench.now() - fell);
    }
    ensure!(longest <= 1503 * MILLISECOND, "{:.0} ms", milliseconds(longest));
    bench.nothing_wrong()?;
    Ok(format!(
        "20 dips: both wipers back after {:.0} ms at most; a power-up tap stored within {:.0} ms of being asked",
        milliseconds(longest),
        milliseconds(stored_in)
    ))
}

/// On a chip nobody hears that a frame was not heard; both wipers are written with the next group.
pub fn deaf_potentiometer(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    for axis in Axis::BOTH {
        bench.order(Request::SetMode { axis, mode: Mode::Off })?;
    }
    let tap = Taps::new(600).unwrap_or(Taps::LAST);
    // Both of the group that closes, and the command's own.
    bench.plant.borrow_mut().inject(Fault::PotentiometerSpi { transfers: 3 });
    bench.order(Request::SetTap { axis: Axis::X, tap })?;
    ensure!(wipers(&bench)[0] != 600);
    let asked = bench.now();
    bench.machine.run(asked + 3 * SECOND, |machine| {
        machine.chip().board.plant.borrow().potentiometer().wiper(Axis::X).get() == 600
    })?;
    let after = bench.now() - asked;
    ensure!(wipers(&bench)[0] == 600, "it is not written again");
    let errors = bench.faults()?.trim_errors;
    ensure!(errors == 0);
    bench.nothing_wrong()?;
    Ok(format!(
        "written again with the next group, {:.0} ms after; {errors} errors seen: an SPI master has no way to",
        milliseconds(after)
    ))
}

/// A temperature that is not believed holds its tap.
pub fn temperature(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    bench.plant.borrow_mut().inject(Fault::StuckTemperature(Axis::X));
    bench.plant.borrow_mut().chamber_set_point(Celsius(60.0))?;
    let stuck = bench.groups(100)?;
    ensure!(checks(&stuck[2..], Axis::X).iter().all(|&check| check == TemperatureCheck::Stuck), "not seen to be stuck");
    let (x, y) = (taps(&stuck[3..], Axis::X), taps(&stuck[3..], Axis::Y));
    ensure!(x.iter().all(|&tap| tap == x[0]) && y[0] != y[96], "X {x:?}, Y {y:?}");
    bench.plant.borrow_mut().clear_faults();
    let mended = bench.groups(8)?;
    ensure!(mended[7].axes[0].temperature == TemperatureCheck::Believed, "not believed again");

    let before = mended[7].axes[1].tap;
    bench.plant.borrow_mut().inject(Fault::TemperatureOff { axis: Axis::Y, counts: -2000, scans: GROUP });
    let glitch = bench.groups(5)?;
    ensure!(checks(&glitch, Axis::Y).contains(&TemperatureCheck::Jumped), "{:?}", checks(&glitch, Axis::Y));
    ensure!(taps(&glitch, Axis::Y).iter().all(|&tap| tap.abs_diff(before.get()) <= 2), "thrown by a glitch");

    bench.plant.borrow_mut().inject(Fault::TemperatureAt { axis: Axis::X, counts: 0 });
    bench.groups(1)?;
    let torn = bench.groups(20)?;
    ensure!(
        checks(&torn, Axis::X).iter().all(|&check| check == TemperatureCheck::Saturated),
        "{:?}",
        checks(&torn, Axis::X)
    );
    let x = taps(&torn, Axis::X);
    ensure!(x.iter().all(|&tap| tap == x[0]), "{x:?}");
    let faults = bench.faults()?;
    bench.nothing_wrong()?;
    Ok(format!(
        "held; counted {} stuck, {} jumped, {} at an end",
        faults.temperature_stuck, faults.temperature_jumped, faults.temperature_saturated
    ))
}

/// X's temperature runs away while Y's stands: neither is believed, and both are when it is back.
pub fn disagreement(given: &Given) -> Result<String> {
    /// 0.1 K/s.
    const COUNTS: i32 = 5;
    let mut bench = given.at_work()?;
    let (mut doubtful, mut held) = (0, None);
    for k in 1..=60 {
        let off = Fault::TemperatureOff { axis: Axis::X, counts: COUNTS * k, scans: 10 * GROUP };
        bench.plant.borrow_mut().clear_faults();
        bench.plant.borrow_mut().inject(off);
        let groups = bench.groups(1)?;
        let checks = groups[0].axes.each_ref().map(|axis| axis.temperature);
        if checks == [TemperatureCheck::Jumped, TemperatureCheck::Stuck] {
            let taps = wipers(&bench);
            ensure!(*held.get_or_insert(taps) == taps, "held at {held:?}, and at {taps:?}");
            doubtful += 1;
        } else {
            ensure!(checks == [TemperatureCheck::Believed; 2] && held.is_none(), "{checks:?} in group {k}");
        }
    }
    ensure!(doubtful >= 30, "{doubtful} groups");
    bench.plant.borrow_mut().clear_faults();
    bench.groups(4)?;
    let back = bench.groups(2)?;
    ensure!(
        back.iter().flat_map(|group| &group.axes).all(|axis| axis.temperature == TemperatureCheck::Believed),
        "{back:?}"
    );
    let faults = bench.faults()?;
    bench.nothing_wrong()?;
    Ok(format!(
        "X runs away by 0.1 K/s: both held after 3 K, {doubtful} groups, {} counted as stuck and {} as jumped; believed when it is back",
        faults.temperature_stuck, faults.temperature_jumped
    ))
}

/// A temperature outside the record's range, and a reading at the converter's end.
pub fn range_and_reading(given: &Given) -> Result<String> {
    let mut bench = given.at_work()?;
    // The room is at 10 710 counts.
    let narrow = paper_record::record([8500.0, 10_000.0], None, 0.05);
    bench.deploy(&narrow)?;
    bench.forget_groups();
    let groups = bench.groups(4)?;
    ensure!(groups[3].axes.iter().all(|axis| axis.coverage == Coverage::Above), "{:?}", groups[3]);
    bench.plant.borrow_mut().inject(Fault::SaturatedInput(Axis::Y));
    bench.groups(1)?;
    let groups = bench.groups(3)?;
    ensure!(groups.iter().all(|group| group.axes[1].saturated && !group.axes[0].saturated), "{:?}", groups[0]);
    // At the other end it is the amplifier that ends first.
    bench.order(Request::SetMode { axis: Axis::X, mode: Mode::Off })?;
    bench.order(Request::SetTap { axis: Axis::X, tap: Taps::FIRST })?;
    bench.groups(2)?;
    let low = bench.groups(2)?;
    ensure!(low.iter().all(|group| group.axes[0].saturated), "{:?}", low[0]);
    let faults = bench.faults()?;
    ensure!(faults.out_of_range > 0 && faults.saturated > 0, "{faults:?}");
    bench.nothing_wrong()?;
    Ok(format!("clamped and said, marked; counted {} and {}", faults.out_of_range, faults.saturated))
}
