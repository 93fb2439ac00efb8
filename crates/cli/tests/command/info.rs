use std::fs;

use crate::log::Log;
use crate::{bench, folder_with, zerorate};

#[test]
fn a_finished_recording_is_told_group_by_phase() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = bench::recording(&folder.path().join("run.parquet"));
    (0..60).for_each(|number| writer.write_group(&bench::group(number)).unwrap());
    writer.finish().unwrap();
    let ran = zerorate(folder.path(), &["info", "run.parquet"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    ran.says(&["run.parquet: a recording, finished", "ZR-0042", "simulated, seed 7", "60 of 500 samples, 88.5 s"]);
    ran.says(&["x     heating  off       40  8520 to 8559  8200 to 8200   511"]);
    let json = zerorate(folder.path(), &["info", "run.parquet", "--json"]).json();
    let found = &json["files"][0];
    assert_eq!(
        (&found["kind"], &found["cut"], &found["whole_groups"]),
        (&"recording".into(), &false.into(), &60.into())
    );
}

#[test]
fn a_cut_recording_is_told_with_its_whole_groups() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = bench::recording(&folder.path().join("run.parquet"));
    (0..30).for_each(|number| writer.write_group(&bench::group(number)).unwrap());
    drop(writer);
    let path = folder.path().join("run.arrows");
    let whole = fs::read(&path).unwrap();
    // A stream that was dropped has no end mark, and the last group loses its tail here.
    fs::write(&path, &whole[..whole.len() - 100]).unwrap();
    let ran = zerorate(folder.path(), &["info", "run.arrows"]);
    assert_eq!(ran.code, 0);
    ran.says(&["run.arrows: a recording, CUT", "its 29 whole groups are readable"]);
    fs::write(&path, &whole[..6]).unwrap();
    zerorate(folder.path(), &["info", "run.arrows"]).is_error(&["cut off before its header", "record again"]);
}

#[test]
fn calibrations_of_a_log_and_of_a_board_are_told() {
    let folder = folder_with("log.csv", Log::cycle().csv());
    zerorate(folder.path(), &["fit", "log.csv", "--serial", "U7", "--out", "log.json"]);
    fs::write(folder.path().join("board.json"), bench::calibration()).unwrap();
    let ran = zerorate(folder.path(), &["info", "log.json", "board.json"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    ran.says(&["log.json: the calibration of a log", "U7", "log.csv (log, SHA-256", "-17.0 to 73.0", "rms, mrad/s"]);
    ran.says(&[
        "board.json: the calibration of an analogue board",
        "a tap moves it by 31.2 counts",
        "starts in mode hybrid",
    ]);
}

#[test]
fn gyros_and_accelerometers_are_told_in_units_of_their_own() {
    let folder = folder_with("flight.ulg", Log::cycle().ulg_of_topics(&[("sensor_gyro", 3), ("sensor_accel", 5)]));
    assert_eq!(zerorate(folder.path(), &["fit", "flight.ulg", "--out", "flight.json"]).code, 0);
    let ran = zerorate(folder.path(), &["info", "flight.json"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let (of_accelerometers, of_gyros) = ran.out.split_once("mrad/s").unwrap();
    assert!(of_accelerometers.contains("mm/s^2") && of_accelerometers.contains("accel0.x"), "{}", ran.out);
    assert!(!of_accelerometers.contains("gyro0.x"), "{}", ran.out);
    assert!(of_gyros.contains("gyro0.x") && !of_gyros.contains("accel0"), "{}", ran.out);
}

#[test]
fn a_device_record_is_told_and_a_damaged_one_refused() {
    let record = bench::device_record();
    let folder = folder_with("device-record.bin", &record);
    let ran = zerorate(folder.path(), &["info", "device-record.bin"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    ran.says(&["a device record, whole", "ZR-0042", "8500 to 11900", "hybrid"]);
    let json = zerorate(folder.path(), &["info", "device-record.bin", "--json"]).json();
    let found = &json["files"][0];
    assert_eq!((&found["version"], &found["axes"][0]["refused"]), (&5.into(), &serde_json::Value::Null));
    // The drift of 400 counts crosses a tap every 31.
    assert!((10..16).contains(&found["axes"][0]["edges"].as_u64().unwrap()), "{found}");

    let path = folder.path().join("device-record.bin");
    let damaged = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = record.clone();
        change(&mut bytes);
        fs::write(&path, bytes).unwrap();
        zerorate(folder.path(), &["info", "device-record.bin"])
    };
    damaged(&|bytes| bytes[40] ^= 1).is_error(&["device-record.bin: the device record is damaged", "CRC-32"]);
    damaged(&|bytes| bytes.truncate(100)).is_error(&["device-record.bin: the device record is damaged"]);
    damaged(&|bytes| bytes[4] = 9).is_error(&["version 9", "this program knows version 5", "make the record anew"]);
    damaged(&|bytes| bytes[0] = b'X').is_error(&["this is not a device record"]);
    damaged(&Vec::clear).is_error(&["this is not a device record"]);
}

#[test]
fn a_log_is_told_with_what_its_columns_are_taken_for() {
    let folder = folder_with("log.csv", Log::cycle().csv());
    fs::write(folder.path().join("odd.csv"), "a,b\n1,2\n3,4\n").unwrap();
    let ran = zerorate(folder.path(), &["info", "log.csv", "odd.csv"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    ran.says(&["log.csv: a log, 8400 rows of 4 columns", "t_s, 70.0 min", "x_rad_s", "mrad/s"]);
    ran.says(&["odd.csv: a log, 2 rows of 2 columns", "say which (--temperature); the columns are a, b"]);
}

#[test]
fn of_several_files_each_is_told_though_one_cannot_be_read() {
    let folder = folder_with("log.csv", Log::cycle().csv());
    let ran = zerorate(folder.path(), &["info", "nothing.bin", "log.csv", "."]);
    assert_eq!(ran.code, 2);
    ran.says(&["log.csv: a log", "error: nothing.bin: cannot be read", "error: .: this is a folder"]);
    let json = zerorate(folder.path(), &["info", "nothing.bin", "log.csv", "--json"]).json();
    assert_eq!((&json["files"][0]["kind"], &json["files"][1]["kind"]), (&"unreadable".into(), &"log".into()));
    let log = &json["files"][1];
    assert_eq!(
        (&log["rows"], &log["time"]["seconds"], &log["rate_unit"]),
        (&8400.into(), &4199.5.into(), &"rad/s".into())
    );
}

#[test]
fn what_stands_beside_results_is_named() {
    let folder = folder_with("summary.json", "{\"schema\": 1, \"tests\": []}");
    fs::write(folder.path().join("report.html"), "<!DOCTYPE html><html>").unwrap();
    fs::write(folder.path().join("bench.toml"), "[board]").unwrap();
    let ran = zerorate(folder.path(), &["info", "summary.json", "report.html", "bench.toml"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    ran.says(&["summary.json: the summary", "report.html: a report", "zerorate setup --check"]);
}

#[test]
fn a_calibration_of_an_unknown_schema_is_refused() {
    let folder = folder_with("calibration.json", "{\"schema\": 99}");
    zerorate(folder.path(), &["info", "calibration.json"]).is_error(&["schema 99", "knows schemas 1 to 3"]);
}
