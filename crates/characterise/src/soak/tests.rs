use zerorate_cal::units::TemperatureUnit;

use super::*;
use crate::tests::normal;

/// A log at 10 Hz: a ramp of 200 s, a soak of 400 s, a ramp again; white noise of 0.01 a sample.
fn log(drift: f64) -> Source {
    let mut text = "time_s,temperature_c,gyro_x_rad_s\n".to_owned();
    let mut n: u64 = 42;
    for row in 0..8000_i32 {
        n = 16_807 * n % 2_147_483_647;
        let noise = 0.01 * (n as f64 / 2_147_483_647.0 - 0.5) * 12.0_f64.sqrt();
        let temperature = match row {
            0..2000 => f64::from(row) * 0.01,
            2000..6000 => 20.0,
            _ => 20.0 + f64::from(row - 6000) * 0.01,
        };
        text += &format!("{},{temperature},{}\n", f64::from(row) / 10.0, drift * temperature + noise);
    }
    Source::bytes("log.csv", text.into_bytes())
}

#[test]
fn the_longest_soak_of_a_log_tells_its_noise() {
    let found = noise(&log(0.05), &Columns::default(), None, None).unwrap().remove(0);
    assert_eq!(found.of, NoiseOf::Soak);
    // The soak, and what of the ramps is within a degree of it.
    assert!(found.time_s[0] > 180.0 && found.time_s[1] < 620.0, "{found:?}");
    let allan = found.noise.unwrap();
    assert!((allan.period_s - 0.1).abs() < 1e-6);
    // 0.01 a sample at 10 Hz.
    let n = allan.coefficients.angle_random_walk.value().unwrap();
    assert!((n / (0.01 * 0.1_f64.sqrt()) - 1.0).abs() < 0.05, "{n}");
}

#[test]
fn a_ramp_is_refused_with_what_to_do_and_its_residual_is_not() {
    let rows: String = (0..4000)
        .map(|row| format!("{},{},{}\n", f64::from(row) / 10.0, f64::from(row) * 0.01, f64::from(row * 7 % 13)))
        .collect();
    let ramp = Source::bytes("ramp.csv", format!("time_s,temperature_c,gyro_x_rad_s\n{rows}").into_bytes());
    let found = noise(&ramp, &Columns::default(), None, None).unwrap().remove(0);
    let refused = found.noise.unwrap_err();
    assert!(refused.contains("the temperature goes from") && refused.contains("take a soak"), "{refused}");
}

#[test]
fn a_slow_ramp_is_no_soak_and_neither_is_the_place_where_it_turns_round() {
    // 40 C in two hours: 180 s a degree.
    let up = |row: i32| 5.0 + f64::from(row) * 40.0 / 7200.0;
    let ramp = |turns: bool| {
        let temperature = |row: i32| if turns { up(row.min(7200 - row)) } else { up(row) };
        let rows: String = (0..7200)
            .map(|row| format!("{row},{},{}\n", temperature(row), f64::from(row * 7 % 13) + temperature(row)))
            .collect();
        Source::bytes("ramp.csv", format!("time_s,temperature_c,gyro_x_rad_s\n{rows}").into_bytes())
    };
    for turns in [false, true] {
        let found = noise(&ramp(turns), &Columns::default(), None, None).unwrap().remove(0);
        assert!(found.noise.is_err_and(|why| why.contains("take a soak")), "turns: {turns}");
    }
}

#[test]
fn with_a_calibration_the_whole_logs_residual_is_taken() {
    // 40 mrad/s in all: as much as parts drift, and no more than conditioning takes for drift.
    let log = log(0.002);
    let fit =
        zerorate_cal::fit::fit(std::slice::from_ref(&log), &zerorate_cal::log_fit::FitOptions::default()).unwrap();
    let calibration = fit.to_calibration(Vec::new(), None).unwrap();
    let found = noise(&log, &Columns::default(), None, Some(&calibration)).unwrap().remove(0);
    assert_eq!(found.of, NoiseOf::Residual);
    let n = found.noise.unwrap().coefficients.angle_random_walk.value().unwrap();
    assert!((n / (0.01 * 0.1_f64.sqrt()) - 1.0).abs() < 0.05, "{n}");
    // Over counts a curve in degrees is held at its end: that is no residual.
    let over_counts = Calibration { temperature_unit: TemperatureUnit::Counts, ..calibration };
    let refused = noise(&log, &Columns::default(), None, Some(&over_counts)).unwrap().remove(0).noise.unwrap_err();
    assert!(refused.contains("temperatures are in C, and the calibration's in counts"), "{refused}");
}

#[test]
fn a_long_log_is_averaged_until_it_fits_and_a_gap_stays_one() {
    let rows = 300_000;
    // A gap has 10 000 rows at most, and however long it is, rows are as far apart as they are.
    for (gap_s, placed) in [(50.0, 5000), (1500.0, 10_000)] {
        let stream = Stream {
            sensor: None,
            names: vec!["x".to_owned()],
            unit: RateUnit::RadPerS,
            temperature_unit: TemperatureUnit::C,
        };
        let time: Vec<f64> = (0..rows).map(|i| f64::from(i) * 0.01 + if i >= 200_000 { gap_s } else { 0.0 }).collect();
        let mut pace = Spacing::default();
        time.iter().for_each(|time| pace.push(*time));
        let mut series = Series::new(stream, &pace);
        let values: Vec<f64> = (0..rows).map(|i| f64::from(i % 2)).collect();
        series.push(&Rows {
            sensor: 0,
            part: 0,
            first_row: 0,
            time_s: &time,
            temperature: &vec![25.0; time.len()],
            values: &[values],
        });
        series.flush();
        assert!(series.bins.len() < MOST && series.a_bin == 4, "{} {}", series.bins.len(), series.a_bin);
        let gap = series.bins.iter().filter(|bin| bin.values[0].is_nan()).count();
        assert!(gap.abs_diff(placed / 4) < 5, "{gap}");
        assert!((series.period_s() / 0.04 - 1.0).abs() < 1e-4, "{} s after a gap of {gap_s} s", series.period_s());
        let allan = Allan::of(&series.values(0), series.period_s());
        // Of four rows of 0, 1, 0, 1 the mean is always a half.
        assert_eq!(allan, Err(NoAllan::Constant));
    }
}

/// A log at 10 Hz of N = 0.005, made of the time: a temperature and the part of the rate that is no noise.
fn made(seed: u64, seconds: u32, of: impl Fn(f64) -> (f64, f64)) -> String {
    let mut state = seed;
    let mut text = "time_s,temperature_c,gyro_x_dps\n".to_owned();
    for row in 0..10 * seconds {
        let time_s = f64::from(row) / 10.0;
        let (temperature, rate) = of(time_s);
        let temperature = temperature + 0.02 * normal(&mut state);
        text += &format!("{time_s},{temperature:.2},{:.6}\n", rate + 0.005 * 10.0_f64.sqrt() * normal(&mut state));
    }
    text
}

fn found(text: String) -> AxisNoise {
    let log = Source::bytes("log.csv", text.into_bytes());
    noise(&log, &Columns::default(), None, None).unwrap().remove(0)
}

/// Of noise of one, in steps of a fifth and of four.
#[test]
fn steps_as_large_as_the_noise_are_told() {
    let told = |step: f64| {
        let mut state = 5;
        let row = |row: u32| format!("{},25,{}\n", 0.1 * f64::from(row), (normal(&mut state) / step).round() * step);
        let rows: String = (0..36_000).map(row).collect();
        crate::coarse(&[found(format!("time_s,temperature_c,x_rad_s\n{rows}"))])
    };
    assert_eq!(told(0.2), Vec::<String>::new());
    assert!(
        told(4.0)[0].starts_with("x_rad_s: the rate comes in steps of 4.000 rad/s, as large as its noise"),
        "{:?}",
        told(4.0)
    );
}

/// White noise of a known N, at 10 Hz: rows are lost singly, for a second and for 15, and times stand in whole seconds.
#[test]
fn lost_rows_and_coarse_times_leave_n_as_it_was() {
    let truth = 0.1_f64.sqrt();
    let of = |shown: &dyn Fn(u32, f64) -> Option<f64>| {
        let mut state = 5;
        let mut text = "time_s,temperature_c,x_rad_s\n".to_owned();
        for row in 0..36_000_u32 {
            let noise = normal(&mut state);
            if let Some(time_s) = shown(row, normal(&mut 0x5DEE_CE66_u64.wrapping_mul(u64::from(row) + 1))) {
                text += &format!("{time_s},25,{noise}\n");
            }
        }
        found(text).noise.unwrap().coefficients.angle_random_walk.value().map(|n| n / truth)
    };
    let time = |row: u32| 0.1 * f64::from(row);
    type Shown<'a> = &'a dyn Fn(u32, f64) -> Option<f64>;
    let shown: [(&str, Shown); 6] = [
        ("whole", &|row, _| Some(time(row))),
        ("a third lost singly", &|row, draw| (draw > -0.43).then_some(time(row))),
        ("a tenth lost singly", &|row, draw| (draw > -1.28).then_some(time(row))),
        ("a second of four", &|row, _| (row % 40 < 30).then_some(time(row))),
        ("15 s of 60", &|row, _| (row % 600 < 450).then_some(time(row))),
        ("in whole seconds", &|row, _| Some(f64::from(row / 10))),
    ];
    for (what, shown) in shown {
        let ratio = of(shown);
        assert!(ratio.is_some_and(|ratio| (ratio - 1.0).abs() < 0.03), "{what}: {ratio:?}");
    }
}

#[test]
fn spikes_are_left_out_counted_and_leave_n_as_it_was() {
    for seed in [11, 222, 3333] {
        let clean = made(seed, 3600, |_| (25.0, 0.1));
        let mut lines: Vec<String> = clean.lines().map(str::to_owned).collect();
        // Each 1000th row of the 36 000, and the first.
        let places: Vec<usize> = (0..36).map(|spike| 1 + 1000 * spike).collect();
        for place in &places {
            let (before, rate) = lines[*place].rsplit_once(',').unwrap();
            lines[*place] = format!("{before},{}", rate.parse::<f64>().unwrap() + 50.0);
        }
        let (clean, spiked) = (found(clean), found(lines.join("\n") + "\n"));
        assert_eq!((clean.left_out, spiked.left_out), (0, 36), "seed {seed}");
        let n = |found: &AxisNoise| found.noise.as_ref().unwrap().coefficients.angle_random_walk.value().unwrap();
        assert!((n(&spiked) / n(&clean) - 1.0).abs() < 0.002, "{} and {}", n(&spiked), n(&clean));
        // Of 36 000 samples it is known to 0.45 %.
        assert!((n(&spiked) / 0.005 - 1.0).abs() < 0.018, "{}", n(&spiked));
        // A spike is no gap: averages reach over it.
        assert_eq!(spiked.noise.unwrap().points.len(), clean.noise.unwrap().points.len());
    }
}

#[test]
fn a_soak_begins_where_the_temperature_has_settled_and_ends_before_the_ramp() {
    // At 0.6 C a minute a degree of a ramp is 100 s.
    let soak = |t: f64| 20.0 + 0.01 * (t - 900.0).max(0.0) - 0.01 * (300.0 - t).max(0.0);
    let found = found(made(5, 1600, |t| (soak(t), 0.02 * soak(t))));
    assert!(found.time_s[0] > 285.0 && found.time_s[1] < 915.0, "{found:?}");
    assert!(found.time_s[1] - found.time_s[0] > 550.0, "{found:?}");
}

/// A warm-up of 0.1 dps, a drift of 0.02 dps a degree that follows its temperature two minutes late: no walk, no flicker.
#[test]
fn a_warm_up_is_no_walk_whatever_is_left_of_it_in_the_soak() {
    for seed in [7, 70, 700, 7000] {
        let warm = made(seed, 7200, |t| (25.0 + 3.0 * (1.0 - (-t / 900.0).exp()), 0.1 * (-t / 1200.0).exp()));
        let late = made(seed + 1, 3600, |t| {
            // On a ramp of 1.5 C a minute two minutes late are 3 C.
            let late = 3.0 * (-(t - 1800.0).max(0.0) / 120.0).exp();
            (70.0 - 0.025 * (1800.0 - t).max(0.0), 0.02 * (-0.025 * (1800.0 - t).max(0.0) - late))
        });
        for text in [warm, late] {
            let found = found(text);
            let allan = found.noise.as_ref().unwrap();
            assert_eq!(allan.coefficients.rate_random_walk.value(), None, "seed {seed}: {found:?}");
            assert_eq!(allan.coefficients.bias_instability.value(), None, "seed {seed}: {found:?}");
            let n = allan.coefficients.angle_random_walk.value().unwrap();
            assert!((n / 0.005 - 1.0).abs() < 0.03, "seed {seed}: {n}");
        }
    }
}
