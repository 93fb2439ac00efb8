use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::fit::column;
use crate::log::{Log, parabola};
use crate::{folder_with, zerorate};

/// A log and its calibration.
fn calibrated(log: &Log) -> TempDir {
    let folder = folder_with("log.csv", log.csv());
    let ran = zerorate(folder.path(), &["fit", "log.csv", "--out", "calibration.json"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    folder
}

fn apply(folder: &Path, log: &str) -> crate::Ran {
    zerorate(folder, &["apply", "calibration.json", log, "--out", "out.csv"])
}

#[test]
fn a_fitted_log_is_corrected_row_by_row() {
    let log = Log::cycle();
    let folder = calibrated(&log);
    let ran = apply(folder.path(), "log.csv");
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    ran.says(&["Wrote out.csv: 8400 rows, x_rad_s, y_rad_s corrected."]);
    let out = folder.path().join("out.csv");
    let text = fs::read_to_string(&out).unwrap();
    let head =
        "t_s,temperature_c,x_rad_s,y_rad_s,predicted_x_rad_s,corrected_x_rad_s,predicted_y_rad_s,corrected_y_rad_s";
    assert_eq!(text.lines().next(), Some(head));
    assert_eq!(text.lines().count(), 8401);
    let predicted = column(&out, "predicted_x_rad_s");
    for (temperature, predicted) in log.temperature_c.iter().zip(&predicted) {
        assert!((predicted - parabola(*temperature)).abs() < 1e-4, "{predicted} at {temperature}");
    }
    for (row, corrected) in column(&out, "corrected_y_rad_s").iter().enumerate() {
        let rate = log.rates[1][row];
        assert!(corrected.abs() < 1e-3, "noise is left of {rate}: {corrected}");
    }
}

/// X drifts by half as much again in each of 8400 rows.
#[test]
fn a_drift_in_time_is_said_to_be_another_logs() {
    let mut log = Log::cycle();
    log.rates[0].iter_mut().enumerate().for_each(|(row, rate)| *rate += 1e-6 * row as f64);
    let folder = calibrated(&log);
    let with = |log: &str| {
        zerorate(folder.path(), &["apply", "calibration.json", log, "--out", "out.csv", "--force", "--with-time-drift"])
    };
    assert!(!with("log.csv").out.contains("--with-time-drift"), "its own");
    log.rates[1][0] += 1e-6;
    fs::write(folder.path().join("next.csv"), log.csv()).unwrap();
    with("next.csv").says(&["--with-time-drift: next.csv is, by its bytes, no log that the calibration was fitted on"]);
    assert!(!apply(folder.path(), "next.csv").out.contains("drift in time"), "it was not asked for");
}

#[test]
fn rows_whose_rates_were_blanked_are_predicted_all_the_same() {
    let whole = Log::cycle();
    let mut blanked = whole.clone();
    blanked.rates.iter_mut().for_each(|rate| rate[3000..4050].fill(f64::NAN));
    let folder = calibrated(&blanked);
    assert_eq!(apply(folder.path(), "log.csv").code, 0);
    let predicted = column(&folder.path().join("out.csv"), "predicted_y_rad_s");
    assert_eq!(predicted.len(), 8400);
    for (predicted, temperature) in predicted.iter().zip(&whole.temperature_c) {
        assert!((predicted + 2.0 * parabola(*temperature)).abs() < 2e-4, "{predicted} at {temperature}");
    }
    assert!(column(&folder.path().join("out.csv"), "corrected_y_rad_s")[3500].is_nan());
}

#[test]
fn columns_may_stand_in_another_order_beside_others() {
    let folder = calibrated(&Log::cycle());
    fs::write(folder.path().join("other.tsv"), "note\ty_rad_s\tt_s\tx_rad_s\ttemperature_c\nhello\t0\t0\t0\t20\n")
        .unwrap();
    assert_eq!(apply(folder.path(), "other.tsv").code, 0);
    let text = fs::read_to_string(folder.path().join("out.csv")).unwrap();
    let (head, row) = text.trim_end().split_once('\n').unwrap();
    let added = "predicted_y_rad_s,corrected_y_rad_s,predicted_x_rad_s,corrected_x_rad_s";
    assert_eq!(head, format!("note,y_rad_s,t_s,x_rad_s,temperature_c,{added}"));
    assert!(row.starts_with("hello,0,0,0,20,-0.03"), "{row}");
}

#[test]
fn what_cannot_be_corrected_leaves_the_earlier_output() {
    let folder = calibrated(&Log::cycle());
    let earlier = "predicted_x_rad_s,corrected_x_rad_s\n";
    fs::write(folder.path().join("out.csv"), earlier).unwrap();
    let cases = [
        ("missing.csv", None, vec!["missing.csv: cannot be read"]),
        ("empty.csv", Some(""), vec!["empty.csv: the file is empty"]),
        (
            "other.csv",
            Some("t_s,temperature_c,gyro_roll,gyro_pitch\n0,20,1,2\n"),
            vec!["other.csv: it has gyro_roll, gyro_pitch, and the calibration is for x_rad_s, y_rad_s"],
        ),
        ("heat.csv", Some("t_s,heat,x_rad_s,y_rad_s\n0,20,1,2\n"), vec!["--temperature", "t_s, heat"]),
        (
            "kelvin.csv",
            Some("temperature,x_rad_s,y_rad_s\n293,1,2\n294,1,2\n"),
            vec!["column 'temperature' goes from 293 to 294", "--temperature-unit kelvin"],
        ),
        ("counts.csv", Some("temp_counts,x_rad_s,y_rad_s\n9000,1,2\n"), vec!["'temp_counts' is in counts", "are in C"]),
        (
            "text.csv",
            Some("temperature_c,x_rad_s,y_rad_s\n20,1,2\n21,one,2\n"),
            vec!["text.csv: line 3: column 'x_rad_s' holds 'one'"],
        ),
    ];
    for (name, content, parts) in cases {
        if let Some(content) = content {
            fs::write(folder.path().join(name), content).unwrap();
        }
        apply(folder.path(), name).is_error(&parts);
        assert_eq!(fs::read_to_string(folder.path().join("out.csv")).unwrap(), earlier, "{name}");
    }
}

#[test]
fn a_calibration_that_cannot_be_read_is_named_with_the_place() {
    let folder = calibrated(&Log::cycle());
    let path = folder.path().join("calibration.json");
    let text = fs::read_to_string(&path).unwrap();
    let cases = [
        (
            text.replacen("\"schema\": 3", "\"schema\": 99", 1),
            vec!["schema 99", "knows schemas 1 to 3", "use a newer zerorate"],
        ),
        (text[..text.len() / 2].to_owned(), vec!["calibration.json:", "restore the file"]),
        (
            text.replacen("\"temperature_half_span\": ", "\"temperature_half_span\": -", 1),
            vec!["temperature_half_span must be above zero"],
        ),
        ("t,x\n1,2\n".to_owned(), vec!["calibration.json: this is not a calibration"]),
        ("{}".to_owned(), vec!["this is not a calibration"]),
    ];
    for (damaged, parts) in cases {
        fs::write(&path, damaged).unwrap();
        apply(folder.path(), "log.csv").is_error(&parts);
        assert!(!folder.path().join("out.csv").exists());
    }
    zerorate(folder.path(), &["apply", "nothing.json", "log.csv", "--out", "out.csv"])
        .is_error(&["nothing.json: cannot be read"]);
}

#[test]
fn neither_the_log_nor_the_calibration_is_written_to() {
    let folder = calibrated(&Log::cycle());
    for own in ["log.csv", "calibration.json"] {
        zerorate(folder.path(), &["apply", "calibration.json", "log.csv", "--out", own]).is_error(&["would be lost"]);
    }
}

#[test]
fn rows_without_a_temperature_are_kept_and_counted() {
    let folder = calibrated(&Log::cycle());
    fs::write(folder.path().join("flight.csv"), "temperature_c,x_rad_s,y_rad_s\n,1,2\n20,1,2\n90,1,2\n").unwrap();
    let ran = apply(folder.path(), "flight.csv");
    ran.says(&["1 row is without a temperature", "1 row is outside -28.2 to 84.2 C, over which the curve is believed"]);
    assert!(fs::read_to_string(folder.path().join("out.csv")).unwrap().contains("\n,1,2,,,,\n"));
}

/// The same unit's table and flight: the truth is the parabola that both were made by.
#[test]
fn a_table_is_corrected_by_the_calibration_of_an_autopilots_log_as_verify_matches_them() {
    let log = Log::cycle();
    let folder = folder_with("flight.ulg", log.ulg_of_topics(&[("sensor_gyro", 3), ("sensor_accel", 5)]));
    fs::write(folder.path().join("log.csv"), log.csv()).unwrap();
    assert_eq!(zerorate(folder.path(), &["fit", "flight.ulg", "--out", "calibration.json"]).code, 0);
    let ran = apply(folder.path(), "log.csv");
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    ran.says(&[
        "8400 rows, x_rad_s, y_rad_s corrected.",
        "'x_rad_s' of the log is taken for gyro0.x of the calibration",
        "accel0.x of the calibration: the log has no such axis, and none was corrected by it",
    ]);
    let predicted = column(&folder.path().join("out.csv"), "predicted_y_rad_s");
    for (temperature, predicted) in log.temperature_c.iter().zip(&predicted) {
        assert!((predicted + 2.0 * parabola(*temperature)).abs() < 2e-4, "{predicted} at {temperature}");
    }
    let gyro = ["apply", "calibration.json", "log.csv", "--out", "out.csv", "--sensor", "gyro"];
    let ran = zerorate(folder.path(), &gyro);
    assert!(ran.code == 0 && !ran.out.contains("accel0"), "{} {}", ran.out, ran.err);
    zerorate(folder.path(), &[&gyro[..4], &["none.csv", "--rate", "y_rad_s"]].concat())
        .says(&["8400 rows, y_rad_s corrected."]);
}

/// The flight is written by hand, byte by byte, and its curve is known.
#[test]
fn an_autopilots_log_is_corrected_sensor_by_sensor() {
    let log = Log::cycle();
    let folder = folder_with("flight.ulg", log.ulg());
    assert_eq!(zerorate(folder.path(), &["fit", "flight.ulg", "--out", "calibration.json"]).code, 0);
    let ran = apply(folder.path(), "flight.ulg");
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    ran.says(&["Wrote out.csv: 8400 rows, gyro0.x, gyro0.y, gyro0.z corrected."]);
    let out = folder.path().join("out.csv");
    let text = fs::read_to_string(&out).unwrap();
    let head = "sensor,rate_unit,time_s,temperature_c,x,y,z,predicted_x,corrected_x,predicted_y,corrected_y,predicted_z,corrected_z";
    assert_eq!(text.lines().next(), Some(head));
    assert!(text.lines().nth(1).unwrap().starts_with("gyro0,rad/s,0,"), "{:?}", text.lines().nth(1));
    let [times, rates, predicted, corrected] =
        ["time_s", "y", "predicted_y", "corrected_y"].map(|name| column(&out, name));
    for row in 0..8400 {
        let truth = -2.0 * parabola(log.temperature_c[row]);
        assert!((predicted[row] - truth).abs() < 2e-4, "{row}: {} {truth}", predicted[row]);
        assert!((corrected[row] - (rates[row] - predicted[row])).abs() < 1e-12);
        assert!((times[row] - log.time_s[row]).abs() < 1e-6);
    }
    // By a table's calibration, in degrees a second and under other names, it is the same to the parts in common.
    let mut turned = log.clone();
    turned.rates.iter_mut().flatten().for_each(|rate| *rate *= 57.295_779_513_082_32);
    fs::write(folder.path().join("table.csv"), turned.csv().replace("_rad_s", "_dps")).unwrap();
    assert_eq!(zerorate(folder.path(), &["fit", "table.csv", "--out", "calibration.json", "--force"]).code, 0);
    let ran = apply(folder.path(), "flight.ulg");
    ran.says(&["8400 rows, gyro0.x, gyro0.y corrected.", "'gyro0.y' of the log is taken for y_dps of the calibration"]);
    for (row, (own, other)) in column(&out, "predicted_y").iter().zip(&predicted).enumerate() {
        assert!((own - other).abs() < 2e-5, "{row}: {own} {other}");
    }
    assert!(column(&out, "predicted_z").iter().all(|bias| bias.is_nan()));
}

#[test]
fn a_sensor_that_was_not_asked_for_is_told_as_that_and_not_as_unknown() {
    let log = Log::cycle().ulg_of_topics(&[("sensor_gyro", 3), ("sensor_accel", 5)]);
    let folder = folder_with("flight.ulg", log);
    assert_eq!(zerorate(folder.path(), &["fit", "flight.ulg", "--out", "calibration.json"]).code, 0);
    let apply = |sensor: &[&str], out: &str| {
        let common = ["apply", "calibration.json", "flight.ulg", "--out", out];
        let ran = zerorate(folder.path(), &[&common[..], sensor].concat());
        assert_eq!(ran.code, 0, "{}", ran.err);
        ran.out
    };
    let told = apply(&["--sensor", "gyro"], "gyro.csv");
    assert!(told.contains("accel0: not asked for by --sensor, and not written"), "{told}");
    assert!(!told.contains("not in the calibration"), "{told}");
    assert!(!apply(&[], "all.csv").contains("not written"));
    let gyro = ["fit", "flight.ulg", "--sensor", "gyro", "--out", "calibration.json"];
    assert_eq!(zerorate(folder.path(), &gyro).code, 0);
    assert!(apply(&[], "by-gyro.csv").contains("accel0: not in the calibration, and not written"));
}

#[test]
fn rows_outside_of_what_was_measured_are_told_whether_the_curve_is_believed_there_or_not() {
    let folder = calibrated(&Log::cycle());
    // Measured from -17 to 73 C and believed an eighth of that, 11 C, further. By hand: 3, of them 1, and 2 within.
    fs::write(
        folder.path().join("hot.csv"),
        "t_s,temperature_c,x_rad_s,y_rad_s\n0,20,0,0\n1,72,0,0\n2,76,0,0\n3,80,0,0\n4,95,0,0\n",
    )
    .unwrap();
    let ran = apply(folder.path(), "hot.csv");
    ran.says(&[
        "2 rows are outside -17.0 to 73.0 C, the coldest and the warmest average that was fitted, and within -28.",
    ]);
    ran.says(&["1 row is outside -28.", "over which the curve is believed: there it was held at its end"]);
}

#[test]
fn an_autopilots_log_without_an_axis_of_the_calibration_is_refused_by_name() {
    let folder = folder_with("flight.ulg", Log::cycle().ulg());
    fs::write(folder.path().join("log.csv"), Log::cycle().csv().replace("x_rad_s,y_rad_s", "roll_rad_s,pitch_rad_s"))
        .unwrap();
    let columns = ["--rate", "roll_rad_s,pitch_rad_s"];
    let fit = ["fit", "log.csv", "--out", "calibration.json"];
    assert_eq!(zerorate(folder.path(), &[&fit[..], &columns].concat()).code, 0);
    apply(folder.path(), "flight.ulg").is_error(&[
        "flight.ulg: it has gyro0.x, gyro0.y, gyro0.z, and the calibration is for pitch_rad_s, roll_rad_s",
    ]);
    assert!(!folder.path().join("out.csv").exists());
    zerorate(folder.path(), &["apply", "calibration.json", "flight.ulg", "--out", "out.csv", "--time", "t"])
        .is_error(&["leave out --temperature, --time"]);
}

/// With two gyros in a table of another unit, the one that is asked for is of the log too.
#[test]
fn one_of_two_gyros_of_a_table_is_corrected_alone() {
    let log = Log::cycle();
    let table = |unit: &str, factor: f64| {
        let mut text = format!("t_s,temp_c,gyro0_x_{unit},gyro0_y_{unit},gyro1_x_{unit},gyro1_y_{unit}\n");
        for row in 0..log.time_s.len() {
            let [x, y] = [0, 1].map(|axis| factor * log.rates[axis][row]);
            text += &format!("{},{},{x},{y},{y},{x}\n", log.time_s[row], log.temperature_c[row]);
        }
        text
    };
    let folder = folder_with("log.csv", table("rad_s", 1.0));
    assert_eq!(zerorate(folder.path(), &["fit", "log.csv", "--out", "calibration.json"]).code, 0);
    fs::write(folder.path().join("other.csv"), table("mrad_s", 1e3)).unwrap();
    let ran =
        zerorate(folder.path(), &["apply", "calibration.json", "other.csv", "--sensor", "gyro1", "--out", "out.csv"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    ran.says(&["gyro1_x_mrad_s, gyro1_y_mrad_s corrected"]);
    let predicted = column(&folder.path().join("out.csv"), "predicted_gyro1_x_mrad_s");
    for (predicted, temperature) in predicted.iter().zip(&log.temperature_c) {
        assert!((predicted + 2e3 * parabola(*temperature)).abs() < 0.2, "{predicted} at {temperature}");
    }
}

/// What `apply` writes it can read, decimal commas or not: all numbers have points.
#[test]
fn a_log_with_decimal_commas_is_written_with_points() {
    let log = Log::cycle();
    let commas = log.csv().replace(',', ";").replace('.', ",");
    let folder = folder_with("commas.csv", commas);
    assert_eq!(zerorate(folder.path(), &["fit", "commas.csv", "--out", "calibration.json"]).code, 0);
    assert_eq!(apply(folder.path(), "commas.csv").code, 0);
    let rates = column(&folder.path().join("out.csv"), "x_rad_s");
    assert!(rates.iter().zip(&log.rates[0]).all(|(read, rate)| (read - rate).abs() < 1e-15));
    let ran = zerorate(folder.path(), &["verify", "out.csv", "--with", "calibration.json", "--in-sample"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
}
