//! The interface as C sees it: the header is the sources', and a program built by gcc does what Rust does.
#![allow(clippy::unwrap_used)] // helpers of tests, all of it

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use zerorate_core::board::BoardNumbers;
use zerorate_core::compensate::{AxisCompensation, EdgeTable, LowPass, Mode};
use zerorate_core::drift::{Coverage, Drift, History, Knowledge, Memory, Polynomial, Scale, Shape, Term, ValidRange};
use zerorate_core::group::GroupSums;
use zerorate_core::record::{AxisModel, DeviceRecord, HistoryModel, MAX_RECORD_BYTES, UnitSerial};
use zerorate_core::trim::{TapEffects, Trim, TrimLine};
use zerorate_core::units::{Axis, Counts, Taps, TemperatureScale};

const SERIAL: &str = "ZR-0001";
/// With four samples a group, a temperature sum is a code; the example has the same number.
const SAMPLES: u32 = 4;

fn crate_folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn the_header_is_what_the_sources_say() {
    let mut made = Vec::new();
    cbindgen::generate(crate_folder()).unwrap().write(&mut made);
    let made = String::from_utf8(made).unwrap();
    let path = crate_folder().join("include/zerorate.h");
    if std::env::var_os("ZERORATE_WRITE_HEADER").is_some() {
        std::fs::write(&path, &made).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(kept == made, "include/zerorate.h is old: ZERORATE_WRITE_HEADER=1 cargo test -p zerorate-ffi header");
}

/// X as in the paper; Y turns round inside its range and has its taps measured.
fn models() -> [AxisModel; 2] {
    let scale = Scale::spanning(8500.0, 11_900.0).unwrap();
    let valid = ValidRange::new(8500.0, 11_900.0).unwrap();
    let line = TrimLine::new(-0.031_990_6, 0.0, Counts(8200.0), Taps::MIDDLE).unwrap();
    let polynomial = |raw: &[f64]| Shape::Polynomial(Polynomial::from_raw_coefficients(scale, raw).unwrap());
    let uneven = |tap: u16| Counts(31.26 * (f64::from(tap) - 511.0) + 6.0 * (f64::from(tap) * 1.7).sin());
    let at_middle = uneven(511).0;
    let effects: Vec<Counts> = (495..=527).map(|tap| Counts(uneven(tap).0 - at_middle)).collect();
    let measured = TapEffects::new(Taps::new(495).unwrap(), &effects).unwrap();
    let axis = |shape: Shape, measured: Option<TapEffects>| {
        let mut axis = AxisModel {
            drift: Drift { shape, valid },
            trim: Trim { line, measured },
            dead_band: 0.05,
            low_pass: LowPass::first_order(40.0, 0.003, 0.0001),
            start_up_mode: Mode::Hybrid,
            edges: None,
            history: None,
        };
        axis.edges = Some(EdgeTable::solve(&axis.static_law(TemperatureScale::QUARTER_COUNTS)).unwrap());
        axis
    };
    [
        axis(polynomial(&[13_435.7, -0.894_782, 0.375_298e-4]), None),
        axis(polynomial(&[19_000.0, -2.15, 1.04e-4]), Some(measured)),
    ]
}

fn record_of(axes: &[AxisModel; 2]) -> DeviceRecord {
    DeviceRecord::new(
        UnitSerial::try_from(SERIAL).unwrap(),
        TemperatureScale::QUARTER_COUNTS,
        BoardNumbers::PAPER,
        axes,
    )
    .unwrap()
}

fn record() -> DeviceRecord {
    record_of(&models())
}

/// The same unit with a play and a lag in X.
fn record_with_history() -> DeviceRecord {
    let mut models = models();
    let axis = &mut models[0];
    let terms = [
        Term { memory: Memory::Play { half_width: 300.0 }, weight: 0.03, behind: 0.0, share: 0.6 },
        Term { memory: Memory::Lag { time_constant_s: 400.0 }, weight: -0.02, behind: 0.4, share: 0.4 },
    ];
    let history = History::new(axis.drift.shape.clone(), &terms).unwrap();
    axis.history = Some(HistoryModel { history, group_period_s: 5.0 });
    record_of(&models)
}

fn bytes(record: &DeviceRecord) -> Vec<u8> {
    let mut buffer = [0; MAX_RECORD_BYTES];
    record.encode(&mut buffer).unwrap().to_vec()
}

/// The example, built by gcc with every warning an error, against the static library.
struct Example {
    folder: tempfile::TempDir,
}

impl Example {
    fn build() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let built = Command::new(env!("CARGO"))
            .args(["build", "--package", "zerorate-ffi", "--target-dir"])
            .arg(target_folder())
            .current_dir(crate_folder())
            .status()
            .unwrap();
        assert!(built.success(), "the static library does not build");
        let compiled = Command::new("gcc")
            .args(["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", "-I"])
            .arg(crate_folder().join("include"))
            .arg(crate_folder().join("examples/closed_loop.c"))
            .arg(target_folder().join("debug/libzerorate_ffi.a"))
            .args(["-lm", "-lpthread", "-ldl", "-o"])
            .arg(folder.path().join("closed_loop"))
            .output()
            .expect("gcc is needed to build the example in C: install it (Debian: apt-get install gcc)");
        assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
        Self { folder }
    }

    fn run(&self, record: &[u8], serial: &str, axis: Axis, mode: u32, groups: String) -> Output {
        let file = self.folder.path().join(format!("{serial}-{}-{mode}.bin", axis.name()));
        std::fs::write(&file, record).unwrap();
        let mut child = Command::new(self.folder.path().join("closed_loop"))
            .arg(&file)
            .args([serial, &axis.index().to_string(), &mode.to_string()])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut stdin = child.stdin.take().unwrap();
        // It answers while it reads: both at once, or neither gets on. It may also refuse before it has read.
        let feeder = std::thread::spawn(move || stdin.write_all(groups.as_bytes()));
        let output = child.wait_with_output().unwrap();
        let _ = feeder.join().unwrap();
        output
    }
}

fn target_folder() -> PathBuf {
    // Cargo's folder for a test's own files is in the target folder.
    Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap().to_path_buf()
}

/// Every code upwards, every code downwards again, some great leaps; every hundredth group of the leaps is lost.
fn groups() -> Vec<GroupSums> {
    let up = 0..=u64::from(u16::MAX);
    let leaps = (0..1000_u64).map(|k| (k * 40_503) % 65_536);
    let codes = up.clone().chain(up.rev()).chain(leaps);
    let zro = |code: u64| 4 * 8200 + (code * 7919) % 211;
    let whole = |code| GroupSums { n: SAMPLES, temperature: code, zro: zro(code), ..GroupSums::default() };
    let mut groups: Vec<GroupSums> = codes.map(whole).collect();
    let swept = 2 * (usize::from(u16::MAX) + 1);
    groups[swept..].iter_mut().step_by(100).for_each(|group| *group = GroupSums::default());
    groups
}

fn in_rust(record: &DeviceRecord, axis: Axis, mode: Mode) -> String {
    let law = record.axis(axis).law().unwrap();
    let mut state = AxisCompensation::new(Some(&law), Taps::MIDDLE);
    state.set_mode(mode);
    let (mut lines, mut writes) = (String::new(), 0);
    for sums in groups() {
        if sums.n == 0 {
            state.skip_lost(SAMPLES);
            state.lose_groups(1);
            continue;
        }
        state.skip_samples(sums.n);
        let outcome = state.close_group(Some(&law), &sums);
        if let Some(tap) = outcome.move_to {
            state.wiper_written(Some(&law), tap);
            writes += 1;
        }
        let coverage = match outcome.coverage {
            Coverage::Inside => 0,
            Coverage::Below => 1,
            Coverage::Above => 2,
            Coverage::Invalid => 3,
        };
        let known = u8::from(outcome.knowledge == Knowledge::Known);
        writeln!(lines, "{} {} {coverage} {known} {writes}", state.tap().get(), outcome.corrected.0).unwrap();
    }
    lines
}

#[test]
fn c_gives_the_taps_and_readings_of_rust_at_all_codes() {
    let example = Example::build();
    let mut input = String::new();
    for sums in groups() {
        writeln!(input, "{} {} {}", sums.n, sums.temperature, sums.zro).unwrap();
    }
    let (with, without) = (record_with_history(), record());
    for (record, axis) in [(&without, Axis::X), (&without, Axis::Y), (&with, Axis::X)] {
        for (number, mode) in [Mode::Off, Mode::Trim, Mode::Digital, Mode::Hybrid].into_iter().enumerate() {
            let number = u32::try_from(number).unwrap();
            let output = example.run(&bytes(record), SERIAL, axis, number, input.clone());
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let (c, rust) = (String::from_utf8(output.stdout).unwrap(), in_rust(record, axis, mode));
            let first = c.lines().zip(rust.lines()).position(|(c, rust)| c != rust);
            assert!(c == rust, "axis {}, mode {}: line {first:?} differs", axis.name(), mode.name());
            let seen = |column: usize| -> std::collections::BTreeSet<&str> {
                c.lines().map(|line| line.split(' ').nth(column).unwrap()).collect()
            };
            assert_eq!(seen(0).len() > 5, mode.moves_wiper(), "the comparison saw {} taps", seen(0).len());
            assert_eq!(
                seen(3).len() == 2,
                record.axis(axis).law.history.is_some(),
                "a history is unknown first, then known"
            );
        }
    }
}

#[test]
fn c_is_told_why_a_record_is_refused() {
    let example = Example::build();
    let refusal = |record: &[u8], serial: &str, mode: u32| {
        let output = example.run(record, serial, Axis::X, mode, String::new());
        assert!(!output.status.success());
        String::from_utf8(output.stderr).unwrap()
    };
    let good = bytes(&record());
    assert!(refusal(&good[..good.len() - 1], "-", 0).contains("zerorate_init: refused with 4"));
    let mut later = good.clone();
    later[4] = 99;
    assert!(refusal(&later, "-", 0).contains("zerorate_init: refused with 5"));
    assert!(refusal(&good, "ZR-0002", 0).contains("zerorate_init: refused with 6"));
    assert!(refusal(&good, SERIAL, 4).contains("zerorate_set_mode: refused with 3"));
    let mut still = record();
    still.axes[0].law.edges = None;
    let mut buffer = [0; MAX_RECORD_BYTES];
    let without_edges = still.encode(&mut buffer).unwrap();
    assert!(refusal(without_edges, SERIAL, 3).contains("zerorate_set_mode: refused with 8"));
}
