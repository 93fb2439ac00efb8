//! The second line as C reads it: a program built by gcc gives every scan that Rust sends, and none that was damaged.

#![allow(clippy::unwrap_used)] // what a test cannot do without

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use zerorate_core::compensate::Mode;
use zerorate_core::wire::{AxisScan, ScanFlags, ScanReport};

/// Scans whose bytes have zeros in many places, none and only them.
fn reports() -> Vec<ScanReport> {
    let values = [0, 1, -1, 0x2008_4000, i32::MIN, i32::MAX, 0x0100_0001, 0x7F00_FF00];
    let flags = [
        ScanFlags::default(),
        ScanFlags::of(Mode::Hybrid).and(ScanFlags::AT_WORK),
        ScanFlags::of(Mode::Trim).and(ScanFlags::SATURATED).and(ScanFlags::HELD),
    ];
    let mut reports = Vec::new();
    for (number, &x) in (0..).zip(&values) {
        for (place, &y) in values.iter().enumerate() {
            let axis = |corrected_q16, of: usize| AxisScan { corrected_q16, flags: flags[of % 3] };
            reports.push(ScanReport { scan: number << 8 | 3, axes: [axis(x, place), axis(y, place + 1)] });
        }
    }
    reports
}

/// As the example prints them.
fn printed(reports: &[ScanReport]) -> String {
    let bits = |flags: ScanFlags| u8::from_str_radix(&format!("{flags:?}")[2..], 2).unwrap();
    let axis = |axis: &AxisScan| format!("{:.5} {:02x}", axis.counts(), bits(axis.flags));
    reports.iter().map(|r| format!("{} {} {}\n", r.scan, axis(&r.axes[0]), axis(&r.axes[1]))).collect()
}

#[test]
fn a_program_in_c_reads_every_scan_and_is_in_step_again_after_damage() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("read_scans");
    let compiled = Command::new("gcc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror", "-fsanitize=undefined"])
        .arg("-I")
        .arg(here.join("include"))
        .arg(here.join("examples/read_scans.c"))
        .arg("-o")
        .arg(&program)
        .status()
        .expect("gcc is needed to build the example in C: install it (Debian: apt-get install gcc)");
    assert!(compiled.success());

    let reports = reports();
    let frames: Vec<_> = reports.iter().map(|report| report.frame().unwrap()).collect();
    // Half a frame first; then each whole, and between them one with a byte bent, one too short and one too long.
    let mut bytes = frames[0][7..].to_vec();
    for (number, frame) in frames.iter().enumerate() {
        let mut bent = frame.to_vec();
        bent[number % 19] ^= 0x41;
        let short = &frame[..number % 19];
        bytes.extend(frame.iter().chain(&bent).chain(short).chain(&[0]).chain(&frame[..19]).chain(frame));
    }
    let mut child = Command::new(&program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let writing = std::thread::spawn(move || stdin.write_all(&bytes).unwrap());
    let output = child.wait_with_output().unwrap();
    writing.join().unwrap();
    assert!(output.status.success());
    assert_eq!(String::from_utf8(output.stdout).unwrap(), printed(&reports));
}
