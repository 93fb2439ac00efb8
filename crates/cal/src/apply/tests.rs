use std::fmt::Write as _;
use std::fs;

use zerorate_core::drift::{Polynomial, Scale, Shape, ValidRange};

use super::*;

const TO: AppliedTo<'static> = AppliedTo { temperature: "temp", time: None, time_unit: None, own_recording: false };

/// 1 + T / 10 over 0..20.
fn drift(column: &str) -> AppliedDrift {
    let scale = Scale::spanning(0.0, 20.0).unwrap();
    AppliedDrift {
        column: column.to_owned(),
        drift: Drift {
            shape: Shape::Polynomial(Polynomial::new(scale, &[2.0, 1.0]).unwrap()),
            valid: ValidRange::new(0.0, 20.0).unwrap(),
        },
        history: None,
        time_drift: None,
    }
}

fn correct(log: &str) -> (Result<Applied, ApplyError>, String) {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("log.tsv"), folder.path().join("out.csv"));
    fs::write(&input, log).unwrap();
    fs::write(&output, "earlier").unwrap();
    let applied = apply(&input, &TO, &[drift("x"), drift("y")], &output);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "nothing is left beside it");
    (applied, fs::read_to_string(&output).unwrap())
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
    assert_eq!(applied.unwrap(), Applied { rows: 3, without_temperature: 1, ..Applied::default() });
}

#[test]
fn outside_the_valid_range_the_curve_is_held_and_counted() {
    let (applied, text) = correct("temp,x,y\n-50,0,0\n90,0,0\n");
    assert!(text.contains("-50,0,0,1,-1,1,-1") && text.contains("90,0,0,3,-3,3,-3"), "{text}");
    assert_eq!(applied.unwrap().outside, 2);
}

#[test]
fn a_log_that_cannot_be_read_leaves_the_earlier_output() {
    let (applied, text) = correct("temp,x,y\n1,2,3\n1,oops,3\n");
    assert!(applied.unwrap_err().to_string().contains(":3: column 'x' holds 'oops'"));
    assert_eq!(text, "earlier");
    let (applied, text) = correct("temp,x\n1,2\n");
    assert!(applied.unwrap_err().to_string().contains("there is no column 'y'"));
    assert_eq!(text, "earlier");
}

#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("log.csv");
    fs::write(&input, "temp,x\n1,2\n").unwrap();
    let error = apply(&input, &TO, &[drift("x")], Path::new("/nowhere/out.csv")).unwrap_err().to_string();
    assert!(error.starts_with("/nowhere/out.csv: cannot be written"), "{error}");
}

/// A play of 2 degrees beside the drift, and a drift in time of 0.001 a second about 100 s.
fn with_history(column: &str) -> AppliedDrift {
    let plain = drift(column);
    let term = Term { memory: Memory::Play { half_width: 2.0 }, weight: 0.5, share: 1.0 };
    let history = History::new(plain.drift.shape.clone(), &[term]);
    AppliedDrift { history, time_drift: Some(TimeDrift { per_second: 1e-3, origin_s: 100.0 }), ..plain }
}

/// Heating from 5 to 15 degrees, a degree every 20 s; `rates` false leaves their cells empty.
fn ramp(to: &AppliedTo<'_>, rates: bool) -> (Applied, Vec<f64>) {
    let mut log = String::from("time_ms,temp,x\n");
    for step in 0..=10 {
        writeln!(log, "{},{},{}", 5000 + 20_000 * step, 5 + step, if rates { "1" } else { "" }).unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("log.csv"), folder.path().join("out.csv"));
    fs::write(&input, log).unwrap();
    let applied = apply(&input, to, &[with_history("x")], &output).unwrap();
    let mut rows = csv::Reader::from_path(&output).unwrap();
    (applied, rows.records().map(|row| row.unwrap()[3].parse().unwrap()).collect())
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
    let to = AppliedTo { time: Some("time_ms"), time_unit: Some(TimeUnit::Ms), own_recording: true, ..TO };
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
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("log.csv");
    fs::write(&input, "clock,temp,x\n1,5,0\n2,6,0\n").unwrap();
    let refused = |to: &AppliedTo<'_>| {
        apply(&input, to, &[with_history("x")], &folder.path().join("out.csv")).unwrap_err().to_string()
    };
    let own = AppliedTo { own_recording: true, ..TO };
    assert!(refused(&own).contains("say which with --time"));
    assert!(refused(&AppliedTo { time: Some("clock"), ..own }).contains("'clock' names no unit"));
}
