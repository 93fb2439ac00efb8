use std::fs;
use std::path::Path;

use crate::log::{Log, real_file};
use crate::{Ran, folder_with, schema, zerorate};

/// Fits a log with earlier results in its folder, and makes sure that they are as they were.
#[track_caller]
fn fit_beside_earlier(log: &str, options: &[&str]) -> Ran {
    let folder = folder_with("log.csv", log);
    let results = ["calibration.json", "report.html"];
    results.iter().for_each(|name| fs::write(folder.path().join(name), "earlier").unwrap());
    let ran = zerorate(
        folder.path(),
        &[&["fit", "log.csv", "--out", "calibration.json", "--report", "report.html"], options].concat(),
    );
    for name in results {
        assert_eq!(fs::read_to_string(folder.path().join(name)).unwrap(), "earlier", "{}{}", ran.out, ran.err);
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3, "nothing is left beside them");
    ran
}

#[test]
fn a_good_log_is_fitted_and_the_next_command_is_told() {
    let folder = folder_with("log.csv", Log::cycle().csv());
    let ran = zerorate(folder.path(), &["fit", "log.csv"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    ran.says(&[
        "log.csv: good: fitted",
        "Drift over -17.0 to 73.0 C, in mrad/s",
        "x_rad_s",
        "table:32",
        "held out",
        "Wrote log.report.html and log.calibration.json.",
        "zerorate apply log.calibration.json log.csv --out corrected.csv",
    ]);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3);
    fs::remove_file(folder.path().join("log.report.html")).unwrap();
    fs::remove_file(folder.path().join("log.calibration.json")).unwrap();
    for quiet in ["--json", "--plain"] {
        assert_eq!(zerorate(folder.path(), &["fit", "log.csv", quiet]).code, 0);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing is written unasked with {quiet}");
    }
}

#[test]
fn a_ulog_alone_gives_verdict_report_and_the_next_command_which_works() {
    let folder = folder_with("flight.ulg", Log::cycle().ulg());
    let ran = zerorate(folder.path(), &["fit", "flight.ulg"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    ran.says(&[
        "flight.ulg: good: fitted",
        "gyro0.x",
        "Wrote flight.report.html and flight.calibration.json.",
        "zerorate export flight.calibration.json --format px4",
    ]);
    let exported = zerorate(folder.path(), &["export", "flight.calibration.json", "--format", "px4"]);
    assert_eq!(exported.code, 0, "{}", exported.err);
    let info = zerorate(folder.path(), &["info", "flight.ulg"]);
    info.says(&["flight.ulg: a PX4 ULog, 70.0 min", "gyro0     2621448  8400"]);
}

#[test]
fn every_sensor_of_a_log_is_told_by_what_the_log_says_of_it() {
    for (topic, name) in [("sensor_gyro", "gyro0.x"), ("sensor_accel", "accel0.x")] {
        let folder = folder_with("flight.ulg", Log::cycle().ulg_of(topic));
        let axis = zerorate(folder.path(), &["fit", "flight.ulg", "--json"]).json()["axes"][name].clone();
        assert_eq!((&axis["sensor"]["instance"], &axis["sensor"]["device_id"]), (&0.into(), &2_621_448.into()));
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        let middle = f64::midpoint(number(&axis["temperature"][0]), number(&axis["temperature"][1]));
        match topic {
            "sensor_accel" => assert!((number(&axis["reference_temperature"]) - middle).abs() < 1e-9, "{axis}"),
            _ => assert!(axis["reference_temperature"].is_null(), "{axis}"),
        }
    }
}

#[test]
fn a_log_that_knows_its_date_is_told_by_it_and_another_by_its_files() {
    let whole = Log::cycle();
    // 3600 rows are half an hour.
    let (cold, warm) = (whole.rows(0..3600), whole.rows(3600..8400));
    let folder = folder_with("cold.ulg", cold.ulg());
    fs::write(folder.path().join("warm.ulg"), warm.ulg()).unwrap();
    fs::write(folder.path().join("log.csv"), whole.csv()).unwrap();
    let fit = |logs: &[&str]| {
        let ran = zerorate(
            folder.path(),
            &[&["fit", "--json", "--out", "c.json", "--report", "r.html", "--force"], logs].concat(),
        );
        let text = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
        let calibration: serde_json::Value = serde_json::from_str(&text("c.json")).unwrap();
        (ran.json(), calibration, text("r.html"))
    };
    let (printed, calibration, page) = fit(&["cold.ulg", "warm.ulg"]);
    assert_eq!(printed["started"], "2026-03-01T14:03:00Z");
    assert_eq!(calibration["sources"][1]["started"], "2026-03-01T14:33:00Z");
    assert!(page.contains("Recorded") && page.contains("2026-03-01 14:03 UTC, 2026-03-01 14:33 UTC"));
    assert!(!page.contains("File last changed"));
    zerorate(folder.path(), &["info", "c.json"]).says(&["warm.ulg (px4-log, recorded 2026-03-01T14:33:00Z, SHA-256"]);
    let (printed, calibration, page) = fit(&["log.csv"]);
    assert!(printed.get("started").is_none() && calibration["sources"][0].get("started").is_none());
    assert!(page.contains("File last changed") && !page.contains("Recorded"));
}

#[test]
fn a_cut_ulog_is_fitted_as_far_as_it_is_whole_and_says_so() {
    let log = Log::cycle().ulg();
    let folder = folder_with("cut.bin", &log[..log.len() - 10_003]);
    let ran = zerorate(folder.path(), &["fit", "cut.bin"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    ran.says(&["cut.bin: warning", "cut off in the middle of a message"]);
}

#[test]
fn logs_of_one_unit_make_one_fit_and_of_two_units_none() {
    let whole = Log::cycle();
    let folder = folder_with("cold.ulg", whole.rows(0..4000).ulg());
    fs::write(folder.path().join("warm.ulg"), whole.rows(4000..8400).ulg()).unwrap();
    let ran = zerorate(folder.path(), &["fit", "cold.ulg", "warm.ulg", "--out", "both.json"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    ran.says(&[
        "cold.ulg + warm.ulg: good",
        "Drift over -17.0 to 73.0 C",
        "Each log as the others predict it",
        "by a fit of the other logs, which has not seen this one",
    ]);
    let calibration: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path().join("both.json")).unwrap()).unwrap();
    schema::hold("calibration.json", &calibration);
    assert_eq!(calibration["sources"].as_array().unwrap().len(), 2);
    let mut other = whole.rows(4000..8400).ulg();
    let id = 2_621_448_u32.to_le_bytes();
    (0..other.len() - 4).for_each(|at| {
        if other[at..at + 4] == id {
            other[at] ^= 1;
        }
    });
    fs::write(folder.path().join("other.ulg"), other).unwrap();
    zerorate(folder.path(), &["fit", "cold.ulg", "other.ulg"]).is_error(&[
        "if it is another unit's, fit it by itself",
        "2621448",
        "2621449",
    ]);
}

#[test]
fn what_was_asked_for_is_written_and_named() {
    let folder = folder_with("my log.csv", Log::cycle().csv());
    let ran = zerorate(
        folder.path(),
        &["fit", "my log.csv", "--serial", "U7", "--out", "calibration.json", "--report", "report.html"],
    );
    assert_eq!(ran.code, 0, "{}", ran.err);
    ran.says(&[
        "Wrote report.html and calibration.json.",
        "zerorate apply calibration.json 'my log.csv' --out corrected.csv",
    ]);
    // The next command reads the log as it was read.
    let unnamed = Log::cycle().csv().replace("temperature_c", "die");
    fs::write(folder.path().join("unnamed.csv"), unnamed).unwrap();
    let ran = zerorate(
        folder.path(),
        &["fit", "unnamed.csv", "--temperature", "die", "--temperature-unit", "C", "--out", "own.json"],
    );
    assert_eq!(ran.code, 0, "{}", ran.err);
    let next = "zerorate apply own.json unnamed.csv --temperature die --temperature-unit celsius --out corrected.csv";
    ran.says(&[next]);
    assert_eq!(zerorate(folder.path(), &next.split(' ').skip(1).collect::<Vec<_>>()).code, 0);
    let calibration: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path().join("calibration.json")).unwrap()).unwrap();
    schema::hold("calibration.json", &calibration);
    assert_eq!((&calibration["schema"], &calibration["unit_serial"]), (&3.into(), &"U7".into()));
    let report = fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(report.contains("<svg") && report.contains("zerorate apply calibration.json"));
}

#[test]
fn json_stands_alone_on_standard_output_and_has_what_was_guessed() {
    let folder =
        folder_with("log.csv", Log::cycle().csv().replacen("t_s,temperature_c,x_rad_s,y_rad_s", "t,temp,gx,gy", 1));
    let ran = zerorate(folder.path(), &["fit", "log.csv", "--rate", "gx,gy", "--model", "poly:3", "--plain", "--json"]);
    let json = ran.json();
    assert_eq!((ran.code, json["schema"].as_u64(), json["verdict"].as_str()), (0, Some(1), Some("warning")));
    assert_eq!(json["axes"]["gx"]["model"], "poly:3");
    assert_eq!(json["axes"]["gy"]["raw_coefficients"].as_array().unwrap().len(), 4);
    assert_eq!(ran.err, "");
    let reasons = json["reasons"].as_array().unwrap();
    for (reason, (kind, text)) in reasons.iter().zip([
        ("assumed-unit", "'temp' names no unit: taken as degrees C"),
        ("guessed-unit", "'gx' names no unit: taken as rad/s"),
        ("assumed-unit", "'t' names no unit: taken as s"),
    ]) {
        assert_eq!(reason["kind"], kind);
        assert!(reason["text"].as_str().unwrap().starts_with(text), "{reason}");
    }
    assert_eq!(reasons.len(), 3);
}

#[test]
fn a_model_with_a_history_has_its_own_name_everywhere_and_its_static_cubic_another() {
    let mut log = Log::cycle();
    // What the sensor feels follows its temperature in five minutes.
    let mut felt = log.temperature_c[0];
    for (row, temperature) in log.temperature_c.iter().enumerate() {
        felt += 0.5 / 300.0 * (temperature - felt);
        log.rates.iter_mut().for_each(|rate| rate[row] += 1e-3 * (felt - temperature));
    }
    let folder = folder_with("log.csv", log.csv());
    let ran = zerorate(folder.path(), &["fit", "log.csv", "--report", "report.html"]);
    let json = zerorate(folder.path(), &["fit", "log.csv", "--json"]).json();
    let axis = &json["axes"]["x_rad_s"];
    let model = axis["model"].as_str().unwrap();
    assert!(model.contains(" + "), "{model}");
    assert_eq!((&axis["static_model"], axis["raw_coefficients"].as_array().unwrap().len()), (&"table:32".into(), 33));
    let row = ran.out.lines().find(|line| line.starts_with("  x_rad_s")).unwrap();
    assert!(row.contains(&format!("  {model}  ")), "{row}");
    let page = fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains(&format!("# x_rad_s, poly:3, the static cubic beside {model}\n# this cubic leaves ")));
}

#[test]
fn a_missing_file_and_an_empty_one_are_errors() {
    let folder = folder_with("empty.csv", "");
    zerorate(folder.path(), &["fit", "nothing.csv"]).is_error(&["nothing.csv: cannot be read", "No such file"]);
    zerorate(folder.path(), &["fit", "empty.csv"]).is_error(&["empty.csv: the file is empty"]);
    zerorate(folder.path(), &["fit", "."]).is_error(&[".: "]);
}

#[test]
fn a_wrong_column_is_answered_with_those_there_are() {
    let log = "t_s,heat,x_dps\n0,20,1\n";
    fit_beside_earlier(log, &[]).is_error(&["no column could be the temperature", "--temperature", "t_s, heat, x_dps"]);
    fit_beside_earlier(log, &["--temperature", "hot"]).is_error(&["there is no column 'hot'", "t_s, heat, x_dps"]);
    fit_beside_earlier(log, &["--temperature", "heat", "--rate", "x_dps,y_dps"])
        .is_error(&["there is no column 'y_dps'"]);
}

#[test]
fn text_for_a_number_is_named_by_line_and_column() {
    let log = Log::cycle().csv().replacen("\n100,", "\nnoon,", 1);
    fit_beside_earlier(&log, &[]).is_error(&["log.csv: line 202: column 't_s' holds 'noon'"]);
    let cut = "t_s,temperature_c,x_dps\n0,20,1\n1,21\n";
    fit_beside_earlier(cut, &[]).is_error(&["log.csv: line 3: 2 cells where the first line has 3"]);
}

#[test]
fn time_running_backwards_is_an_error_that_names_the_row() {
    let mut log = Log::cycle();
    log.time_s[500] = 3.0;
    fit_beside_earlier(&log.csv(), &[]).is_error(&["row 501: column 't_s' runs backwards, from 249.5 to 3"]);
}

#[test]
fn rows_without_a_number_are_left_out_and_counted() {
    let mut log = Log::cycle();
    (0..8400).step_by(50).for_each(|row| log.temperature_c[row] = f64::NAN);
    log.rates[1][77] = f64::NAN;
    let folder = folder_with("log.csv", log.csv());
    let ran = zerorate(folder.path(), &["fit", "log.csv"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    ran.says(&[
        "log.csv: warning",
        "168 of 8400 rows were left out",
        "168  no number for the temperature  every column",
    ]);
    let json = zerorate(folder.path(), &["fit", "log.csv", "--json"]).json();
    let rejected = &json["axes"]["y_rad_s"]["samples_rejected"];
    assert_eq!(rejected[0], serde_json::json!({"reason": "missing-temperature", "count": 168}));
    assert_eq!(rejected[1], serde_json::json!({"reason": "missing-rate", "count": 1}));
}

#[test]
fn a_log_of_nothing_but_nan_is_rejected() {
    let mut log = Log::cycle().rows(0..200);
    log.rates.iter_mut().for_each(|rate| rate.fill(f64::NAN));
    let ran = fit_beside_earlier(&log.csv(), &["--json"]);
    assert_eq!(ran.code, 1);
    ran.says(&["\"no-finite-rows\"", "x_rad_s: no row has both a temperature and a rate"]);
}

#[test]
fn a_constant_temperature_is_rejected_even_where_a_narrow_span_is_allowed() {
    let mut log = Log::cycle();
    log.temperature_c.fill(25.0);
    for options in [&[][..], &["--allow-narrow"], &["--plain"]] {
        let ran = fit_beside_earlier(&log.csv(), options);
        assert_eq!(ran.code, 1);
        ran.says(&["log.csv: rejected", "the temperature stays at 25.00 C"]);
    }
}

#[test]
fn a_narrow_span_is_rejected_and_where_it_is_allowed_its_range_is_written_and_enforced() {
    let whole = Log::cycle();
    let narrow = whole.rows(2200..2400);
    let ran = fit_beside_earlier(&narrow.csv(), &["--json"]);
    let json = ran.json();
    assert_eq!((ran.code, json["verdict"].as_str(), json["axes"].as_object().unwrap().len()), (1, Some("rejected"), 0));
    assert_eq!(json["reasons"][0]["kind"], "narrow-span");
    let text = json["reasons"][0]["text"].as_str().unwrap();
    assert!(text.contains("(--allow-narrow)"), "an option that there is: {text}");

    let folder = folder_with("narrow.csv", narrow.csv());
    fs::write(folder.path().join("whole.csv"), whole.csv()).unwrap();
    let fit = zerorate(folder.path(), &["fit", "narrow.csv", "--allow-narrow", "--model", "poly:1", "--out", "c.json"]);
    assert_eq!(fit.code, 0, "{}", fit.err);
    fit.says(&["the calibration holds for this range alone"]);
    let apply = zerorate(folder.path(), &["apply", "c.json", "whole.csv", "--out", "out.csv", "--json"]).json();
    let range = [0, 1].map(|end| apply["calibrated_temperature"][end].as_f64().unwrap());
    assert!(range[1] - range[0] < 10.0);
    let outside = whole.temperature_c.iter().filter(|t| **t < range[0] || **t > range[1]).count();
    assert_eq!(apply["rows_outside_calibrated_range"].as_u64(), Some(outside as u64));
    let predicted = column(&folder.path().join("out.csv"), "predicted_x_rad_s");
    let held: Vec<f64> = whole
        .temperature_c
        .iter()
        .zip(&predicted)
        .filter(|(t, _)| **t > range[1])
        .map(|(_, predicted)| *predicted)
        .collect();
    assert!(held.len() > 1000 && held.iter().all(|p| (p - held[0]).abs() < 1e-15), "held at the range's end");
}

#[test]
fn too_few_groups_for_the_model_are_rejected() {
    let log = Log::cycle();
    let mut few = log.rows(0..5);
    few.temperature_c = vec![0.0, 10.0, 20.0, 30.0, 40.0];
    let ran = fit_beside_earlier(&few.csv(), &["--model", "poly:5"]);
    assert_eq!(ran.code, 1);
    ran.says(&["cannot settle 6 coefficients", "record for longer, or choose a smaller model"]);
}

#[test]
fn the_log_itself_is_never_written_to() {
    let folder = folder_with("log.csv", Log::cycle().csv());
    for option in ["--out", "--report"] {
        zerorate(folder.path(), &["fit", "log.csv", option, "./log.csv"]).is_error(&[option, "would be lost"]);
    }
    assert_eq!(fs::read_to_string(folder.path().join("log.csv")).unwrap(), Log::cycle().csv());
}

#[test]
fn a_model_and_a_unit_that_are_none_are_refused_with_those_there_are() {
    let folder = folder_with("log.csv", "t,temp,gx\n");
    for (option, wrong, right) in [
        ("--model", "poly:9", "poly:1 to poly:5"),
        ("--time-unit", "d", "h, min, s, ms, us or ns"),
        ("--rate-unit", "rpm", "dps, mdps, deg/h, rad/s, mrad/s or counts"),
        ("--temperature-unit", "R", "celsius, fahrenheit, kelvin or counts"),
    ] {
        let ran = zerorate(folder.path(), &["fit", "log.csv", option, wrong]);
        assert_eq!(ran.code, 2);
        ran.says(&[option, wrong, right]);
    }
}

/// Golden values of numpy 2.4 (`numpy.polyfit` of columns 1 to 3 over column 8), as in cal's tests of the recording.
#[test]
fn a_plain_cubic_of_the_real_recording_is_that_of_numpy() {
    let Some(file) = real_file() else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = file.to_str().unwrap();
    let ran = zerorate(folder.path(), &["fit", file, "--model", "poly:3", "--plain", "--json"]);
    let json = ran.json();
    let axis = &json["axes"]["imu.gyro.x"];
    let value = |t: f64| {
        (0_u8..4).map(|k| axis["raw_coefficients"][usize::from(k)].as_f64().unwrap() * t.powi(k.into())).sum::<f64>()
    };
    let golden = [(-15.0, -0.061970952436253286), (0.0, -0.06908658751315859), (70.0, -0.05665549017210137)];
    for (t, expected) in golden {
        assert!((value(t) - expected).abs() < 1e-9 * 0.02, "{} at {t}", value(t));
    }
    assert_eq!((axis["rate_unit"].as_str(), axis["samples_used"].as_u64()), (Some("rad/s"), Some(8400)));
}

/// The numbers of one column of a CSV file.
pub fn column(path: &Path, name: &str) -> Vec<f64> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let place = header.iter().position(|head| *head == name).unwrap_or_else(|| panic!("no {name} in {header:?}"));
    lines.map(|cells| cells[place].parse().unwrap_or(f64::NAN)).collect()
}

#[test]
fn with_json_an_error_is_json_too() {
    let folder = tempfile::tempdir().unwrap();
    let ran = zerorate(folder.path(), &["fit", "none.csv", "--json"]);
    assert_eq!(ran.code, 2);
    let json = ran.json();
    let error = json["error"].as_str().unwrap();
    assert!(error.contains("none.csv") && ran.err.contains("error: "), "{error} {}", ran.err);
}

#[test]
fn rates_are_told_in_the_unit_asked_for_on_the_screen_and_in_the_report_and_json_keeps_its_own() {
    let folder = folder_with("log.csv", Log::cycle().csv());
    let ran = zerorate(folder.path(), &["fit", "log.csv", "--units", "deg/h", "--label", "operator=A. N."]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    ran.says(&["in deg/h", "Within the recording, in deg/h"]);
    assert!(!ran.out.contains("rad/s,") && !ran.out.contains("mrad/s"), "{}", ran.out);
    let page = fs::read_to_string(folder.path().join("log.report.html")).unwrap();
    assert!(page.contains("rate, deg/h") && page.contains("A. N.") && !page.contains("rate, mrad/s"));
    let calibration = fs::read_to_string(folder.path().join("log.calibration.json")).unwrap();
    assert!(calibration.contains("\"operator\": \"A. N.\"") && calibration.contains("rad/s"));
    let json = |options: &[&str]| zerorate(folder.path(), &[&["fit", "log.csv", "--json"], options].concat()).out;
    assert_eq!(json(&["--units", "deg/h"]), json(&[]));
    let verified = ["verify", "log.csv", "--with", "log.calibration.json", "--in-sample", "--units", "mdps"];
    zerorate(folder.path(), &verified).says(&["in mdps"]);
    zerorate(folder.path(), &["fit", "log.csv", "--units", "counts"]).is_error(&[
        "--units counts",
        "rad/s",
        "leave --units out",
    ]);
    let unnamed = zerorate(folder.path(), &["fit", "log.csv", "--label", "operator"]);
    assert!(unnamed.code == 2 && unnamed.err.contains("give NAME=WORDS"), "{}", unnamed.err);
}
