mod cells;
mod several;

use std::fmt::Write;
use zerorate_fit::model::Model;
use zerorate_fit::residual::ResidualStatistics;

use super::*;
use crate::condition::DropReason;
use crate::condition::tests::cycle;
use crate::quality::{ReasonKind, Verdict};

/// Writes columns as the log encoder does, fits them, and gives the fit.
fn fit(temperatures: &[f64], rates: &[Vec<f64>], options: &FitOptions) -> LogFit {
    fit_logs(&[log(temperatures, rates)], options).unwrap()
}

fn log(temperatures: &[f64], rates: &[Vec<f64>]) -> Source {
    let mut text = String::from("t_s,temperature_c,x_rad_s,y_rad_s\n");
    for (row, temperature) in temperatures.iter().enumerate() {
        let time = 0.5 * row as f64;
        writeln!(text, "{time},{temperature},{},{}", rates[0][row], rates[1][row]).unwrap();
    }
    Source::bytes("log.csv", text.into_bytes())
}

fn used(axis: &AxisFit) -> u64 {
    axis.calibration.fit.statistics.samples_used
}

/// In-sample and held out.
fn residuals(axis: &AxisFit) -> (ResidualStatistics, ResidualStatistics) {
    let statistics = &axis.calibration.fit.statistics;
    (statistics.in_sample, statistics.held_out.unwrap())
}

fn plain(model: Model) -> FitOptions {
    FitOptions { model, plain: true, ..FitOptions::default() }
}

fn kinds(fit: &LogFit) -> Vec<ReasonKind> {
    fit.judgement.reasons.iter().map(|reason| reason.kind).collect()
}

/// Half an hour of a gyro with noise of its own, in the numbers that `write` makes of them.
fn half_hour(name: &str, seed: u32, write: impl Fn(f64, f64) -> String) -> Source {
    table(name, &lines(seed, write))
}

fn table(name: &str, lines: &[String]) -> Source {
    Source::bytes(name, format!("time_s,temperature_c,gyro_x_rad_s\n{}", lines.concat()).into_bytes())
}

/// Noise that is alike from -0.5 to 0.5, by a linear congruential generator.
fn noise(seed: u32) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24) - 0.5
    }
}

/// The lines of half an hour, two a second.
fn lines(seed: u32, write: impl Fn(f64, f64) -> String) -> Vec<String> {
    let mut noise = noise(seed);
    let line = |row: i32| {
        let t = 20.0 + 30.0 * (f64::from(row) / 573.0).sin();
        format!("{},{}\n", 0.5 * f64::from(row), write(t, 0.1 + 1e-3 * t + 0.05 * noise()))
    };
    (0..3600).map(line).collect()
}

#[test]
fn a_clean_cycle_is_good_and_its_curve_is_found() {
    let (temperatures, rates) = cycle();
    let fit = fit(&temperatures, &rates, &FitOptions::default());
    assert_eq!((fit.judgement.verdict, fit.axes.len()), (Verdict::Good, 2));
    let [x, y] = &fit.axes[..] else { panic!() };
    assert_eq!(x.calibration.fit.statistics.samples_used, 8400);
    let drift = x.calibration.measured_drift();
    for step in 0..=10 {
        let t = drift.valid.min() + 0.1 * f64::from(step) * (drift.valid.max() - drift.valid.min());
        let (got, truth) = (drift.evaluate(t).0, 0.01 + 3e-4 * t - 2e-6 * t * t);
        assert!((got - truth).abs() < 0.01 * drift.peak_to_peak(), "at {t}: {got} {truth}");
    }
    let (in_sample, held_out) = residuals(y);
    assert!(in_sample.rms < 1e-4 && held_out.rms < 1.2 * in_sample.rms);
    assert_eq!(x.trace.len(), 400);
}

#[test]
fn plain_counts_every_numeric_row_of_each_axis_once() {
    let (mut temperatures, mut rates) = cycle();
    (0..8400).step_by(50).for_each(|row| temperatures[row] = f64::NAN);
    rates[1][77] = f64::NAN;
    rates[0][4001] += 1.0;
    let fit = fit(&temperatures, &rates, &plain(Model::Poly(2)));
    assert_eq!(fit.axes.iter().map(used).collect::<Vec<_>>(), [8232, 8231]);
    assert_eq!(
        fit.axes[1].samples_rejected,
        [
            Rejected { reason: DropReason::MissingTemperature, count: 168 },
            Rejected { reason: DropReason::MissingRate, count: 1 },
        ]
    );
    assert!(residuals(&fit.axes[0]).0.pp > 0.9, "the spike is fitted too");
    assert_eq!(kinds(&fit), [ReasonKind::MissingValues], "of all axes, and told once");
    let [candidate] = &fit.axes[1].calibration.fit.statistics.candidates[..] else { panic!() };
    let (in_sample, held_out) = residuals(&fit.axes[1]);
    let ratio = candidate.held_out_rms.unwrap() / held_out.rms;
    assert!((ratio - 1.0).abs() < 1e-9, "the factor's equals a pass's");
    assert!((candidate.in_sample_rms / in_sample.rms - 1.0).abs() < 1e-9);
}

#[test]
fn a_narrow_span_is_rejected_unless_allowed() {
    let (temperatures, rates) = cycle();
    let near = 1000..1400;
    let rates = rates.map(|rate| rate[near.clone()].to_vec());
    let temperatures: Vec<f64> = temperatures[near].iter().map(|t| 20.0 + (t - 20.0) / 4.0).collect();
    let refused = fit(&temperatures, &rates, &FitOptions::default());
    assert_eq!((refused.judgement.verdict, kinds(&refused)), (Verdict::Rejected, vec![ReasonKind::NarrowSpan]));
    assert!(refused.axes.is_empty());
    let allowed = FitOptions { allow_narrow: true, ..FitOptions::default() };
    let allowed = fit(&temperatures, &rates, &allowed);
    // The piece of the cycle only cools.
    let expected = vec![ReasonKind::NarrowSpan, ReasonKind::OneDirection];
    assert_eq!((allowed.judgement.verdict, kinds(&allowed)), (Verdict::Warning, expected));
    let valid = allowed.axes[0].calibration.drift().valid;
    assert!(valid.max() - valid.min() < 10.0);
}

#[test]
fn a_stuck_temperature_is_rejected_in_both_modes() {
    let (_, rates) = cycle();
    for options in [FitOptions::default(), plain(Model::Poly(3))] {
        let fit = fit(&[25.0; 2000], &rates, &options);
        assert_eq!((fit.judgement.verdict, kinds(&fit)), (Verdict::Rejected, vec![ReasonKind::StuckTemperature]));
    }
}

#[test]
fn spikes_rotation_and_a_step_are_reported_and_leave_the_curve_alone() {
    let (temperatures, clean) = cycle();
    let reference = fit(&temperatures, &clean, &FitOptions::default());
    let spike = |rates: &mut [Vec<f64>; 2]| (60..8400).step_by(105).for_each(|row| rates[0][row] += 0.8);
    let rotate = |rates: &mut [Vec<f64>; 2]| (5000..5060).for_each(|row| rates[0][row] += 2.0);
    let step = |rates: &mut [Vec<f64>; 2]| (4000..8400).for_each(|row| rates[0][row] += 0.02);
    type Fault<'a> = &'a dyn Fn(&mut [Vec<f64>; 2]);
    let faults: [(Fault, ReasonKind); 3] =
        [(&spike, ReasonKind::Spikes), (&rotate, ReasonKind::Rotation), (&step, ReasonKind::Step)];
    for (fault, kind) in faults {
        let mut rates = clean.clone();
        fault(&mut rates);
        let fit = fit(&temperatures, &rates, &FitOptions::default());
        assert!(kinds(&fit).contains(&kind), "{kind:?}: {:?}", fit.judgement);
        assert_eq!(fit.judgement.verdict, Verdict::Warning);
        for t in [-15.0, 0.0, 30.0, 70.0] {
            let difference =
                fit.axes[0].calibration.drift().evaluate(t).0 - reference.axes[0].calibration.drift().evaluate(t).0;
            assert!(difference.abs() < 3e-4, "{kind:?} at {t}: {difference}");
        }
    }
}

#[test]
fn too_little_is_rejected_with_a_reason() {
    let (temperatures, rates) = cycle();
    let few = [0, 1000, 2000].map(|row| temperatures[row]);
    let few_rates = rates.clone().map(|rate| [0, 1000, 2000].map(|row| rate[row]).to_vec());
    let fit_few = fit(&few, &few_rates, &plain(Model::Poly(3)));
    assert_eq!((fit_few.judgement.verdict, kinds(&fit_few)[0]), (Verdict::Rejected, ReasonKind::TooFewGroups));
    let none = vec![f64::NAN; 100];
    let nothing = fit(&temperatures[..100], &[none.clone(), none], &FitOptions::default());
    assert_eq!(kinds(&nothing).last(), Some(&ReasonKind::NoFiniteRows));
}

#[test]
fn a_log_of_an_autopilot_without_a_row_is_told_as_one() {
    // ULog's 16 bytes of a beginning: the mark, version 1, the time.
    let head = [b"ULog\x01\x12\x35\x01".as_slice(), &[0; 8]].concat();
    let fit = fit_logs(&[Source::bytes("head.ulg", head)], &FitOptions::default()).unwrap();
    let [reason] = &fit.judgement.reasons[..] else { panic!("{:?}", fit.judgement) };
    assert!(reason.text.starts_with("the log has no row of a gyro or an accelerometer"), "{reason:?}");
}

#[test]
fn time_running_backwards_is_an_error_that_names_the_row() {
    let log = Source::bytes("log.csv", *b"t_s,temperature_c,x_dps\n1,20,0\n3,21,0\n2,22,0\n");
    let error = fit_logs(&[log], &FitOptions::default()).unwrap_err().to_string();
    assert!(error.contains("row 3: column 't_s' runs backwards, from 3 to 2"), "{error}");
}

#[test]
fn the_json_is_the_documented_one() {
    let (temperatures, rates) = cycle();
    let fit = fit(&temperatures, &rates, &plain(Model::Poly(3)));
    let json = serde_json::to_value(&fit).unwrap();
    assert_eq!((json["schema"].as_u64(), json["verdict"].as_str()), (Some(1), Some("good")));
    let axis = json["axes"]["x_rad_s"].as_object().unwrap();
    let keys: Vec<&str> = axis.keys().map(String::as_str).collect();
    assert_eq!(
        keys,
        [
            "model",
            "static_model",
            "raw_coefficients",
            "rate_unit",
            "temperature_unit",
            "temperature",
            "believed",
            "in_sample",
            "held_out",
            "samples_used",
            "samples_rejected",
        ]
    );
    assert_eq!((axis["model"].as_str(), axis["rate_unit"].as_str()), (Some("poly:3"), Some("rad/s")));
    assert_eq!(axis["raw_coefficients"].as_array().unwrap().len(), 4);
    assert!(axis["held_out"]["pp"].as_f64().unwrap() > axis["held_out"]["rms"].as_f64().unwrap());
}

#[test]
fn a_run_joined_to_itself_and_a_column_saved_as_two_are_told() {
    let lines = |log: &Source| String::from_utf8(log.start(u64::MAX).unwrap()).unwrap();
    let once = half_hour("once.csv", 7, |t, rate| format!("{t},{rate}"));
    let fitted =
        |text: String| fit_logs(&[Source::bytes("log.csv", text.into_bytes())], &FitOptions::default()).unwrap();
    let again: String = lines(&once)
        .lines()
        .skip(1)
        .enumerate()
        .map(|(row, line)| {
            let rest = line.split_once(',').unwrap().1;
            format!("{},{rest}\n", 1800.0 + 0.5 * row as f64)
        })
        .collect();
    let told = fitted(lines(&once) + &again);
    assert!(
        told.reasons().any(|text| text.starts_with("log.csv: about 50 % of the rows stand in it twice")),
        "{:?}",
        told.judgement
    );
    let two = half_hour("two.csv", 7, |t, rate| format!("{t},{rate},{rate}"));
    let told = fitted(lines(&two).replace("gyro_x_rad_s", "gyro_x_rad_s,gyro_y_rad_s"));
    let expected = "gyro_x_rad_s and gyro_y_rad_s are the same numbers: one of the two was not measured";
    assert!(
        told.reasons().any(|text| text == expected) && told.judgement.verdict == Verdict::Warning,
        "{:?}",
        told.judgement
    );
    assert!(!kinds(&fitted(lines(&once))).contains(&ReasonKind::Repeated));
}

#[test]
fn a_gyro_that_reads_one_number_is_rejected_and_the_others_are_fitted_as_if_alone() {
    let (temperatures, mut rates) = cycle();
    let clean = fit(&temperatures, &rates, &FitOptions::default());
    let middle = rates[0].len() / 2;
    rates[0][middle..].fill(0.0125);
    let told = fit(&temperatures, &rates, &FitOptions::default());
    let [x, y] = &told.verdicts[..] else { panic!() };
    assert_eq!((x.judgement.verdict, y.judgement.verdict), (Verdict::Rejected, Verdict::Good));
    let text = &x.judgement.reasons[0].text;
    assert!(
        text.starts_with("x_rad_s: the rate is 0.0125 rad/s and nothing else from 2100 s to 4200 s (rows 4201 to 8400"),
        "{text}"
    );
    assert_eq!(told.axes[0].calibration.drift(), clean.axes[1].calibration.drift());
    assert!(told.excluded.is_empty(), "{:?}", told.excluded);
}

#[test]
fn a_fit_that_leaves_more_than_nothing_does_is_told() {
    // A rate that wanders in time and knows nothing of the temperature, which comes by twice: a random walk, seed 4.
    let mut state = 4_u64;
    let mut walk = 0.0;
    let mut step = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        walk += ((state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5) * 1e-4;
        walk
    };
    let temperatures: Vec<f64> = (0..4000).map(|row: i32| 20.0 + 0.02 * f64::from(2000 - (2000 - row).abs())).collect();
    let rates = vec![
        (0..4000).map(|_| step()).collect::<Vec<f64>>(),
        temperatures.iter().map(|t| 1e-4 * t + 1e-6 * (t * 77.0).sin()).collect(),
    ];
    let told = fit(&temperatures, &rates, &FitOptions::default());
    let statistics = &told.axes[0].calibration.fit.statistics;
    let worse = statistics.deployed.unwrap().rms > statistics.uncorrected.unwrap().rms;
    let of =
        |axis: usize| told.verdicts[axis].judgement.reasons.iter().any(|r| r.kind == ReasonKind::WorseThanUncorrected);
    assert!(worse && of(0) && !of(1), "{statistics:?}");
}

#[test]
fn what_is_told_is_of_what_was_measured_and_how_far_it_is_believed_stands_beside_it() {
    let (temperatures, rates) = cycle();
    let fit = fit(&temperatures, &rates, &FitOptions::default());
    let json = serde_json::to_value(&fit).unwrap();
    let of = |name: &str| -> [f64; 2] { serde_json::from_value(json["axes"]["x_rad_s"][name].clone()).unwrap() };
    let extremes = temperatures.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], t| [a.min(*t), b.max(*t)]);
    let (measured, believed) = (of("temperature"), of("believed"));
    // Averages of 10 s turn a little before the temperature does.
    assert!(measured.iter().zip(extremes).all(|(own, row)| (own - row).abs() < 0.2), "{measured:?} {extremes:?}");
    let eighth = (measured[1] - measured[0]) / 8.0;
    assert!((measured[0] - eighth - believed[0]).abs() < 1e-9 && (measured[1] + eighth - believed[1]).abs() < 1e-9);
    let calibration = fit.to_calibration(Vec::new(), None).unwrap();
    let read = Calibration::from_json(&calibration.to_json().unwrap()).unwrap();
    let own = &read.axes["x_rad_s"];
    assert_eq!(ValidRange::new(measured[0], measured[1]), Some(own.fit.measured));
    // The quadratic of the log, over what was measured and over more.
    assert!(own.measured_drift().peak_to_peak() < own.drift().peak_to_peak());
}

#[test]
fn times_that_are_no_numbers_end_no_loop_and_lose_no_rows() {
    let time = |i: i32| if i % 7 == 3 || i < 40 { "nan".to_owned() } else { i.to_string() };
    let rows: String =
        (0..2000).map(|i| format!("{},{},{}\n", time(i), 20.0 + 0.01 * f64::from(i), 1e-5 * f64::from(i))).collect();
    let log = Source::bytes("log.csv", format!("time_s,temperature_c,gyro_x_rad_s\n{rows}").into_bytes());
    let fit = fit_logs(&[log], &FitOptions::default());
    let told = fit.map(|fit| fit.axes.first().map(|axis| axis.calibration.fit.statistics.samples_used));
    assert!(matches!(told, Ok(Some(2000)) | Err(_)), "{told:?}");
}

#[test]
fn a_temperature_that_is_missing_is_told_once_and_a_rate_of_its_axis() {
    let (mut temperatures, mut rates) = cycle();
    (0..8400).step_by(10).for_each(|row| temperatures[row] = f64::NAN);
    (1..8400).step_by(20).for_each(|row| rates[1][row] = f64::NAN);
    for options in [FitOptions::default(), plain(Model::Poly(3))] {
        let fit = fit(&temperatures, &rates, &options);
        let missing: Vec<&str> = fit.reasons().filter(|text| text.contains("no number")).collect();
        assert_eq!(
            missing,
            [
                "every axis: 840 of 8400 rows were left out: no number for the temperature",
                "y_rad_s: 420 of 8400 rows were left out: no number for the rate",
            ]
        );
    }
}

#[test]
fn rows_that_have_both_and_were_left_out_are_not_told_to_have_none() {
    let (temperatures, rates) = cycle();
    // Turned one way, then the other: no row is near what the gyro shows at rest.
    let turned: Vec<f64> = (0..8400).map(|row| if row < 4200 { 1.0 } else { -1.0 }).collect();
    let turned: Vec<f64> = turned.iter().zip(&rates[0]).map(|(turn, rate)| turn + rate).collect();
    let all = fit(&temperatures, &[turned, rates[1].clone()], &FitOptions::default());
    assert_eq!(all.judgement.verdict, Verdict::Rejected, "{:?}", all.judgement);
    let told = "x_rad_s: all 8400 rows with a temperature and a rate were left out";
    assert!(all.reasons().any(|text| text.starts_with(told)), "{:?}", all.judgement);
    assert!(!all.reasons().any(|text| text.contains("no row has both")), "{:?}", all.judgement);
    // And where none has.
    let without = |first: bool| move |row: usize| if (row < 4200) == first { f64::NAN } else { 20.0 };
    let temperatures: Vec<f64> = (0..8400).map(without(true)).collect();
    let rates = [0, 1].map(|_| (0..8400).map(without(false)).collect()).to_vec();
    let none = fit(&temperatures, &rates, &FitOptions::default());
    assert!(none.reasons().any(|text| text == "x_rad_s: no row has both a temperature and a rate"));
}

/// A logger that saves power writes a row every ten seconds outside 0 to 40 C: its rows are rows.
#[test]
fn the_slower_part_of_a_log_is_no_gap() {
    let mut noise = noise(9);
    let of = |t: f64| 0.1 + 1e-3 * t + 1e-5 * t * t;
    let temperature = |second: i32| 25.0 - 35.0 * (std::f64::consts::TAU * f64::from(second) / 3600.0).cos();
    let seconds = (0..7200).filter(|second| second % 10 == 0 || (0.0..40.0).contains(&temperature(*second)));
    let seconds: Vec<i32> = seconds.collect();
    let lines: Vec<String> = seconds
        .iter()
        .map(|second| {
            let t = temperature(*second);
            format!("{second},{t},{}\n", of(t) + 0.01 * noise())
        })
        .collect();
    let fit = fit_logs(&[table("slower.csv", &lines)], &FitOptions::default()).unwrap();
    let [x] = &fit.axes[..] else { panic!() };
    assert_eq!(used(x), seconds.len() as u64, "{:?}", fit.judgement.reasons);
    assert!(kinds(&fit).is_empty(), "{:?}", fit.judgement.reasons);
    let drift = x.calibration.measured_drift();
    assert!(drift.valid.min() < -9.0 && drift.valid.max() > 59.0, "{:?}", drift.valid);
    for t in [-9.0, 10.0, 30.0, 50.0, 59.0] {
        let found = drift.evaluate(t).0;
        assert!((found - of(t)).abs() < 3e-3, "at {t}: {found}, not {}", of(t));
    }
}

/// A temperature at 10 Hz beside a rate that is there for a second of every ten, at 7 C a minute: the bias is of the
/// temperatures that were read with it, so nothing remembers.
#[test]
fn a_rate_is_of_the_temperatures_that_were_read_with_it() {
    let mut noise = noise(5);
    let mut warmest = f64::NEG_INFINITY;
    let lines: Vec<String> = (0..24_000)
        .map(|row| {
            let (second, turn) = (f64::from(row) / 10.0, (f64::from(row) / 12_000.0).fract());
            let t = -10.0 + 70.0 * (1.0 - (2.0 * turn - 1.0).abs());
            let rate = (row % 100 < 10).then(|| 0.1 + 0.004 * t + 8e-5 * t * t + 0.02 * noise());
            warmest = rate.map_or(warmest, |_| warmest.max(t));
            format!("{second},{t},{}\n", rate.map_or_else(String::new, |rate| rate.to_string()))
        })
        .collect();
    let fit = fit_logs(&[table("sparse.csv", &lines)], &FitOptions::default()).unwrap();
    let [x] = &fit.axes[..] else { panic!() };
    let model = &x.calibration.fit.model;
    assert!(x.calibration.measured_drift().valid.max() <= warmest, "{warmest}");
    assert!(model.history.is_none(), "{model}");
}

/// Up and down once, heating 0.05 above and cooling 0.05 below a parabola: its folds are left twice that, and a next run that
/// does the same has half of it left and is helped. A single cycle does not say so, nor the contrary.
#[test]
fn of_a_hysteresis_of_one_cycle_it_is_not_said_that_a_fit_does_not_help() {
    let lines = lines_of_a_cycle(|t, side| 0.1 + 1e-3 * t + 4e-5 * t * t + 0.05 * side);
    let options = FitOptions { model: "poly:2".parse().unwrap(), ..FitOptions::default() };
    let fit = fit_logs(&[table("cycle.csv", &lines)], &options).unwrap();
    let statistics = &fit.axes[0].calibration.fit.statistics;
    assert!(statistics.deployed.unwrap().rms > statistics.uncorrected.unwrap().rms);
    let told = &fit.judgement.reasons[0].text;
    assert!(told.contains("whether it helps on a next run this log does not tell"), "{told}");
}

/// Half an hour up and half an hour down between -10 and 60 C, with noise; `rate` has the temperature and 1 or -1.
fn lines_of_a_cycle(rate: impl Fn(f64, f64) -> f64) -> Vec<String> {
    let mut noise = noise(11);
    let line = |row: i32| {
        let (part, side) = if row < 3600 { (f64::from(row), 1.0) } else { (f64::from(7200 - row), -1.0) };
        let t = -10.0 + 70.0 * part / 3600.0;
        format!("{},{t},{}\n", 0.5 * f64::from(row), rate(t, side) + 0.05 * noise())
    };
    (0..7200).map(line).collect()
}
