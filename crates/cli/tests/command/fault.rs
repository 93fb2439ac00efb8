//! The faults of the shared encoder (`encode_flight_logs.py --faults`), on the synthetic log and on the real one where
//! it is: each is rejected or reported, and a curve is moved by none.

use std::fs;

use crate::log::Log;
use crate::{folder_with, zerorate};

type Fault = fn(&mut Log);

/// Each with its exit code and the reason that must be among those given.
const FAULTS: [(&str, Fault, i32, &str); 6] = [
    ("narrow span", narrow_span, 1, "narrow-span"),
    ("stuck temperature", stuck_temperature, 1, "stuck-temperature"),
    ("spikes", spikes, 0, "spikes"),
    ("rotation", rotation, 0, "rotation"),
    ("NaN temperature", nan_temperature, 0, "missing-values"),
    ("step", step, 0, "step"),
];

fn narrow_span(log: &mut Log) {
    let by_temperature = |a: &usize, b: &usize| log.temperature_c[*a].total_cmp(&log.temperature_c[*b]);
    let low = (100..log.time_s.len() - 20).min_by(by_temperature).unwrap();
    *log = log.rows(low - 100..low + 20);
}

fn stuck_temperature(log: &mut Log) {
    *log = log.rows(0..2000);
    log.temperature_c.fill(25.0);
}

/// 80 rows, here at every 105th, about 1 rad/s off to either side.
fn spikes(log: &mut Log) {
    for (count, row) in (60..log.time_s.len()).step_by(105).enumerate() {
        let size = if count % 2 == 0 { 0.9 } else { -1.1 };
        log.rates.iter_mut().for_each(|rate| rate[row] += size);
    }
}

fn rotation(log: &mut Log) {
    (5000..5060).for_each(|row| log.rates[0][row] += 2.0);
}

fn nan_temperature(log: &mut Log) {
    (0..log.time_s.len()).step_by(50).for_each(|row| log.temperature_c[row] = f64::NAN);
}

fn step(log: &mut Log) {
    (4000..log.time_s.len()).for_each(|row| log.rates[0][row] += 0.02);
}

fn every_fault_is_answered(clean: &Log) {
    for (name, fault, code, reason) in FAULTS {
        let mut log = clean.clone();
        fault(&mut log);
        let folder = folder_with("log.csv", log.csv());
        fs::write(folder.path().join("calibration.json"), "earlier").unwrap();
        let ran = zerorate(folder.path(), &["fit", "log.csv", "--out", "calibration.json", "--json", "--force"]);
        let json = ran.json();
        assert_eq!(ran.code, code, "{name}: {json}");
        assert_eq!(json["verdict"], if code == 1 { "rejected" } else { "warning" }, "{name}: {json}");
        let kinds: Vec<&str> =
            json["reasons"].as_array().unwrap().iter().map(|r| r["kind"].as_str().unwrap()).collect();
        assert!(kinds.contains(&reason), "{name}: {kinds:?}");
        let kept = fs::read_to_string(folder.path().join("calibration.json")).unwrap() == "earlier";
        assert_eq!(kept, code == 1, "{name}: a rejected log writes nothing, another a calibration");

        let page = zerorate(folder.path(), &["fit", "log.csv"]);
        let text = json["reasons"].as_array().unwrap().iter().find(|r| r["kind"] == reason).unwrap()["text"].as_str();
        page.says(&[&text.unwrap().replace("`allow_narrow`", "--allow-narrow")]);
        assert_eq!(page.code, code);
    }
}

#[test]
fn every_fault_of_the_synthetic_log_is_answered() {
    every_fault_is_answered(&Log::cycle());
}

#[test]
fn every_fault_of_the_real_recording_is_answered() {
    if let Some(real) = Log::real() {
        every_fault_is_answered(&real);
    }
}
