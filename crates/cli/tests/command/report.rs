use std::fs;

use tempfile::TempDir;

use crate::log::Log;
use crate::{bench, folder_with, zerorate};

#[test]
fn the_report_made_again_is_the_one_that_fit_made() {
    for options in [&[][..], &["--plain", "--model", "poly:3"], &["--model", "table:6"], &["--group-seconds", "40"]] {
        let folder = folder_with("log.csv", Log::cycle().csv());
        let fit = ["fit", "log.csv", "--out", "calibration.json"];
        assert_eq!(zerorate(folder.path(), &[&fit, options].concat()).code, 0);
        assert_eq!(zerorate(folder.path(), &[&["fit", "log.csv", "--report", "first.html"], options].concat()).code, 0);
        let ran = zerorate(folder.path(), &["report", "."]);
        assert_eq!(ran.code, 0, "{}", ran.err);
        ran.says(&["report.html, from "]);
        let read = |name| fs::read_to_string(folder.path().join(name)).unwrap();
        assert!(read("report.html") == read("first.html"), "another report, with {options:?}");
    }
}

#[test]
fn another_log_than_the_calibrations_own_is_refused() {
    let folder = folder_with("log.csv", Log::cycle().csv());
    zerorate(folder.path(), &["fit", "log.csv", "--out", "calibration.json"]);
    fs::write(folder.path().join("report.html"), "earlier").unwrap();
    fs::write(folder.path().join("other.csv"), "t_s,temperature_c,x_rad_s,y_rad_s\n").unwrap();
    zerorate(folder.path(), &["report", "calibration.json", "--log", "other.csv"])
        .is_error(&["other.csv: not the log", "SHA-256"]);
    let made = ["report", "calibration.json", "--log", "log.csv", "--out", "page.html", "--json"];
    assert_eq!(zerorate(folder.path(), &made).json()["log"], "log.csv");
    fs::remove_file(folder.path().join("log.csv")).unwrap();
    zerorate(folder.path(), &["report", "calibration.json"])
        .is_error(&["log.csv: cannot be read", "--log says where it is"]);
    assert_eq!(fs::read_to_string(folder.path().join("report.html")).unwrap(), "earlier");
}

#[test]
fn of_several_logs_the_others_are_looked_for_beside_the_first() {
    let folder = folder_with("one.csv", Log::cycle().csv());
    fs::write(folder.path().join("two.csv"), Log::cycle_of_run(2).csv()).unwrap();
    let fit = ["fit", "one.csv", "two.csv", "--out", "calibration.json"];
    assert_eq!(zerorate(folder.path(), &fit).code, 0);
    assert_eq!(zerorate(folder.path(), &["report", "."]).code, 0);
    fs::remove_file(folder.path().join("two.csv")).unwrap();
    zerorate(folder.path(), &["report", ".", "--log", "one.csv"])
        .is_error(&["two.csv: cannot be read", "put it beside one.csv"]);
}

#[test]
fn a_report_in_another_unit_than_the_fits_is_refused() {
    let mut log = Log::cycle();
    log.rates.iter_mut().flatten().for_each(|rate| *rate *= 1.0_f64.to_degrees() * 1e3);
    let folder = folder_with("log.csv", log.csv().replacen("x_rad_s,y_rad_s", "gx,gy", 1));
    let fit = ["fit", "log.csv", "--rate-unit", "mdps", "--out", "calibration.json"];
    assert_eq!(zerorate(folder.path(), &fit).code, 0);
    zerorate(folder.path(), &["report", "."]).is_error(&["gx does not come out", "--rate-unit"]);
    assert!(!folder.path().join("report.html").exists());
    assert_eq!(zerorate(folder.path(), &["report", ".", "--rate-unit", "mdps"]).code, 0);
}

/// A folder with the runs of a board by some seeds, each in a folder of its number; ramps and soaks are short.
fn runs(seeds: &[&str]) -> TempDir {
    let setup = "[chamber]\nramp_groups = 1600\nsoak_s = 600.0\nsoaks_c = [0.0, 20.0]\n";
    let folder = folder_with("short.toml", setup);
    for seed in seeds {
        let ran = zerorate(folder.path(), &["calibrate", "--setup", "short.toml", "--seed", seed, "--out", seed]);
        assert_eq!(ran.code, 0, "{}", ran.err);
    }
    folder
}

#[test]
fn a_boards_report_made_again_is_the_one_that_calibrate_or_fit_made() {
    let folder = runs(&["1"]);
    let read = |name| fs::read(folder.path().join(name)).unwrap();
    let first = read("1/report.html");
    let sheet = read("1/certificate.html");
    let ran = zerorate(folder.path(), &["report", "1", "--out", "again.html"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    ran.says(&["again.html, from 1/calibration.json and the files beside it"]);
    assert!(read("again.html") == first, "another report");
    let hourly = zerorate(folder.path(), &["report", "1", "--units", "deg/h", "--out", "hourly.html"]);
    assert_eq!(hourly.code, 0, "{}", hourly.err);
    let page = String::from_utf8(read("hourly.html")).unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&read("1/summary.json")).unwrap();
    let counts = summary["tests"][0]["residual_pp_counts"].as_f64().unwrap();
    let hourly = 3600.0 * counts / summary["counts_per_dps"].as_f64().unwrap().abs();
    let told = page.split("data-head=\"Left, pp, deg/h\">").nth(1).and_then(|rest| rest.split('<').next()).unwrap();
    let told: f64 = told.replace(['\u{a0}', ' '], "").parse().expect("a number");
    assert!((told / hourly - 1.0).abs() < 0.006 && !page.contains("Left, pp, deg/s"), "{told} for {hourly}");
    fs::remove_file(folder.path().join("1/report.html")).unwrap();
    fs::remove_file(folder.path().join("1/certificate.html")).unwrap();
    let done = zerorate(&folder.path().join("1"), &["report", ".", "--json"]).json();
    assert_eq!((&done["out"], &done["certificate"]), (&"report.html".into(), &"certificate.html".into()));
    assert!(read("1/report.html") == first && read("1/certificate.html") == sheet, "another report or certificate");
    let both = ["report", "1", "--out", "again.html", "--certificate", "sheet.html"];
    zerorate(folder.path(), &both).says(&["Wrote again.html and sheet.html, from 1/calibration.json"]);
    assert!(read("sheet.html") == sheet, "another certificate");
    fs::write(folder.path().join("mine.html"), "my page").unwrap();
    let mine = ["report", "1", "--out", "again.html", "--certificate", "mine.html"];
    zerorate(folder.path(), &mine).is_error(&["--certificate mine.html: there is a file already", "--force"]);
    zerorate(folder.path(), &["report", "1", "--log", "log.csv"]).is_error(&["a board's run has no log"]);

    // Of a recording alone.
    fs::copy(folder.path().join("1/full-temperature.parquet"), folder.path().join("ramp.parquet")).unwrap();
    for (option, file) in [("--out", "calibration.json"), ("--report", "fit.html")] {
        assert_eq!(zerorate(folder.path(), &["fit", "ramp.parquet", option, file]).code, 0);
    }
    assert_eq!(zerorate(folder.path(), &["report", "."]).code, 0);
    assert!(read("report.html") == read("fit.html"), "another report");
    zerorate(folder.path(), &["report", ".", "--certificate", "sheet.html"]).is_error(&["no board's run"]);
}

#[test]
fn a_boards_report_is_not_made_of_the_files_of_two_runs() {
    let folder = runs(&["1", "2"]);
    let place = |run: &str, file: &str| folder.path().join(run).join(file);
    for file in ["summary.json", "full-temperature.parquet", "compensation-test-hybrid.parquet"] {
        let own = fs::read(place("1", file)).unwrap();
        fs::copy(place("2", file), place("1", file)).unwrap();
        let named = format!("1/{file}: of another run than ");
        zerorate(folder.path(), &["report", "1"]).is_error(&[&named, "put the files of one run together"]);
        fs::write(place("1", file), own).unwrap();
    }
    fs::remove_file(place("1", "summary.json")).unwrap();
    zerorate(folder.path(), &["report", "1"]).is_error(&["summary.json: cannot be read"]);
}

#[test]
fn a_calibration_that_names_nothing_it_was_made_from_has_no_report() {
    let folder = folder_with("calibration.json", bench::calibration());
    zerorate(folder.path(), &["report", "."]).is_error(&["names no log"]);
    zerorate(folder.path(), &["report", "nothing"]).is_error(&["nothing: cannot be read"]);
}
