//! The chamber's recording beside a log: `fit --chamber`.

use std::fs;
use std::path::Path;

use zerorate_cal::recording::{ChamberInfo, ChamberMoment, ChamberWriter, Phase};

use crate::log::Log;
use crate::{folder_with, schema, zerorate};

/// Begun at a second of the log: ten minutes at 20 C, of which the last quarter is from 450 s on.
fn record(folder: &Path) {
    let info = ChamberInfo {
        started: "2026-11-02T18:00:00Z".parse().unwrap(),
        profile: "steps = [{ soak_c = 20, minutes = 10 }]".into(),
        labels: [].into(),
    };
    let mut writer = ChamberWriter::create(&folder.join("night.parquet"), &info).unwrap();
    for second in 0..=600_u32 {
        let t_s = f64::from(second);
        writer.write(&ChamberMoment { t_s, step: 1, phase: Phase::Soak, set_c: 20.0, air_c: 20.5 }).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn the_air_stands_beside_a_log_and_each_soaks_end_is_told() {
    let folder = folder_with("log.csv", Log::cycle().csv());
    record(folder.path());
    let fit = ["fit", "log.csv", "--chamber", "night.parquet", "--chamber-at", "100"];
    let ran = zerorate(folder.path(), &fit);
    assert_eq!(ran.code, 0, "{}", ran.err);
    ran.says(&["In the chamber, at the end of each soak", "20.0  20.5", "x_rad_s"]);
    // The air stands still: nothing is told of the clocks but that.
    ran.says(&["Joined as it was said (--chamber-at)", "cannot be told from the data"]);
    let report = fs::read_to_string(folder.path().join("log.report.html")).unwrap();
    assert!(report.contains("In the chamber") && report.contains("night.parquet"));

    let json = zerorate(folder.path(), &[&fit[..], &["--json"]].concat()).json();
    schema::hold("fit.json", &json);
    assert!(json["chamber"]["answers_after_s"].is_null());
    let soak = &json["chamber"]["soaks"][0];
    assert_eq!([&soak["from_s"], &soak["to_s"], &soak["set_c"], &soak["air_c"]], [100.0, 700.0, 20.0, 20.5]);
    // The same rows by hand: the file's own second and third column.
    let log = fs::read_to_string(folder.path().join("log.csv")).unwrap();
    let rows = log.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)));
    let rows: Vec<Vec<f64>> = rows.map(Iterator::collect).collect();
    let end: Vec<f64> = rows.iter().filter(|row| (550.0..=700.0).contains(&row[0])).map(|row| row[1]).collect();
    let mean = end.iter().sum::<f64>() / end.len() as f64;
    let sensor_c = soak["axes"][0]["sensor_c"].as_f64().unwrap();
    // The first and the last average reach over an end, at some degrees a minute.
    assert!((sensor_c - mean).abs() < 0.5, "{sensor_c} and {mean}");
}

#[test]
fn a_log_that_knows_no_time_of_day_asks_where_the_recording_began() {
    let folder = folder_with("log.csv", Log::cycle().csv());
    record(folder.path());
    let ran = zerorate(folder.path(), &["fit", "log.csv", "--chamber", "night.parquet"]);
    assert_eq!(ran.code, 2);
    ran.says(&["does not say at what time of day", "--chamber-at"]);
    let ran = zerorate(folder.path(), &["fit", "log.csv", "--chamber", "log.csv"]);
    assert_eq!(ran.code, 2);
    ran.says(&["log.csv", "not a chamber's recording"]);
    let ran = zerorate(folder.path(), &["fit", "log.csv", "--chamber", "night.parquet", "--chamber-at", "90000"]);
    assert_eq!(ran.code, 2);
    ran.says(&["not of the log's time", "so it was said (--chamber-at)"]);
    let ran = zerorate(folder.path(), &["fit", "log.csv", "--chamber", "night.parquet", "--chamber-at=nan"]);
    ran.says(&["--chamber-at: give a number of seconds"]);
}
