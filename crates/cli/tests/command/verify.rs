use std::fs;

use tempfile::TempDir;

use crate::log::{Log, real_file};
use crate::{folder_with, zerorate};

/// A calibration, its own log, and a second run with another noise.
fn calibrated() -> TempDir {
    let folder = folder_with("log.csv", Log::cycle().csv());
    let ran = zerorate(folder.path(), &["fit", "log.csv", "--out", "calibration.json"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let mut second = Log::cycle_of_run(2);
    second.rates.iter_mut().for_each(|rate| rate.iter_mut().for_each(|value| *value += 0.004));
    fs::write(folder.path().join("second.csv"), second.csv()).unwrap();
    folder
}

/// What is offered is run: it has the numbers' unit, the model and the serial that the calibration was made with.
#[test]
fn the_two_runs_are_joined_as_the_first_was_fitted() {
    let bare = |log: Log| log.csv().replacen("x_rad_s", "x", 1).replacen("y_rad_s", "y", 1);
    let [mut first, mut second] = [Log::cycle(), Log::cycle_of_run(2)];
    for log in [&mut first, &mut second] {
        log.rates.iter_mut().flatten().for_each(|rate| *rate *= 10.0);
    }
    let folder = folder_with("first.csv", bare(first));
    fs::create_dir(folder.path().join("next")).unwrap();
    fs::write(folder.path().join("next/second.csv"), bare(second)).unwrap();
    let asked = ["--rate-unit", "dps", "--model", "poly:2", "--serial", "G 7", "--label", "operator=A. N."];
    let ran = zerorate(folder.path(), &[&["fit", "first.csv", "--out", "own.json"][..], &asked].concat());
    assert_eq!(ran.code, 0, "{}", ran.err);
    let verify = ["verify", "next/second.csv", "--with", "own.json"];
    let out = zerorate(folder.path(), &verify).out;
    let offer = "zerorate fit first.csv next/second.csv --rate-unit dps --model poly:2 --serial 'G 7' --label 'operator=A. N.' --out \
                 both.calibration.json --report both.report.html";
    assert!(out.split_whitespace().collect::<Vec<_>>().join(" ").contains(offer), "{out}");
    let joined = ["fit", "first.csv", "next/second.csv", "--out", "both.json", "--report", "both.html"];
    let ran = zerorate(folder.path(), &[&joined[..], &asked].concat());
    assert_eq!(ran.code, 0, "{}", ran.err);
    ran.says(&["in dps"]);
    // Another file in the first one's place is not that log, and columns in another order are not joined.
    let turned = fs::read_to_string(folder.path().join("next/second.csv")).unwrap();
    let turned: String = turned
        .lines()
        .map(|row| {
            let cells: Vec<&str> = row.split(',').collect();
            format!("{},{},{},{}\n", cells[0], cells[1], cells[3], cells[2])
        })
        .collect();
    fs::write(folder.path().join("turned.csv"), turned).unwrap();
    let out = zerorate(folder.path(), &["verify", "turned.csv", "--with", "own.json"]).out;
    assert!(out.contains("turned.csv: measured") && !out.contains("zerorate fit"), "{out}");
    fs::write(folder.path().join("first.csv"), "t_s,temperature_c,x,y\n0,1,2,3\n").unwrap();
    let out = zerorate(folder.path(), &verify).out;
    assert!(out.contains("second.csv: measured") && !out.contains("zerorate fit"), "{out}");
}

#[test]
fn a_second_run_passes_or_fails_by_its_limits() {
    let folder = calibrated();
    let verify = ["verify", "second.csv", "--with", "calibration.json"];
    let ran = zerorate(folder.path(), &verify);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    ran.says(&["second.csv: measured: no limits were given", "x_rad_s", "mrad/s"]);
    ran.says(&["zerorate fit log.csv second.csv --out both.calibration.json --report both.report.html"]);
    let passed = zerorate(folder.path(), &[&verify[..], &["--max-rms", "0.5mrad/s", "--max-pp", "2 mrad/s"]].concat());
    assert_eq!(passed.code, 0, "{}", passed.out);
    passed.says(&["passed: all axes are within"]);
    let failed = zerorate(folder.path(), &[&verify[..], &["--max-offset", "1mrad/s"]].concat());
    assert_eq!(failed.code, 1);
    failed.says(&["failed", "4.00 times the limit of 1 mrad/s", "times the limit of 1 mrad/s"]);
    let json = zerorate(folder.path(), &[&verify[..], &["--max-offset", "1mrad/s", "--json"]].concat()).json();
    assert_eq!((&json["passed"], &json["in_sample"]), (&false.into(), &false.into()));
    assert!((json["axes"][0]["offset"].as_f64().unwrap() - 0.004).abs() < 1e-4);
}

/// A row a second: a spike is told among 21 rows, and so the fit averages over 21 s, where a verification takes 10.
#[test]
fn where_rows_come_seldom_both_say_over_what_they_average() {
    let run = |phase: f64| {
        let row = |second: u32| {
            let t = f64::from(second);
            let temperature = 20.0 + 30.0 * (t * std::f64::consts::TAU / 3600.0).cos();
            let noise = 0.01 * (12.9898 * (t + phase)).sin() * (78.233 * t).cos();
            format!("{t},{temperature:.4},{:.6}\n", 0.002 * temperature + noise)
        };
        (0..7200).fold("time_s,temperature_c,x_dps\n".to_owned(), |text, second| text + &row(second))
    };
    let folder = folder_with("log.csv", run(0.0));
    fs::write(folder.path().join("second.csv"), run(5000.0)).unwrap();
    let fit = ["fit", "log.csv", "--out", "calibration.json"];
    let ran = zerorate(folder.path(), &fit);
    ran.says(&[
        "in averages over about 21 s",
        "the same two of another run, in averages over 10 s, which have another noise",
    ]);
    let json = zerorate(folder.path(), &[&fit[..], &["--force", "--json"]].concat()).json();
    assert_eq!(json["averaged_over_s"], 21.0);
    let verify = ["verify", "second.csv", "--with", "calibration.json"];
    zerorate(folder.path(), &verify).says(&["Averages over 10.0 s", "fit told both of averages over 21.0 s"]);
    let json = zerorate(folder.path(), &[&verify[..], &["--json"]].concat()).json();
    assert_eq!((&json["averaged_over_s"], &json["fit_averaged_over_s"]), (&10.0.into(), &21.0.into()));
}

#[test]
fn the_log_that_was_fitted_is_refused_as_no_test() {
    let folder = calibrated();
    let verify = ["verify", "log.csv", "--with", "calibration.json"];
    zerorate(folder.path(), &verify).is_error(&["fitted on this very log", "--in-sample"]);
    let looked = zerorate(folder.path(), &[&verify[..], &["--in-sample"]].concat());
    assert_eq!(looked.code, 0);
    looked.says(&["in-sample, and no test"]);
    assert!(!looked.out.contains("zerorate fit"), "one log is not two: {}", looked.out);
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
    fs::write(&limits, "max_rms = \"0.5 mrad/s\"\n\nmax_ppp = \"3 mrad/s\"\n").unwrap();
    zerorate(folder.path(), &verify).is_error(&["limits.toml:3", "'max_ppp'"]);
    fs::write(&limits, "[axes.roll]\nmax_pp = \"3 dps\"\n").unwrap();
    zerorate(folder.path(), &verify).is_error(&["'roll'"]);
}

#[test]
fn a_table_is_verified_by_the_calibration_of_an_autopilots_log_and_the_other_way_round() {
    let folder = folder_with("flight.ulg", Log::cycle().ulg());
    assert_eq!(zerorate(folder.path(), &["fit", "flight.ulg", "--out", "flight.json"]).code, 0);
    let mut log = Log::cycle_of_run(2);
    log.rates.push(log.rates[0].iter().map(|rate| 0.5 * rate).collect());
    log.rates.iter_mut().flatten().for_each(|rate| *rate += 0.002);
    fs::write(folder.path().join("table.csv"), log.csv()).unwrap();
    fs::write(folder.path().join("other.ulg"), log.ulg()).unwrap();
    assert_eq!(zerorate(folder.path(), &["fit", "table.csv", "--out", "table.json"]).code, 0);
    for (calibration, other, taken) in [
        ("flight.json", "table.csv", "'x_rad_s' of the log is taken for gyro0.x"),
        ("table.json", "flight.ulg", "'gyro0.x'"),
    ] {
        let ran = zerorate(folder.path(), &["verify", other, "--with", calibration, "--max-rms", "0.5mrad/s"]);
        assert_eq!(ran.code, 0, "{}{}", ran.out, ran.err);
        ran.says(&["passed: all axes", taken]);
    }
    // By name it is what it is by role.
    let json = |log: &str| zerorate(folder.path(), &["verify", log, "--with", "flight.json", "--json"]).json();
    let (by_role, by_name) = (json("table.csv"), json("other.ulg"));
    for axis in 0..3 {
        let rms = |json: &serde_json::Value| json["axes"][axis]["corrected"]["rms"].as_f64().unwrap();
        // Groups of 20 rows and of 21 average the noise of 0.3 mrad/s not quite alike.
        assert!((rms(&by_role) - rms(&by_name)).abs() < 5e-6, "{axis}: {by_role} {by_name}");
    }
}

/// The way back of the shared recording: a curve of the way up alone is worse than none there.
#[test]
fn a_curve_of_one_direction_is_told_and_so_is_what_it_does_on_the_way_back() {
    if real_file().is_none() {
        return;
    }
    let log = Log::real().unwrap();
    let place = |better: fn(f64, f64) -> bool| {
        let t = &log.temperature_c;
        (0..t.len()).reduce(|a, b| if better(t[b], t[a]) { b } else { a }).unwrap()
    };
    let (coldest, hottest) = (place(|a, b| a < b), place(|a, b| a > b));
    let folder = folder_with("heat.csv", log.rows(coldest..hottest).csv());
    fs::write(folder.path().join("cool.csv"), log.rows(hottest..log.time_s.len()).csv()).unwrap();
    let fit = zerorate(folder.path(), &["fit", "heat.csv", "--out", "calibration.json", "--report", "report.html"]);
    assert_eq!(fit.code, 0);
    fit.says(&["heat.csv: warning", "the temperature only rises: the log says nothing of hysteresis"]);
    let page = fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("the temperature only rises: the log says nothing of hysteresis"));
    let ran = zerorate(folder.path(), &["verify", "cool.csv", "--with", "calibration.json"]);
    assert_eq!(ran.code, 0);
    ran.says(&["cool.csv: worse: of x_rad_s", "x_rad_s: worse than uncorrected: "]);
    let json = zerorate(folder.path(), &["verify", "cool.csv", "--with", "calibration.json", "--json"]).json();
    assert_eq!((&json["verdict"], &json["passed"]), (&"warning".into(), &serde_json::Value::Null));
    assert!(json["reasons"].as_array().unwrap().iter().any(|reason| reason["kind"] == "worse-than-uncorrected"));
    assert_eq!(json["axes"][0]["worse"], true);
    let limited =
        zerorate(folder.path(), &["verify", "cool.csv", "--with", "calibration.json", "--max-rms", "1mrad/s"]);
    assert_eq!(limited.code, 1);
    limited.says(&["failed", "worse than uncorrected"]);
    let hourly = zerorate(folder.path(), &["verify", "cool.csv", "--with", "calibration.json", "--units", "deg/h"]);
    let sentence = hourly.out.split("worse than uncorrected: ").nth(1).expect("a reason");
    let told = |left: &str| left.split_whitespace().next().and_then(|number| number.parse::<f64>().ok());
    let (left, of) = sentence.split_once(" deg/h rms is left of ").expect("deg/h");
    // One deg/h is 1/3600 of a degree, pi/180 of a radian.
    let per_hour = 3600.0 * 180.0 / std::f64::consts::PI;
    for (told, rms) in [(told(left), &json["axes"][0]["corrected"]["rms"]), (told(of), &json["axes"][0]["raw"]["rms"])]
    {
        let (told, rms) = (told.unwrap(), per_hour * rms.as_f64().unwrap());
        assert!((told / rms - 1.0).abs() < 6e-4, "{told} for {rms}");
    }
}
