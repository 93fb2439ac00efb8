//! Places that cannot be written to: refused before the work where that can be told, and never at the cost of what is
//! there.

use std::fs;
use std::process::Command;

use crate::log::Log;
use crate::{folder_with, ran, zerorate};

#[test]
fn a_folder_that_is_missing_or_a_file_is_named_before_any_work() {
    let folder = folder_with("log.csv", Log::cycle().csv());
    for (option, place, part) in [
        ("--out", "nowhere/calibration.json", "there is no folder nowhere: make it first (mkdir -p nowhere)"),
        ("--out", "log.csv/calibration.json", "log.csv is a file, not a folder"),
        ("--report", ".", "this is a folder: give the name of a file in it"),
    ] {
        zerorate(folder.path(), &["fit", "log.csv", option, place]).is_error(&[option, place, part]);
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn two_results_in_one_place_are_refused_however_it_is_written() {
    let folder = folder_with("log.csv", Log::cycle().csv());
    for places in [
        ["--out", "p.json", "--report", "p.json"],
        ["--out", "p.json", "--report", "./p.json"],
        ["--record", "p.json", "--out", "p.json"],
    ] {
        let ran = zerorate(folder.path(), &[&["fit", "log.csv"], &places[..]].concat());
        ran.is_error(&["--out", "are one file", "p.json", "one would be lost"]);
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    #[cfg(unix)]
    assert_eq!(zerorate(folder.path(), &["fit", "log.csv", "--out", "/dev/null", "--report", "/dev/null"]).code, 0);
}

#[cfg(target_os = "linux")]
#[test]
fn a_device_that_is_full_is_an_error_and_stays_a_device() {
    use std::os::unix::fs::FileTypeExt;
    let folder = folder_with("log.csv", Log::cycle().csv());
    assert_eq!(zerorate(folder.path(), &["fit", "log.csv", "--out", "c.json"]).code, 0);
    zerorate(folder.path(), &["fit", "log.csv", "--out", "/dev/full"])
        .is_error(&["/dev/full: cannot be written", "No space"]);
    zerorate(folder.path(), &["fit", "log.csv", "--report", "/dev/full"])
        .is_error(&["/dev/full: cannot be written", "No space"]);
    zerorate(folder.path(), &["apply", "c.json", "log.csv", "--out", "/dev/full"])
        .is_error(&["/dev/full: cannot be written", "No space"]);
    assert!(fs::metadata("/dev/full").unwrap().file_type().is_char_device());
}

/// A file system of 64 kB of its own, nearly full with earlier results: nothing of them is lost, nothing is left beside
/// them.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_the_earlier_output() {
    let folder = folder_with("log.csv", Log::cycle().csv());
    assert_eq!(zerorate(folder.path(), &["fit", "log.csv", "--out", "c.json"]).code, 0);
    fs::create_dir(folder.path().join("disk")).unwrap();
    let program = env!("CARGO_BIN_EXE_zerorate");
    let in_full_disk = |command: &str, output: &str| {
        let script = format!(
            "mount -t tmpfs -o size=64k tmpfs disk || exit 99
             head -c 61440 /dev/zero > disk/{output}
             '{program}' {command} disk/{output} --force
             code=$?
             test $(ls disk | wc -l) = 1 && test $(wc -c < disk/{output}) = 61440 || exit 98
             exit $code"
        );
        let unshare = Command::new("unshare").args(["-rm", "sh", "-c", &script]).current_dir(folder.path()).output();
        unshare.ok().map(|output| ran(&[], output)).filter(|ran| ran.code != 99 && !ran.err.starts_with("unshare"))
    };
    for (command, output) in [
        ("fit log.csv --out", "calibration.json"),
        ("fit log.csv --report", "report.html"),
        ("apply c.json log.csv --out", "corrected.csv"),
    ] {
        match in_full_disk(command, output) {
            Some(ran) => ran.is_error(&[output, "cannot be written", "No space left", "as it was"]),
            None => {
                eprintln!("skipped: this system does not let a test mount a file system of its own");
                return;
            }
        }
    }
}
