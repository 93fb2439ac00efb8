use std::fmt::Write as _;

use zerorate_core::drift::{Drift, History, Memory, Polynomial, Scale, Shape, Term, ValidRange};
use zerorate_fit::predict::TimeDrift;

use super::*;
use zerorate_cal::log::surveyed;
use zerorate_cal::source::Source;
use zerorate_cal::table::Columns;
use zerorate_cal::units::{RateUnit, WrittenRate};

const TO: AppliedTo<'static> = AppliedTo { time: None, start: Start::Unknown };

/// 1 + T / 10 over 0..20.
fn model(column: &str) -> AppliedModel {
    let scale = Scale::spanning(0.0, 20.0).unwrap();
    let shape = Shape::Polynomial(Polynomial::new(scale, &[2.0, 1.0]).unwrap());
    let drift = Drift { shape, valid: ValidRange::new(0.0, 20.0).unwrap() };
    AppliedModel {
        column: column.to_owned(),
        temperature: "temp".to_owned(),
        written_temperature: WrittenTemperature::Celsius,
        model: DriftModel::of_curve(drift),
        // Believed as far past it as of a model by `auto`.
        measured: ValidRange::new(2.5, 17.5).unwrap(),
        factor: 1.0,
    }
}

fn apply_to(log: &str, to: &AppliedTo<'_>, models: &[AppliedModel]) -> (Result<Applied, ApplyError>, String) {
    let table = Table::open(&Source::bytes("log.tsv", log.as_bytes())).unwrap();
    let mut output = Vec::new();
    let applied = apply(&table, to, models, &mut output);
    (applied, String::from_utf8(output).unwrap())
}

/// As it is applied to a log with this column of times.
fn apply_timed(log: &str, time: &str, start: Start, models: &[AppliedModel]) -> (Result<Applied, ApplyError>, String) {
    let table = Table::open(&Source::bytes("log.tsv", log.as_bytes())).unwrap();
    let (temperature, rates) = (Some("temp".to_owned()), vec!["x".to_owned()]);
    let columns = Columns {
        time: Some(time.to_owned()),
        temperature,
        rates,
        rate_unit: WrittenRate::of(RateUnit::Dps),
        ..Columns::default()
    };
    let clock = surveyed(&table, &columns.resolve(&table).unwrap()).unwrap().clock;
    apply_to(log, &AppliedTo { time: Some((time, &clock)), start }, models)
}

fn correct(log: &str) -> (Result<Applied, ApplyError>, String) {
    apply_to(log, &TO, &[model("x"), model("y")])
}

#[test]
fn every_row_and_column_is_kept_and_two_are_added_for_each_rate() {
    let log = "temp\tx\tnote\ty\n0\t1.5\ta, b\t1\n10\tnan\tc\t\n\t3\td\t4\n";
    let (applied, text) = correct(&log.replace("a, b", "'a, b'").replace("c\t", "7\t").replace('\'', ""));
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0], "temp,x,note,y,predicted_x,corrected_x,predicted_y,corrected_y");
    assert_eq!(lines[1], "0,1.5,\"a, b\",1,1,0.5,1,0");
    assert_eq!(lines[2], "10,nan,7,,2,,2,", "a row without a rate keeps its prediction");
    assert_eq!(lines[3], ",3,d,4,,,,");
    assert_eq!(applied.unwrap(), Applied { rows: 3, without_temperature: 1, unmeasured: 1, ..Applied::default() });
}

#[test]
fn outside_the_valid_range_the_curve_is_held_and_counted() {
    let (applied, text) = correct("temp,x,y\n-50,0,0\n90,0,0\n1,0,0\n10,0,0\n");
    assert!(text.contains("-50,0,0,1,-1,1,-1") && text.contains("90,0,0,3,-3,3,-3"), "{text}");
    let applied = applied.unwrap();
    assert_eq!((applied.outside, applied.unmeasured), (2, 3));
}

#[test]
fn a_column_in_another_unit_keeps_it_and_so_does_its_prediction() {
    // 10 C, where the bias is 2 dps, is 50 F; in mdps the bias is 2000.
    let own = AppliedModel { written_temperature: WrittenTemperature::Fahrenheit, factor: 1e-3, ..model("x") };
    let (_, text) = apply_to("temp,x\n50,2500\n", &TO, &[own]);
    assert_eq!(text, "temp,x,predicted_x,corrected_x\n50,2500,2000,500\n");
}

#[test]
fn a_line_that_is_cut_is_left_out_and_told() {
    let (applied, text) = apply_to("temp,x\n10,3\n10,3.1", &TO, &[model("x")]);
    assert_eq!((applied.unwrap().cut_line, text.lines().count()), (Some(3), 2));
}

#[test]
fn a_log_that_cannot_be_read_names_its_line_or_column() {
    let (applied, _) = correct("temp,x,y\n1,2,3\n1,oops,3\n");
    assert!(applied.unwrap_err().to_string().contains("log.tsv: line 3: column 'x' holds 'oops'"));
    let (applied, _) = correct("temp,x\n1,2\n");
    assert!(applied.unwrap_err().to_string().contains("there is no column 'y'"));
}

/// A play of 2 degrees beside the drift, and a drift in time of 0.001 a second about 100 s.
fn with_history(column: &str) -> AppliedModel {
    let mut own = model(column);
    let term = Term { memory: Memory::Play { half_width: 2.0 }, weight: 0.5, behind: 0.0, share: 1.0 };
    own.model.history = History::new(own.model.drift.shape.clone(), &[term]);
    own.model.time_drift = Some(TimeDrift::straight(1e-3, 100.0));
    own
}

/// Heating from 5 to 15 degrees, a degree every 20 s; `rates` false leaves their cells empty.
fn ramp(start: Start, rates: bool) -> (Applied, Vec<f64>) {
    let mut log = String::from("time_ms,temp,x\n");
    for step in 0..=10 {
        writeln!(log, "{},{},{}", 5000 + 20_000 * step, 5 + step, if rates { "1" } else { "" }).unwrap();
    }
    let (applied, text) = apply_timed(&log, "time_ms", start, &[with_history("x")]);
    (applied.unwrap(), predictions(&text))
}

fn predictions(text: &str) -> Vec<f64> {
    csv::Reader::from_reader(text.as_bytes()).records().map(|row| row.unwrap()[3].parse().unwrap()).collect()
}

#[test]
fn a_history_starts_with_the_first_row_and_runs_through_rows_without_rates() {
    let (applied, predicted) = ramp(Start::Unknown, true);
    assert_eq!(predicted, ramp(Start::Unknown, false).1);
    assert!((predicted[0] - 1.5).abs() < 1e-12, "nothing is known: the curve alone");
    // After 4 degrees the play is known to trail by 2.
    for (step, predicted) in predicted.iter().enumerate().skip(4) {
        let expected = 1.5 + 0.1 * step as f64 - 0.5 * 2.0;
        assert!((predicted - expected).abs() < 1e-12, "{step}: {predicted} {expected}");
    }
    assert_eq!((applied.rows, applied.uncertain), (11, 4));
}

#[test]
fn in_its_own_recording_the_drift_in_time_is_added_and_the_history_believed() {
    let (applied, predicted) = ramp(Start::OwnRecording, false);
    for (step, predicted) in predicted.iter().enumerate() {
        // The middle of what is possible: half the way, and 2 from the fourth degree on.
        let play = -(0.5 * step as f64).min(2.0);
        let expected = 1.5 + 0.1 * step as f64 + 0.5 * play + 1e-3 * (20.0 * step as f64 - 100.0);
        assert!((predicted - expected).abs() < 1e-12, "{step}: {predicted} {expected}");
    }
    assert_eq!(applied.uncertain, 0);
}

#[test]
fn a_model_that_needs_time_says_so() {
    let (log, own) = ("clock,temp,x\n1,5,0\n2,6,0\n", [with_history("x")]);
    let untimed = apply_to(log, &AppliedTo { start: Start::OwnRecording, ..TO }, &own).0.unwrap_err().to_string();
    assert!(untimed.contains("say which (`time`)"), "{untimed}");
    let no_unit = apply_timed(log, "clock", Start::OwnRecording, &own).0.unwrap_err().to_string();
    assert!(no_unit.contains("'clock' names no unit"), "{no_unit}");
}

/// Of a ramp of 0.01 degrees a second a lag of 100 s is behind by `1 - exp(-t / 100 s)`, also where a counter of microseconds is full
/// and starts anew.
#[test]
fn a_lag_goes_on_where_a_counter_of_32_bits_is_full() {
    let mut own = model("x");
    let term = Term { memory: Memory::Lag { time_constant_s: 100.0 }, weight: 1.0, behind: 0.0, share: 1.0 };
    own.model.history = History::new(own.model.drift.shape.clone(), &[term]);
    let mut log = String::from("time_us,temp,x\n");
    for second in 0..1000_u64 {
        let counted = (4_294_967_296 - 400_000_000 + 1_000_000 * second) % 4_294_967_296;
        writeln!(log, "{counted},{},0", 5.0 + 0.01 * second as f64).unwrap();
    }
    let predicted = predictions(&apply_timed(&log, "time_us", Start::Unknown, &[own]).1);
    assert_eq!(predicted.len(), 1000);
    for (second, predicted) in predicted.iter().enumerate() {
        let second = second as f64;
        let expected = 1.5 + 0.001 * second - (1.0 - (-second / 100.0).exp());
        assert!((predicted - expected).abs() < 1e-9, "{second}: {predicted} {expected}");
    }
}
