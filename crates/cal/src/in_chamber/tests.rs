use std::fmt::Write;

use super::*;
use crate::log_fit::{FitOptions, fit_logs};
use crate::recording::ChamberInfo;
use crate::source::Source;

/// Three soaks of forty minutes and two ways of an hour: the chamber at 10, 30 and 10 C, the sensor 3 C above it.
fn chamber_c(time_s: f64) -> f64 {
    match time_s / 60.0 {
        minutes if minutes < 40.0 => 10.0,
        minutes if minutes < 100.0 => 10.0 + (minutes - 40.0) / 3.0,
        minutes if minutes < 140.0 => 30.0,
        minutes if minutes < 200.0 => 30.0 - (minutes - 140.0) / 3.0,
        _ => 10.0,
    }
}

const WHOLE_S: u32 = 240 * 60;

fn log(times: impl Fn(u32) -> String, head: &str) -> Source {
    let mut text = format!("{head},temperature_c,x_dps\n");
    for row in 0..WHOLE_S {
        let time_s = f64::from(row);
        let temperature = chamber_c(time_s) + 3.0;
        let noise = f64::from(row.wrapping_mul(2_654_435_761) >> 16) / 65536.0 - 0.5;
        writeln!(text, "{},{temperature:.4},{:.6}", times(row), 0.1 + 0.01 * temperature + 0.002 * noise).unwrap();
    }
    Source::bytes("log.csv", text.into_bytes())
}

/// Of a chamber whose clock began two minutes after the log's.
fn recording() -> ChamberRecording {
    let moment = |second: u32| {
        let time_s = f64::from(second) + 120.0;
        let (step, phase) = match time_s / 60.0 {
            minutes if minutes < 40.0 => (1, Phase::Soak),
            minutes if minutes < 100.0 => (2, Phase::Heating),
            minutes if minutes < 140.0 => (3, Phase::Soak),
            minutes if minutes < 200.0 => (4, Phase::Cooling),
            _ => (5, Phase::Soak),
        };
        let air_c = chamber_c(time_s);
        ChamberMoment { t_s: f64::from(second), step, phase, set_c: air_c.round(), air_c }
    };
    let started = "2026-11-02T18:02:00Z".parse().unwrap();
    let info = ChamberInfo { started, profile: String::new(), labels: Default::default() };
    ChamberRecording { info, moments: (0..WHOLE_S - 120).map(moment).collect(), cut: false }
}

fn fitted(log: Source) -> LogFit {
    fit_logs(&[log], &FitOptions::default()).unwrap()
}

fn with_the_time_of_day() -> LogFit {
    let time = |second: u32| {
        let (hours, minutes, seconds) = (18 + second / 3600, second / 60 % 60, second % 60);
        format!("2026-11-02T{hours:02}:{minutes:02}:{seconds:02}Z")
    };
    fitted(log(time, "time"))
}

#[test]
fn a_recording_is_joined_by_the_time_of_day_and_tells_each_soaks_end() {
    let chamber = InChamber::join(&with_the_time_of_day(), "night.parquet", &recording(), None).unwrap();
    assert!((chamber.begins_s - 120.0).abs() < 1e-6);
    let soaks: Vec<[f64; 2]> = chamber.soaks.iter().map(|soak| [soak.from_s / 60.0, soak.set_c]).collect();
    assert_eq!(soaks, [[2.0, 10.0], [100.0, 30.0], [200.0, 10.0]]);
    for soak in &chamber.soaks {
        let [axis] = &soak.axes[..] else { panic!("{soak:?}") };
        assert!((axis.sensor_c - soak.air_c - 3.0).abs() < 0.01, "{soak:?}");
        assert!(axis.residual.abs() < 1e-3 && axis.groups > 20, "{soak:?}");
    }
    assert_eq!(chamber.air[0], (120.0, 10.0));
}

#[test]
fn a_log_without_the_time_of_day_is_joined_where_it_is_told_to_be() {
    let fit = fitted(log(|second| second.to_string(), "time_s"));
    let told = InChamber::join(&fit, "night.parquet", &recording(), None).unwrap_err().to_string();
    assert!(told.contains("log.csv does not say") && told.contains("chamber_at"), "{told}");
    let chamber = InChamber::join(&fit, "night.parquet", &recording(), Some(120.0)).unwrap();
    assert_eq!(chamber.soaks.len(), 3);
    // Half an hour of the log before the recording begins: the soaks are later by as much.
    let later = InChamber::join(&fit, "night.parquet", &recording(), Some(1920.0)).unwrap();
    assert!((later.soaks[0].from_s - 1920.0).abs() < 1e-6);
}

#[test]
fn a_recording_of_another_day_is_refused_with_both_times() {
    let mut other = recording();
    other.info.started = "2026-11-03T18:00:00Z".parse().unwrap();
    let told = InChamber::join(&with_the_time_of_day(), "night.parquet", &other, None).unwrap_err().to_string();
    assert!(told.contains("not of the log's time") && told.contains("from 86400 to"), "{told}");
}

/// The fixture's sensor is 3 K above its air at every second: its clock is early by what the recording's is late.
#[test]
fn a_sensor_that_answers_before_its_air_is_told_and_one_that_answers_with_it_is_not() {
    let fit = with_the_time_of_day();
    let straight = InChamber::join(&fit, "night.parquet", &recording(), None).unwrap();
    assert!(straight.told.len() == 1 && straight.told[0].contains("the clocks agree"), "{:?}", straight.told);
    let mut late = recording();
    late.info.started = "2026-11-02T18:02:25Z".parse().unwrap();
    let early = InChamber::join(&fit, "night.parquet", &late, None).unwrap();
    // Ways of a third of a kelvin a minute tell it to a dozen seconds.
    let [from, to] = early.answers_after_s.unwrap();
    assert!(from > -40.0 && to < -10.0 && (f64::midpoint(from, to) + 25.0).abs() < 3.0, "{from} to {to}");
    assert!(early.told[0].contains("no sensor does") && early.told[0].contains("`chamber_at` 12"), "{:?}", early.told);
    let given = InChamber::join(&fit, "night.parquet", &late, Some(120.0)).unwrap();
    assert_eq!(given.answers_after_s, straight.answers_after_s);
}
