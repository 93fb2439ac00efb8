//! The source code, compiled and compared with the host's model over the whole range and beyond.

use std::path::Path;
use std::process::Command;

use zerorate_core::drift::{Drift, History, Memory, Term};
use zerorate_fit::drift_fit::StaticCubic;
use zerorate_fit::predict::{Predictor, Start};

use super::calibrations::{axis, calibration, drift, three_axes};
use crate::{ExportOptions, ExportedAxis, Format, export};
use zerorate_cal::calibration::Calibration;
use zerorate_cal::units::{RateScale, RateUnit};

/// A program that prints, for temperatures from -40 to 100 C in steps of 0.05, the bias of every axis in floating point
/// and in integers.
const C_MAIN: &str = r#"
#include <stdio.h>
#include "calibration.h"
int main(void)
{
    /* Axes without a history, of which nothing is unknown. */
    zr_state state = {0};
    zr_int_state int_state = {0};
    for (int a = 0; a < ZR_AXIS_COUNT; a++)
        if (zr_known_share(&ZR_AXES[a], &state) < 1 || zr_int_known_share(&ZR_INT_AXES[a], &int_state) < (1 << 30))
            return 1;
    for (int i = -800; i <= 2000; i++) {
        double t = i * 0.05;
        printf("%.17g", t);
        for (int a = 0; a < ZR_AXIS_COUNT; a++)
            printf(" %.17g %ld", (double)zr_bias(&ZR_AXES[a], (zr_real)t),
                   (long)zr_int_bias(&ZR_INT_AXES[a], (int32_t)(t * 65536.0 + (t < 0 ? -0.5 : 0.5))));
        printf("\n");
    }
    return 0;
}
"#;

/// Runs a command that must succeed, and gives what it printed; `None` without the program.
fn run(command: &mut Command) -> Option<String> {
    let output = match command.output() {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return None,
        other => other.unwrap(),
    };
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8(output.stdout).unwrap())
}

/// What an integer of an axis is worth, read from the written text.
fn units(c_text: &str) -> Vec<f64> {
    let defined = c_text.lines().filter(|line| line.starts_with("#define") && line.contains("_UNIT "));
    defined.map(|line| line.split_whitespace().nth(2).unwrap().parse().unwrap()).collect()
}

/// Holds a program's lines against the host's curves: floating point to `relative` of the drift's size, integers to a few
/// of their units.
fn compare(calibration: &Calibration, printed: &str, units: &[f64], relative: f64) {
    let mut rows = 0;
    let slopes: Vec<f64> = calibration.axes.values().map(|axis| steepest(axis.drift())).collect();
    for line in printed.lines() {
        let cells: Vec<f64> = line.split_whitespace().map(|cell| cell.parse().unwrap()).collect();
        for (place, (axis, unit)) in calibration.axes.values().zip(units).enumerate() {
            let size = axis.drift().peak_to_peak() + axis.drift().evaluate(cells[0]).0.abs();
            let expected = axis.drift().evaluate(cells[0]).0;
            let (float, integer) = (cells[1 + 2 * place], cells[2 + 2 * place] * unit);
            assert!((float - expected).abs() <= relative * size, "{line}: axis {place}: {float}, not {expected}");
            // The temperature is rounded to 65536ths, at the ends of the range inwards.
            let rounding = slopes[place] * 2_f64.powi(-16);
            assert!(
                (integer - expected).abs() <= 8.0 * unit + rounding,
                "{line}: axis {place}: {integer}, not {expected}"
            );
        }
        rows += 1;
    }
    assert_eq!(rows, 2801);
}

/// The steepest slope of a drift.
fn steepest(drift: &Drift) -> f64 {
    let at = |i: i32| drift.evaluate(f64::from(i) * 0.05).0;
    (-800..2000).map(|i| (at(i + 1) - at(i)).abs() / 0.05).fold(0.0, f64::max)
}

fn board() -> Calibration {
    let mut board = calibration(vec![
        ("x", axis(drift(&[8213.5, -220.0, 27.0], false, -30.0, 70.0), RateUnit::Counts)),
        ("y", axis(drift(&[-0.4, 1.5], true, -30.0, 70.0), RateUnit::Dps)),
    ]);
    board.unit_serial = None;
    board
}

fn written(calibration: &Calibration, format: Format) -> String {
    export(calibration, format, &ExportOptions::default()).unwrap().text
}

fn c(folder: &Path, text: &str, main: &str, options: &[&str]) -> Option<String> {
    std::fs::write(folder.join("calibration.h"), text).unwrap();
    std::fs::write(folder.join("main.c"), main).unwrap();
    let strict = [
        "-std=c99",
        "-O1",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-pedantic",
        "-fsanitize=undefined",
        "-fno-sanitize-recover",
    ];
    run(Command::new("gcc").current_dir(folder).args(strict).args(options).args(["main.c", "-lm", "-o", "main"]))?;
    run(&mut Command::new(folder.join("main")))
}

#[test]
fn the_compiled_c_is_the_hosts_model_over_the_whole_range() {
    let folder = tempfile::tempdir().unwrap();
    for calibration in [three_axes(), board()] {
        let text = written(&calibration, Format::C);
        let Some(doubles) = c(folder.path(), &text, C_MAIN, &["-DZERORATE_REAL=double"]) else {
            eprintln!("skipped: there is no gcc");
            return;
        };
        compare(&calibration, &doubles, &units(&text), 1e-14);
        let singles = c(folder.path(), &text, C_MAIN, &[]).unwrap();
        compare(&calibration, &singles, &units(&text), 2e-6);
    }
}

#[test]
fn the_integers_of_the_c_need_no_floating_point() {
    let folder = tempfile::tempdir().unwrap();
    let main = "#define ZERORATE_NO_FLOAT\n#include \"calibration.h\"\nint main(void) { return zr_int_bias(&ZR_INT_AXES[0], 0) == 0; }";
    let text = written(&three_axes(), Format::C);
    std::fs::write(folder.path().join("calibration.h"), text).unwrap();
    std::fs::write(folder.path().join("main.c"), main).unwrap();
    // Without -lm, and without the registers that doubles need.
    let built =
        run(Command::new("gcc").current_dir(folder.path()).args(["-std=c99", "-mgeneral-regs-only", "-c", "main.c"]));
    assert!(built.is_some() || Command::new("gcc").output().is_err());
}

/// The same program run through two hours of a temperature cycle that begins in the middle, a second a step.
const C_HISTORY: &str = r#"
#include <stdio.h>
#include "calibration.h"
int main(void)
{
    zr_state state[ZR_AXIS_COUNT] = {{0}};
    zr_int_state int_state[ZR_AXIS_COUNT] = {{0}};
    for (int i = 0; i <= 7200; i++) {
        double t = 20 + 60 * sin(i * 0.0031) + 5 * sin(i * 0.05);
        printf("%.17g", t);
        for (int a = 0; a < ZR_AXIS_COUNT; a++) {
            zr_advance(&ZR_AXES[a], &state[a], (zr_real)t, (zr_real)1);
            zr_int_advance(&ZR_INT_AXES[a], &int_state[a], (int32_t)(t * 65536.0 + (t < 0 ? -0.5 : 0.5)));
            printf(" %.17g %ld", (double)zr_bias_with_history(&ZR_AXES[a], &state[a]),
                   (long)zr_int_bias_with_history(&ZR_INT_AXES[a], &int_state[a]));
        }
        printf("\n");
    }
    return 0;
}
"#;

#[test]
fn a_format_without_histories_says_whose_are_missing() {
    let table = export(&with_history(), Format::Csv, &ExportOptions::default()).unwrap();
    let [note] = &table.notes.iter().filter(|note| note.contains("history")).collect::<Vec<_>>()[..] else {
        panic!("{:?}", table.notes)
    };
    assert!(note.starts_with("the history (plays, lags) of gyro0.x, gyro0.z is not in the table"), "{note}");
    let mut calibration = with_history();
    let fit = &mut calibration.axes.get_mut("gyro0.x").unwrap().fit;
    let (drift, in_sample) = (fit.model.drift.clone(), fit.statistics.in_sample);
    fit.static_cubic = Some(StaticCubic { drift, in_sample, held_out: None, deployed: None });
    let table = export(&calibration, Format::Csv, &ExportOptions::default()).unwrap().text;
    let heads = csv::Reader::from_reader(table.as_bytes()).headers().unwrap().clone();
    assert_eq!(
        heads.iter().skip(1).collect::<Vec<_>>(),
        [
            "gyro0.x bias by the cubic without its history, rad/s",
            "gyro0.y bias, rad/s",
            "gyro0.z bias by the curve without its history, rad/s"
        ]
    );
    let cost = |name: &str| ExportedAxis::of(name, &calibration.axes[name]).cost(RateScale::own(RateUnit::RadPerS));
    assert!(cost("gyro0.x").contains(" less its history (plays, lags) at most"), "{}", cost("gyro0.x"));
    assert!(!cost("gyro0.y").contains("history"), "{}", cost("gyro0.y"));
}

/// An axis with two plays and a lag, one with a lag alone, one without a history.
fn with_history() -> Calibration {
    let term = |memory, weight, behind, share| Term { memory, weight, behind, share };
    let mut calibration = three_axes();
    let x = calibration.axes.get_mut("gyro0.x").unwrap();
    let terms = [
        term(Memory::Play { half_width: 2.0 }, 6e-5, 0.0, 0.2),
        term(Memory::Play { half_width: 15.0 }, -1.1e-4, 0.0, 0.5),
        term(Memory::Lag { time_constant_s: 480.0 }, 4e-5, 0.3, 0.3),
    ];
    let curve = drift(&[2.9e-3, -8.0e-3, 4.1e-3, 1.9e-3], false, -17.613, 74.021).shape;
    x.fit.model.history = Some(History::new(curve, &terms).unwrap());
    let z = calibration.axes.get_mut("gyro0.z").unwrap();
    let curve = drift(&[1e-3, 2e-3, -1e-3, 4e-3], true, -17.613, 74.021).shape;
    z.fit.model.history =
        Some(History::new(curve, &[term(Memory::Lag { time_constant_s: 60.0 }, 2e-5, -0.2, 1.0)]).unwrap());
    calibration
}

/// Holds a program's lines against the host's model of the same temperatures.
fn compare_history(calibration: &Calibration, printed: &str, units: &[f64], relative: f64) {
    let models = calibration.axes.values().map(|axis| &axis.fit.model);
    let mut predictors: Vec<Predictor<'_>> = models.map(|model| Predictor::new(model, Start::Unknown)).collect();
    let mut apart = 0.0_f64;
    for (step, line) in printed.lines().enumerate() {
        let cells: Vec<f64> = line.split_whitespace().map(|cell| cell.parse().unwrap()).collect();
        for (place, axis) in calibration.axes.values().enumerate() {
            let expected = predictors[place].predict(step as f64, cells[0]).bias;
            apart = apart.max((expected - axis.drift().evaluate(cells[0]).0).abs());
            let size = axis.drift().peak_to_peak();
            let (float, integer) = (cells[1 + 2 * place], cells[2 + 2 * place] * units[place]);
            assert!((float - expected).abs() <= relative * size, "{line}: axis {place}: {float}, not {expected}");
            // A lag in 2^-24 forgets by 2^-25 of a step's part more or less: 3e-5 of what it holds at 480 steps.
            assert!((integer - expected).abs() <= 2e-5 * size, "{line}: axis {place}: {integer}, not {expected}");
        }
    }
    assert_eq!(printed.lines().count(), 7201);
    assert!(apart > 1e-3, "the history must be seen: {apart}");
}

#[test]
fn histories_in_c_are_the_hosts_through_a_cycle() {
    let folder = tempfile::tempdir().unwrap();
    let calibration = with_history();
    let text = written(&calibration, Format::C);
    let units = units(&text);
    let Some(doubles) = c(folder.path(), &text, C_HISTORY, &["-DZERORATE_REAL=double"]) else {
        eprintln!("skipped: there is no gcc");
        return;
    };
    compare_history(&calibration, &doubles, &units, 1e-12);
    compare_history(&calibration, &c(folder.path(), &text, C_HISTORY, &[]).unwrap(), &units, 1e-5);
}

/// Two columns that are one word in C are two axes all the same.
#[test]
fn no_macro_stands_for_two_axes() {
    let axis = || board().axes.into_values().next().unwrap();
    let text = written(&calibration(vec![("a.x", axis()), ("a_x", axis())]), Format::C);
    let defined: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("#define ")?.split(' ').next()).collect();
    let mut once = defined.clone();
    once.sort_unstable();
    once.dedup();
    assert_eq!(once.len(), defined.len(), "{defined:?}");
}
