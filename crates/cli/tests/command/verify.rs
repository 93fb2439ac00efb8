use std::fs;

use tempfile::TempDir;

use crate::log::Log;
use crate::{folder_with, zerorate};

/// A calibration, its own log, and a second run with another noise.
fn calibrated() -> TempDir {
    let folder = folder_with("log.csv", Log::cycle().csv());
    let ran = zerorate(folder.path(), &["fit", "log.csv", "--out", "calibration.json"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let mut second = Log::cycle();
    second.rates.iter_mut().for_each(|rate| rate.iter_mut().for_each(|value| *value += 0.004));
    fs::write(folder.path().join("second.csv"), second.csv()).unwrap();
    folder
}

#[test]
fn a_second_run_passes_or_fails_by_its_limits() {
    let folder = calibrated();
    let verify = ["verify", "second.csv", "--with", "calibration.json"];
    let ran = zerorate(folder.path(), &verify);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    ran.says(&["second.csv: measured: no limits were given", "x_rad_s", "mrad/s"]);
    let passed = zerorate(folder.path(), &[&verify[..], &["--max-rms", "0.5mrad/s", "--max-pp", "2 mrad/s"]].concat());
    assert_eq!(passed.code, 0, "{}", passed.out);
    passed.says(&["passed: all axes are within"]);
    let failed = zerorate(folder.path(), &[&verify[..], &["--max-offset", "1mrad/s"]].concat());
    assert_eq!(failed.code, 1);
    failed.says(&["failed", "x_rad_s: mean 4.0", "times the limit of 1 mrad/s"]);
    let json = zerorate(folder.path(), &[&verify[..], &["--max-offset", "1mrad/s", "--json"]].concat()).json();
    assert_eq!((&json["passed"], &json["in_sample"]), (&false.into(), &false.into()));
    assert!((json["axes"][0]["offset"].as_f64().unwrap() - 0.004).abs() < 1e-4);
}

#[test]
fn the_log_that_was_fitted_is_refused_as_no_test() {
    let folder = calibrated();
    let verify = ["verify", "log.csv", "--with", "calibration.json"];
    zerorate(folder.path(), &verify).is_error(&["fitted on this very log", "--in-sample"]);
    let looked = zerorate(folder.path(), &[&verify[..], &["--in-sample"]].concat());
    assert_eq!(looked.code, 0);
    looked.says(&["in-sample, and no test"]);
}

#[test]
fn limits_come_from_a_file_and_its_mistakes_are_named_by_line() {
    let folder = calibrated();
    let limits = folder.path().join("limits.toml");
    let verify = ["verify", "second.csv", "--with", "calibration.json", "--limits", "limits.toml"];
    fs::write(&limits, "max_rms = \"0.5 mrad/s\"\n[axes.x_rad_s]\nmax_offset = \"10 mrad/s\"\n").unwrap();
    assert_eq!(zerorate(folder.path(), &verify).code, 0);
    fs::write(&limits, "max_rms = \"0.5 mrad/s\"\nmax_pp = \"3\"\n").unwrap();
    zerorate(folder.path(), &verify).is_error(&["limits.toml:2", "'3' is no limit"]);
    fs::write(&limits, "[axes.roll]\nmax_pp = \"3 dps\"\n").unwrap();
    zerorate(folder.path(), &verify).is_error(&["'roll'"]);
}
