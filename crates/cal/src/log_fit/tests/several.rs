//! Several logs of one unit.

use std::cell::Cell;

use super::*;

#[test]
fn the_same_log_twice_is_refused_by_its_content() {
    let rows: String =
        (0..2000).map(|i| format!("{i},{},{}\n", 20.0 + 0.01 * f64::from(i), 1e-5 * f64::from(i))).collect();
    let text = format!("time_s,temperature_c,gyro_x_rad_s\n{rows}");
    let [first, copy] = ["first.csv", "copy.csv"].map(|name| Source::bytes(name, text.clone().into_bytes()));
    let refused = fit_logs(&[first, copy], &FitOptions::default()).unwrap_err().to_string();
    assert!(
        refused.starts_with("copy.csv: the same log as first.csv") && refused.ends_with("give it once"),
        "{refused}"
    );
}

#[test]
fn logs_that_overlap_are_refused_and_successive_ones_are_not() {
    let noise = |row: i32| f64::from(row.wrapping_mul(1_103_515_245).wrapping_add(12_345) >> 16 & 255) * 1e-6;
    let part = |name: &str, rows: std::ops::Range<i32>| {
        let start = rows.start;
        // Times from each file's own start.
        let line = |i: i32| format!("{},{},{}\n", i - start, 20.0 + 0.01 * f64::from(i), noise(i));
        let rows: String = rows.map(line).collect();
        Source::bytes(name, format!("time_s,temperature_c,gyro_x_rad_s\n{rows}").into_bytes())
    };
    let [first, next, overlapping] =
        [part("first.csv", 0..2000), part("next.csv", 2000..4000), part("overlapping.csv", 1500..3500)];
    assert!(fit_logs(&[first.clone(), next], &FitOptions::default()).is_ok());
    let refused = fit_logs(&[first, overlapping], &FitOptions::default()).unwrap_err().to_string();
    assert!(
        refused.starts_with("overlapping.csv: about 2") && refused.contains(" % of its rows are in first.csv"),
        "{refused}"
    );
}

#[test]
fn a_copy_in_other_numbers_is_refused_and_a_second_run_is_not() {
    let exact = |t: f64, rate: f64| format!("{t},{rate}");
    let first = half_hour("first.csv", 7, exact);
    let copies = [
        half_hour("copy.csv", 7, |t, rate| format!("{t:.2},{rate:.4}")),
        half_hour("copy.csv", 7, |t, rate| format!("{t},{}", 57.29578 * rate)),
        // The later two thirds, in fewer digits.
        table("copy.csv", &lines(7, |t, rate| format!("{t:.2},{rate:.3}"))[1200..]),
    ];
    for copy in copies {
        let refused = fit_logs(&[first.clone(), copy], &FitOptions::default()).unwrap_err().to_string();
        assert!(refused.starts_with("copy.csv: a copy of first.csv in other numbers"), "{refused}");
    }
    for seed in 8..20 {
        assert!(fit_logs(&[first.clone(), half_hour("second.csv", seed, exact)], &FitOptions::default()).is_ok());
    }
}

#[test]
fn temperatures_between_two_logs_that_neither_has_are_told() {
    let about = |name: &str, seed: u32, middle: f64| {
        half_hour(name, seed, move |t, rate| format!("{},{rate}", middle + (t - 20.0) / 3.0))
    };
    let told = |logs: &[Source]| {
        let fit = fit_logs(logs, &FitOptions::default()).unwrap();
        let of_holes = fit.judgement.reasons.into_iter().filter(|reason| reason.kind == ReasonKind::Unmeasured);
        of_holes.map(|reason| reason.text).collect::<Vec<_>>()
    };
    let (cold, hot) = (about("cold.csv", 1, 0.0), about("hot.csv", 2, 40.0));
    let [hole] = &told(&[cold.clone(), hot.clone()])[..] else { panic!() };
    assert!(hole.starts_with("no average lies between 10.0 and 30.0 C"), "{hole}");
    assert!(told(&[cold, hot, about("middle.csv", 3, 20.0)]).is_empty());
}

/// About 20 C and 10 to either side is a log of `half_hour` over three; an eighth of all is 5 degrees.
#[test]
fn two_logs_that_only_touch_are_told_and_one_over_both_joins_them() {
    let about = |name: &str, seed: u32, middle: f64, part: f64| {
        half_hour(name, seed, move |t, rate| format!("{},{rate}", middle + (t - 20.0) * part))
    };
    let told = |logs: &[Source]| {
        let fit = fit_logs(logs, &FitOptions::default()).unwrap();
        let of_these = fit.judgement.reasons.into_iter().filter(|reason| reason.kind == ReasonKind::LogsApart);
        of_these.map(|reason| reason.text).collect::<Vec<_>>()
    };
    let (cold, hot) = (about("cold.csv", 1, 0.0, 1.0 / 3.0), about("hot.csv", 2, 20.0, 1.0 / 3.0));
    let [apart] = &told(&[hot.clone(), cold.clone()])[..] else { panic!() };
    assert!(apart.starts_with("the logs over -10.0 to 10.0 C and those over 10.0 to 30.0 C"), "{apart}");
    assert!(told(&[hot.clone(), cold.clone(), about("both.csv", 3, 10.0, 1.0 / 3.0)]).is_empty(), "one goes over both");
    assert!(told(&[hot, about("inside.csv", 4, 20.0, 1.0 / 9.0)]).is_empty(), "one is inside the other");
}

#[test]
fn where_it_reads_one_number_in_a_second_log_is_told_by_that_logs_own_rows() {
    let logs = [
        half_hour("first.csv", 7, |t, rate| format!("{t},{rate}")),
        half_hour("second.csv", 7, |t, _| format!("{t},0.0125")),
    ];
    let told = fit_logs(&logs, &FitOptions::default()).unwrap();
    let text = told.reasons().find(|text| text.contains("nothing else")).unwrap();
    assert!(text.starts_with("gyro_x_rad_s: second.csv: the rate is 0.0125"), "{text}");
    assert!(text.contains("from 0 s to 1800 s (rows 1 to 3600"), "{text}");
}

#[test]
fn an_empty_log_among_others_is_named() {
    let rows: String =
        (0..2000).map(|i| format!("{i},{},{}\n", 20.0 + 0.01 * f64::from(i), 1e-5 * f64::from(i))).collect();
    let head = "time_s,temperature_c,gyro_x_rad_s\n";
    let good = Source::bytes("good.csv", format!("{head}{rows}").into_bytes());
    let empty = Source::bytes("empty.csv", head.as_bytes().to_vec());
    for logs in [[good.clone(), empty.clone()], [empty, good]] {
        let said = match fit_logs(&logs, &FitOptions::default()) {
            Err(error) => error.to_string(),
            Ok(fit) => fit.notes.into_iter().chain(fit.judgement.reasons.into_iter().map(|r| r.text)).collect(),
        };
        assert!(said.contains("empty.csv"), "{said}");
    }
}

#[test]
fn what_is_found_in_one_of_several_logs_is_told_by_its_name_and_its_own_rows_and_seconds() {
    let first = half_hour("first.csv", 7, |t, rate| format!("{t},{rate}"));
    // Row 2001 is at 1000 s, and the last row before the hole, 600, at 299.5 s.
    let row = Cell::new(0);
    let moved = lines(9, |t, rate| {
        let turned = if (2000..2042).contains(&row.replace(row.get() + 1)) { 2.0 } else { 0.0 };
        format!("{t},{}", rate + turned)
    });
    let second = table("second.csv", &[&moved[..600], &moved[1200..]].concat());
    let told = |logs: &[Source]| fit_logs(logs, &FitOptions::default()).unwrap().judgement.reasons;
    let alone = told(std::slice::from_ref(&second));
    let alone = |kind| alone.iter().find(|reason| reason.kind == kind).unwrap().text.clone();
    let of_both = told(&[first, second.clone()]);
    for (kind, part) in [
        (ReasonKind::Gap, "nothing was logged for 5 min, from 300 s to 600 s, between rows 600 and 601, at "),
        (ReasonKind::Rotation, "the unit was moved from "),
    ] {
        let text = &of_both.iter().find(|reason| reason.kind == kind).unwrap().text;
        assert_eq!(*text, format!("second.csv: {}", alone(kind)));
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn a_fit_that_helps_none_of_the_logs_that_it_has_not_seen_is_told() {
    // A drift that turns round at 20 C: each log is on one side of it, and neither knows of the other.
    let log = |name: &str, seed: u32, side: f64| {
        half_hour(name, seed, move |t, rate| {
            let t = 20.0 + side * (t - 20.0).abs();
            format!("{t},{}", 0.01 * (rate - 0.1) + 1e-3 * (t - 20.0).abs())
        })
    };
    let told = |logs: &[Source]| {
        let fit = fit_logs(logs, &FitOptions::default()).unwrap();
        let reasons =
            fit.judgement.reasons.into_iter().filter(|reason| reason.kind == ReasonKind::WorseThanUncorrected);
        (reasons.map(|reason| reason.text).collect::<Vec<_>>(), fit.judgement.verdict)
    };
    let (texts, verdict) = told(&[log("cold.csv", 7, -1.0), log("hot.csv", 8, 1.0)]);
    assert!(
        texts.len() == 1 && texts[0].contains("of none of the logs is less left by a fit of the others"),
        "{texts:?}"
    );
    assert_eq!(verdict, Verdict::Warning);
    let (texts, _) = told(&[log("first.csv", 7, 1.0), log("second.csv", 8, 1.0)]);
    assert!(texts.is_empty(), "{texts:?}");
}

#[test]
fn logs_of_one_unit_may_have_been_recorded_at_other_rates() {
    // Thirty rows a second are too few for a group of ten seconds: those of the slow log take longer than a gap of the fast one.
    let every = |name: &str, seed: u32, step: usize| {
        let lines = lines(seed, |t, rate| format!("{t},{rate}"));
        table(name, &lines.into_iter().step_by(step).collect::<Vec<_>>())
    };
    let alone = fit_logs(&[every("fast.csv", 7, 1)], &FitOptions::default()).unwrap();
    for logs in
        [[every("fast.csv", 7, 1), every("slow.csv", 8, 10)], [every("slow.csv", 8, 10), every("fast.csv", 7, 1)]]
    {
        let both = fit_logs(&logs, &FitOptions::default()).unwrap();
        assert!(!kinds(&both).contains(&ReasonKind::Gap), "{:?}", both.judgement.reasons);
        assert_eq!(used(&both.axes[0]), used(&alone.axes[0]) + 360);
        let left = &both.axes[0].calibration.fit.statistics.by_log;
        assert!(left.len() == 2 && left.iter().all(|log| log.by_all.is_finite()), "{left:?}");
    }
}
