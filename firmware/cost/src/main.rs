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
use zerorate_core::compensate::{AxisCompensation, AxisLaw, EdgeTable, LowPass, Mode, Q16, StaticLaw};
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
    fn cost_ten();
}

fn close(axis: &mut AxisCompensation, law: &AxisLaw, sums: &GroupSums) -> i32 {
    axis.skip_samples(sums.n);
    axis.close_group(Some(law), sums).corrected.0
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
    line("yardstick", count!(counter, cost_ten, fn() -> ()));

    let (law, table) = running(2);
    let mut sums = GroupSums::default();
    for k in 0..499_u16 {
        sums.push(8600 + k % 7, 8400 + k % 11);
    }
    line("sample", count!(counter, GroupSums::push, fn(&mut sums => &mut GroupSums, 8603 => u16, 8405 => u16) -> ()));

    let mut axis = AxisCompensation::new(Some(&law), Taps::MIDDLE);
    axis.set_mode(Mode::Hybrid);
    // The first group finds its tap, the second is the everyday one.
    if let Some(tap) = axis.close_group(Some(&law), &sums).move_to {
        axis.wiper_written(Some(&law), tap);
    }
    axis.skip_samples(2 * 500);
    line(
        "group",
        count!(counter, close, fn(&mut axis => &mut AxisCompensation, &law => &AxisLaw, &sums => &GroupSums) -> i32),
    );

    let Some(now) = table.intervals().get(4) else { panic!() };
    let code = TemperatureCode(now.first + 2);
    if let Some(tap) = axis.update(&law, code) {
        axis.wiper_written(Some(&law), tap);
    }
    line("update", count_update(&counter, &mut axis, &law, code));

    // One edge further, either way: the longer of the two.
    let (mut hotter, mut colder) = (axis.clone(), axis.clone());
    let up = count_update(&counter, &mut hotter, &law, TemperatureCode(now.hold_up_to + 1));
    let down = count_update(&counter, &mut colder, &law, TemperatureCode(now.hold_down_to - 1));
    line("update-edge", up.max(down));
    let tap = table.intervals()[5].tap;
    line(
        "written",
        count!(
            counter,
            AxisCompensation::wiper_written,
            fn(&mut hotter => &mut AxisCompensation, Some(&law) => Option<&AxisLaw>, tap => Taps) -> ()
        ),
    );
    line(
        "sample-corrected",
        count!(counter, AxisCompensation::sample, fn(&mut axis => &mut AxisCompensation, 8405 => u16) -> Q16),
    );

    let corrected = |law: &AxisLaw| count!(counter, AxisLaw::correction, fn(law => &AxisLaw, code => TemperatureCode, tap => Taps) -> Q16);
    line("correction-2", corrected(&law));
    line("correction-5", corrected(&running(5).0));
    line("correction-table", corrected(&running(0).0));

    let cubic = black_box(peers::CUBIC);
    line("cubic", count!(counter, peers::correct, fn(&cubic => &peers::Cubic, 31.5 => f32, 0.02 => f32) -> f32));
    print::exit()
}

fn count_update(counter: &Counter, axis: &mut AxisCompensation, law: &AxisLaw, code: TemperatureCode) -> u32 {
    count!(counter, AxisCompensation::update, fn(axis => &mut AxisCompensation, law => &AxisLaw, code => TemperatureCode) -> Option<Taps>)
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    print::line("panic", 1);
    print::exit()
}
