use std::fmt::Write as _;

use zerorate_core::drift::{Drift, History, Memory, Polynomial, Scale, Shape, Term, ValidRange};
use zerorate_fit::predict::TimeDrift;

use super::*;
use zerorate_cal::source::Source;

const TO: AppliedTo<'static> = AppliedTo { time: None, time_unit: None, start: Start::Unknown };

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
fn ramp(to: &AppliedTo<'_>, rates: bool) -> (Applied, Vec<f64>) {
    let mut log = String::from("time_ms,temp,x\n");
    for step in 0..=10 {
        writeln!(log, "{},{},{}", 5000 + 20_000 * step, 5 + step, if rates { "1" } else { "" }).unwrap();
    }
    let (applied, text) = apply_to(&log, to, &[with_history("x")]);
    let mut rows = csv::Reader::from_reader(text.as_bytes());
    (applied.unwrap(), rows.records().map(|row| row.unwrap()[3].parse().unwrap()).collect())
}

#[test]
fn a_history_starts_with_the_first_row_and_runs_through_rows_without_rates() {
    let (applied, predicted) = ramp(&TO, true);
    assert_eq!(predicted, ramp(&TO, false).1);
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
    let to = AppliedTo { time: Some("time_ms"), time_unit: Some(TimeUnit::Ms), start: Start::OwnRecording };
    let (applied, predicted) = ramp(&to, false);
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
    let refused = |to: &AppliedTo<'_>| {
        apply_to("clock,temp,x\n1,5,0\n2,6,0\n", to, &[with_history("x")]).0.unwrap_err().to_string()
    };
    let own = AppliedTo { start: Start::OwnRecording, ..TO };
    assert!(refused(&own).contains("say which (`time`)"));
    assert!(refused(&AppliedTo { time: Some("clock"), ..own }).contains("'clock' names no unit"));
}
