//! Numbers that are no readings as they stand: filled cells, and steps of a converter.

use super::*;

fn cycle_less(shown: impl Fn(usize, f64) -> f64) -> LogFit {
    let exact = lines_of_a_cycle(|t, _| 0.3 + 0.004 * t);
    let line = |(row, line): (usize, &String)| {
        let numbers: Vec<&str> = line.trim().split(',').collect();
        format!("{},{},{}\n", numbers[0], numbers[1], shown(row, numbers[2].parse().unwrap()))
    };
    fit_logs(&[table("log.csv", &exact.iter().enumerate().map(line).collect::<Vec<_>>())], &FitOptions::default())
        .unwrap()
}

fn told(fit: &LogFit, kind: ReasonKind) -> Vec<&str> {
    let all = fit.verdicts.iter().flat_map(|axis| &axis.judgement.reasons).chain(&fit.judgement.reasons);
    all.filter(|reason| reason.kind == kind).map(|reason| reason.text.as_str()).collect()
}

#[test]
fn zeros_between_readings_are_left_out_and_told_at_any_pace() {
    for every in [2, 5, 10] {
        let fit = cycle_less(|row, rate| if row % every == 0 { 0.0 } else { rate });
        let filled = told(&fit, ReasonKind::MissingValues);
        let zeros = format!("is exactly 0 in {} rows", 7200 / every - 1);
        assert!(filled.iter().any(|text| text.contains(&zeros)), "{filled:?}");
        let drift = fit.axes[0].calibration.measured_drift().peak_to_peak();
        assert!((drift - 0.28).abs() < 0.005, "{every}: {drift}");
    }
    assert!(told(&cycle_less(|_, rate| rate), ReasonKind::MissingValues).is_empty());
}

/// The drift goes over two steps and a half, over one and a half, and over a third of one, where it may be dead as well.
#[test]
fn steps_larger_than_the_noise_are_told_of_any_drift() {
    for (step, size) in [(0.12, 120), (0.2, 200), (0.9, 900)] {
        let fit = cycle_less(|_, rate| ((rate - 0.025).clamp(0.26, 0.58) / step).round() * step);
        let coarse = told(&fit, ReasonKind::CoarseRate);
        let stuck = told(&fit, ReasonKind::StuckReading);
        let said = coarse.iter().any(|text| text.contains(&format!("steps of {size} mrad/s")));
        assert!(said || !stuck.is_empty(), "{step}: {coarse:?} {stuck:?}");
    }
}

#[test]
fn a_temperature_that_jumps_is_told_where_it_does() {
    let at = |row: usize| f64::from(u32::try_from(row).unwrap());
    // Near the start, the middle and the end of an average's rows, and between two.
    for jump in [2487, 2500, 3000, 3333, 4001] {
        let mut noise = noise(7);
        let temperature: Vec<f64> =
            (0..7200).map(|row| -10.0 + 0.01 * at(row) + if row >= jump { 5.0 } else { 0.0 }).collect();
        let rates: Vec<f64> = temperature.iter().map(|t| 1e-5 * t + 1e-3 * noise()).collect();
        let fit = fit(&temperature, &[rates.clone(), rates], &FitOptions::default());
        let reason = fit.judgement.reasons.iter().find(|reason| reason.kind == ReasonKind::TemperatureJump).unwrap();
        let (_, rows) = reason.text.split_once("(rows ").unwrap();
        let numbers: Vec<usize> = rows.split([' ', ',']).filter_map(|word| word.parse().ok()).collect();
        let [from, to] = numbers[..2] else { panic!("{}", reason.text) };
        assert!(from <= jump && jump <= to && to - from < 60, "{jump}: {}", reason.text);
        let (_, temperatures) = rows.split_once(", ").unwrap();
        let ends: Vec<f64> = temperatures.split([' ', ')']).filter_map(|word| word.parse().ok()).collect();
        assert!(ends[1] - ends[0] > 4.9, "{jump}: {}", reason.text);
    }
}
