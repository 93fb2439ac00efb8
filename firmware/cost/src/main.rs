//! What the maths in the interrupt costs, in instructions: `cargo xtask firmware --cost` runs it in QEMU and makes the table
//! of firmware/README.md from the lines that it prints.
//!
//! Every count is from the call of one function to its return, all that it calls included. These are instructions, not
//! cycles.

#![no_std]
#![no_main]

mod count;
mod peers;
mod print;

use core::hint::black_box;

use cortex_m_rt::entry;
use zerorate_core::compensate::{AxisCompensation, AxisLaw, EdgeTable, LowPass, Mode, StaticLaw};
use zerorate_core::drift::{Drift, Polynomial, Scale, Shape, Table, ValidRange};
use zerorate_core::group::GroupSums;
use zerorate_core::trim::{TapEffects, Trim, TrimLine};
use zerorate_core::units::{Counts, Taps, TemperatureCode, TemperatureScale};

use count::Counter;

// SAFETY: both are in `count`, take nothing and return nothing.
unsafe extern "C" {
    /// Returns at once.
    safe fn cost_return();
    /// Ten instructions, its return counted.
    safe fn cost_ten();
}

/// No tap: what a function of C's form returns where Rust's says `None`.
const NO_TAP: u32 = u32::MAX;

extern "C" fn push(sums: &mut GroupSums, temperature: u16, zro: u16) {
    sums.push(temperature, zro);
}

extern "C" fn close(axis: &mut AxisCompensation, law: &AxisLaw, sums: &GroupSums) -> i32 {
    axis.skip_samples(sums.n);
    axis.close_group(Some(law), sums).corrected.0
}

extern "C" fn update(axis: &mut AxisCompensation, law: &AxisLaw, code: u16) -> u32 {
    axis.update(law, TemperatureCode(code)).map_or(NO_TAP, |tap| u32::from(tap.get()))
}

extern "C" fn written(axis: &mut AxisCompensation, law: &AxisLaw, tap: u16) {
    if let Some(tap) = Taps::new(tap) {
        axis.wiper_written(Some(law), tap);
    }
}

extern "C" fn correction(law: &AxisLaw, code: u16, tap: u16) -> i32 {
    match Taps::new(tap) {
        Some(tap) => law.correction(TemperatureCode(code), tap).0,
        None => 0,
    }
}

extern "C" fn sample(axis: &mut AxisCompensation, zro: u16) -> i32 {
    axis.sample(zro).0
}

/// Eq. (1), X, its taps measured, in mode hybrid with a dead band of 0.05 tap.
fn law(order: usize) -> StaticLaw {
    const RANGE: (f64, f64) = (8500.0, 11_900.0);
    let Some(scale) = Scale::spanning(RANGE.0, RANGE.1) else { panic!() };
    let all = [8230.0, -200.0, 60.0, 12.0, -7.0, 3.0];
    let shape = match order {
        0 => {
            let mut knots = [0.0; 33];
            for (knot, slot) in knots.iter_mut().enumerate() {
                *slot = 8430.0 - 12.0 * knot as f64;
            }
            Table::new(scale, &knots).map(Shape::Table)
        }
        order => Polynomial::new(scale, &all[..=order]).map(Shape::Polynomial),
    };
    let mut effects = [Counts(0.0); 27];
    for (k, effect) in effects.iter_mut().enumerate() {
        *effect = Counts(31.26 * (k as f64 - 15.0));
    }
    let measured = Taps::new(496).and_then(|first| TapEffects::new(first, &effects));
    let line = TrimLine::new(-0.031_990_6, 0.0, Counts(8200.0), Taps::MIDDLE);
    let (Some(shape), Some(valid), Some(line)) = (shape, ValidRange::new(RANGE.0, RANGE.1), line) else { panic!() };
    StaticLaw {
        drift: Drift { shape, valid },
        trim: Trim { line, measured },
        dead_band: 0.05,
        temperature_scale: TemperatureScale::QUARTER_COUNTS,
    }
}

/// The law as it runs, and its table.
fn running(order: usize) -> (AxisLaw, EdgeTable) {
    let law = law(order);
    let Ok(table) = EdgeTable::solve(&law) else { panic!() };
    let low_pass = LowPass::first_order(40.0, 0.003, 0.0001);
    let Ok(axis) = AxisLaw::new(&law, Some(&table), low_pass) else { panic!() };
    (axis, table)
}

#[entry]
fn main() -> ! {
    let Some(peripherals) = cortex_m::Peripherals::take() else { panic!() };
    let counter = Counter::new(peripherals.SYST);
    let line = |name: &str, count: u32| print::line(name, count);
    // The yardstick itself: ten instructions and their call.
    line("yardstick", count!(counter, cost_ten, extern "C" fn(), ()));

    let (law, table) = running(2);
    let mut sums = GroupSums::default();
    for k in 0..499_u16 {
        sums.push(8600 + k % 7, 8400 + k % 11);
    }
    line("sample", count!(counter, push, extern "C" fn(&mut GroupSums, u16, u16), (&mut sums, 8603, 8405)));

    let mut axis = AxisCompensation::new(Some(&law), Taps::MIDDLE);
    axis.set_mode(Mode::Hybrid);
    // The first group finds its tap, the second is the everyday one.
    if let Some(tap) = axis.close_group(Some(&law), &sums).move_to {
        axis.wiper_written(Some(&law), tap);
    }
    axis.skip_samples(2 * 500);
    type Close = extern "C" fn(&mut AxisCompensation, &AxisLaw, &GroupSums) -> i32;
    line("group", count!(counter, close, Close, (&mut axis, &law, &sums)));

    type Update = extern "C" fn(&mut AxisCompensation, &AxisLaw, u16) -> u32;
    let Some(now) = table.intervals().get(4) else { panic!() };
    let code = now.first + 2;
    if let Some(tap) = axis.update(&law, TemperatureCode(code)) {
        axis.wiper_written(Some(&law), tap);
    }
    line("update", count!(counter, update, Update, (&mut axis, &law, code)));

    // One edge further, either way; the counts are of two axes in the same state.
    let (mut hotter, mut colder) = (axis.clone(), axis.clone());
    let up = count_once(&counter, &mut hotter, &law, now.hold_up_to + 1);
    let down = count_once(&counter, &mut colder, &law, now.hold_down_to - 1);
    line("update-edge", up.max(down));
    let tap = axis.tap().get() + 1;
    type Written = extern "C" fn(&mut AxisCompensation, &AxisLaw, u16);
    line("written", count!(counter, written, Written, (&mut hotter, &law, tap)));
    line("sample-corrected", count!(counter, sample, extern "C" fn(&mut AxisCompensation, u16) -> i32, (&mut axis, 8405)));

    type Correction = extern "C" fn(&AxisLaw, u16, u16) -> i32;
    let corrected = |law: &AxisLaw| count!(counter, correction, Correction, (law, code, tap));
    line("correction-2", corrected(&law));
    line("correction-5", corrected(&running(5).0));
    line("correction-table", corrected(&running(0).0));

    let cubic = black_box(peers::CUBIC);
    type Cubic = extern "C" fn(&peers::Cubic, f32, f32) -> f32;
    line("cubic", count!(counter, peers::correct, Cubic, (&cubic, 31.5, 0.02)));
    print::exit()
}

/// An update that crosses an edge: it changes the axis, so the call that only returns gets one of its own.
fn count_once(counter: &Counter, axis: &mut AxisCompensation, law: &AxisLaw, code: u16) -> u32 {
    type Update = extern "C" fn(&mut AxisCompensation, &AxisLaw, u16) -> u32;
    count!(counter, update, Update, (axis, law, code))
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    print::line("panic", 1);
    print::exit()
}
