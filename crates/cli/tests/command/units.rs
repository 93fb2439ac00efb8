//! A folder of results: the units in it, and what has changed between two calibrations of one.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use super::{Ran, bench, zerorate};

/// A run's results by hand: when it was made, and how far its curve is above the paper's.
fn run(folder: &Path, serial: &str, started: &str, above: f64, verdict: &str) {
    fs::create_dir_all(folder).unwrap();
    let mut calibration: Value = serde_json::from_str(&bench::calibration()).unwrap();
    let constant = &mut calibration["axes"]["x"]["drift"]["scaled_coefficients"][0];
    *constant = json!(constant.as_f64().unwrap() + above);
    fs::write(folder.join("calibration.json"), calibration.to_string()).unwrap();
    let axis = json!({
        "model": "poly:2", "drift_raw_coefficients": [0.0, 0.0, 0.0], "drift_pp_counts": 381.04, "v0_counts": 8200.0,
        "trim_slope_taps_per_count": -0.03, "trim_intercept_taps": 0.0, "paper_trim_slope_taps_per_count": -0.03,
        "paper_trim_intercept_taps": 0.0, "temperature_counts": [8500.0, 11900.0], "fit_rms_counts": 1.0,
        "fit_pp_counts": 4.0, "held_out_rms_counts": 1.1, "held_out_pp_counts": 4.2,
    });
    let summary = json!({
        "schema": 2, "serial": serial, "verdict": verdict, "started": started, "wall_s": 3.0, "trim_part": "max5494",
        "counts_per_dps": -38.4, "axes": { "x": axis, "y": axis }, "tests": [], "checks": [], "recordings": [],
        "failed_checks": [], "warnings": [],
    });
    fs::write(folder.join("summary.json"), summary.to_string()).unwrap();
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join("units").join(name);
    // The second calibration lies first.
    run(&at("a"), "ZR-0002", "2026-11-20T08:00:00Z", 7.5, "rejected");
    run(&at("b"), "ZR-0002", "2026-10-20T08:00:00Z", 2.5, "good");
    run(&at("deep/er"), "ZR-0001", "2026-11-01T08:00:00Z", 0.0, "good");
    folder
}

fn listed(folder: &Path, more: &[&str]) -> Ran {
    zerorate(folder, &[&["units", "units"], more].concat())
}

#[test]
fn units_are_listed_by_their_serial_numbers_with_their_last_calibration() {
    let folder = folder();
    let ran = listed(folder.path(), &[]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    ran.says(&["units: 2 units, 3 calibrations; 1 rejected by the last"]);
    let rows = ran.out.lines().filter(|line| line.contains("ZR-"));
    let rows: Vec<String> = rows.map(|row| row.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    // 7.5 less 2.5 counts on X, and Y is the same.
    let expected = [
        "ZR-0001 1 2026-11-01 08:00 good 381.0 / 381.0 - / - - / - - / -",
        "ZR-0002 2 2026-11-20 08:00 rejected 381.0 / 381.0 - / - - / - 5.0 / 0.0",
    ];
    assert_eq!(rows, expected);
}

#[test]
fn a_unit_is_found_by_a_part_of_its_serial_number_with_all_of_its_calibrations() {
    let folder = folder();
    let units = listed(folder.path(), &["--serial", "0002", "--json"]).json()["units"].clone();
    assert_eq!(units.as_array().unwrap().len(), 1);
    let runs = units[0]["runs"].as_array().unwrap();
    let made: Vec<&str> = runs.iter().map(|run| run["started"].as_str().unwrap()).collect();
    assert_eq!(made, ["2026-10-20T08:00:00Z", "2026-11-20T08:00:00Z"]);
    assert_eq!(runs[0]["axes"]["x"]["change_counts"], Value::Null);
    let change = runs[1]["axes"]["x"]["change_counts"].as_f64().unwrap();
    assert!((change - 5.0).abs() < 1e-9, "{change}");
    let lines = listed(folder.path(), &["--serial", "0002"]);
    assert_eq!(lines.out.lines().filter(|line| line.contains("ZR-0002")).count(), 2);
    listed(folder.path(), &["--serial", "0003"]).is_error(&["no results", "0003"]);
}

#[test]
fn the_page_of_the_units_draws_what_has_changed_and_is_written_over_nothing_else() {
    let folder = folder();
    let page = folder.path().join("units.html");
    let report = ["--report", "units.html"];
    listed(folder.path(), &report).says(&["Wrote units.html."]);
    let read = fs::read_to_string(&page).unwrap();
    // 31 days from the first to the second, and 5 counts.
    for told in
        ["days since 2026-10-20", "changed by 5.0 counts at most", "5.0 / 0.0", "1 unit was calibrated more than once"]
    {
        assert!(read.contains(told), "{told}");
    }
    assert_eq!(read.matches("<figure id=").count(), 1);
    assert_eq!(read.matches("<th scope=\"row\">").count(), 3, "a row for each calibration");
    let again = listed(folder.path(), &report);
    assert_eq!((again.code, fs::read_to_string(&page).unwrap() == read), (0, true));
    fs::write(&page, "my page, made by zerorate").unwrap();
    listed(folder.path(), &report).is_error(&["--report units.html: there is a file already", "--force"]);
    assert_eq!(listed(folder.path(), &[&report[..], &["--force", "--json"]].concat()).code, 0);
    assert!(fs::read_to_string(&page).unwrap() == read);
    listed(folder.path(), &["--report", "nowhere/units.html"]).is_error(&["there is no folder nowhere"]);
}

#[test]
fn what_cannot_be_read_is_told_and_the_others_are_listed() {
    let folder = folder();
    fs::write(folder.path().join("units/b/summary.json"), "{").unwrap();
    let ran = listed(folder.path(), &[]);
    assert_eq!(ran.code, 2);
    ran.says(&["b/summary.json", "2 units, 2 calibrations"]);
    fs::create_dir(folder.path().join("empty")).unwrap();
    zerorate(folder.path(), &["units", "empty"]).is_error(&["empty", "no results"]);
    zerorate(folder.path(), &["units", "nowhere"]).is_error(&["nowhere"]);
}

#[test]
fn simulated_units_of_other_plants_or_seeds_are_others() {
    let folder = tempfile::tempdir().unwrap();
    for (name, plant, seed) in [("a", "paper", 1), ("b", "typical", 7), ("c", "typical", 7)] {
        let at = folder.path().join("units").join(name);
        run(&at, "ZR-0001", "2026-11-20T08:00:00Z", 0.0, "good");
        let mut summary: Value = serde_json::from_str(&fs::read_to_string(at.join("summary.json")).unwrap()).unwrap();
        (summary["plant"], summary["seed"]) = (json!(plant), json!(seed));
        fs::write(at.join("summary.json"), summary.to_string()).unwrap();
    }
    let json = listed(folder.path(), &["--json"]).json();
    let plants: Vec<_> = json["units"].as_array().unwrap().iter().map(|unit| unit["plant"].as_str().unwrap()).collect();
    assert_eq!(plants, ["paper, seed 1", "typical, seed 7"]);
    listed(folder.path(), &[]).says(&["ZR-0001, simulated: typical, seed 7"]);
}
