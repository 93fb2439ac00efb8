use super::*;
use zerorate_cal::fit::fit;
use zerorate_cal::log_fit::FitOptions;
use zerorate_cal::source::Source;

/// Two cycles between -10 and 50 C, the second three times as fast, as a log: a line of 1e-3 a degree, a play of 3 C by
/// which heating is `hysteresis` above cooling, `ramp` times the temperature's speed, a little noise.
fn cycle(hysteresis: f64, ramp: f64) -> Characteristics {
    let mut play = -13.0_f64;
    let rate = |row: i32, t: f64, speed: f64| {
        play = play.clamp(t - 3.0, t + 3.0);
        let noise = (f64::from((row * 617) % 1000) - 499.5) * 1e-7;
        1e-3 * t + hysteresis * (t - play) / 6.0 + ramp * speed + noise
    };
    two_cycles("poly:1", rate)
}

/// The two cycles, and a rate made of the row, the temperature and its speed.
fn two_cycles(model: &str, rate: impl FnMut(i32, f64, f64) -> f64) -> Characteristics {
    cycles(&[3000, 1000], model, rate)
}

/// Cycles between the same temperatures, each of so many seconds.
fn cycles(lasting_s: &[i32], model: &str, mut rate: impl FnMut(i32, f64, f64) -> f64) -> Characteristics {
    let mut text = "time_s,temperature_c,gyro_x_rad_s\n".to_owned();
    let rows = lasting_s.iter().flat_map(|lasts_s| (0..*lasts_s).map(move |second| (*lasts_s, second)));
    for (row, (lasts_s, second)) in (0..).zip(rows) {
        let turn = std::f64::consts::TAU / f64::from(lasts_s);
        let angle = turn * f64::from(second);
        let (t, speed) = (20.0 - 30.0 * angle.cos(), 30.0 * turn * angle.sin());
        text += &format!("{row},{t},{}\n", rate(row, t, speed));
    }
    let log = Source::bytes("cycle.csv", text.into_bytes());
    let fit = fit(&[log], &FitOptions { model: model.parse().unwrap(), ..FitOptions::default() }).unwrap();
    Characteristics::of(&fit.axes[0], None)
}

/// Normal noise of one: a sum of twelve (Irwin and Hall) of SplitMix64 (Steele, Lea and Flood, 2014).
pub(crate) fn normal(state: &mut u64) -> f64 {
    let draw = |state: &mut u64| {
        *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (*state ^ (*state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) as f64 / u64::MAX as f64
    };
    (0..12).map(|_| draw(state)).sum::<f64>() - 6.0
}

#[test]
fn a_straight_drift_has_its_slope_and_neither_hysteresis_nor_ramp_sensitivity() {
    let found = cycle(0.0, 0.0);
    assert!((found.temperature_sensitivity.mean / 1e-3 - 1.0).abs() < 0.01, "{found:?}");
    assert!((found.temperature_sensitivity.steepest / 1e-3 - 1.0).abs() < 0.01);
    assert!(found.hysteresis.unwrap_err().contains("differ nowhere by more than 4 standard errors"));
    assert!(found.ramp_sensitivity.unwrap().value.abs() < 1e-3);
}

/// By hand: of 4000 rows whose temperatures have a deviation of 30 / sqrt 2, and noise of 1e-3. And of a table on noise alone
/// neither slope is more than its error makes of it.
#[test]
fn a_slope_has_the_error_that_its_rows_give_it() {
    let mut state = 3;
    let found = two_cycles("poly:1", |_, t, _| 1e-3 * t + 1e-3 * normal(&mut state)).temperature_sensitivity;
    let by_hand = 1e-3 / (4000_f64.sqrt() * 30.0 / 2_f64.sqrt());
    for error in [found.mean_standard_error, found.steepest_standard_error] {
        assert!((error / by_hand - 1.0).abs() < 0.15, "{found:?}, not {by_hand}");
    }
    assert!((found.mean - 1e-3).abs() < 4.0 * by_hand, "{found:?}");
    let found = two_cycles("table:16", |_, _, _| 1e-3 * normal(&mut state)).temperature_sensitivity;
    assert!(found.mean.abs() < 4.0 * found.mean_standard_error, "{found:?}");
    assert!(found.steepest.abs() < 4.0 * found.steepest_standard_error, "{found:?}");
}

/// A table's slope is of a whole piece, and so is the place that is named: by the derivative of a cube there.
#[test]
fn the_steepest_slope_is_that_of_the_place_that_is_named() {
    let mut state = 11;
    let found = two_cycles("auto", |_, t, _| 1e-6 * (t - 20.0).powi(3) + 1e-4 * normal(&mut state));
    let found = found.temperature_sensitivity;
    let truth = 3e-6 * (found.steepest_at - 20.0).powi(2);
    assert!((found.steepest / truth - 1.0).abs() < 0.02, "{found:?}, not {truth}");
}

#[test]
fn hysteresis_is_heating_less_cooling() {
    let found = cycle(0.01, 0.0).hysteresis.unwrap();
    assert!((0.008..0.0105).contains(&found.rms) && found.largest > 0.0, "{found:?}");
    assert!((found.share - 0.01 / 0.06).abs() < 0.06, "{found:?}");
}

#[test]
fn noise_alone_is_no_hysteresis_and_neither_is_a_drift_in_time() {
    let mut state = 7;
    let found = two_cycles("poly:1", |_, _, _| 1e-3 * normal(&mut state)).hysteresis.unwrap_err();
    assert!(found.contains("differ nowhere by more than 4 standard errors"), "{found}");
    // Over a log of 4000 s it drifts by ten times the noise of an average of 21 rows: what is recorded differs, by what a rate
    // that goes its own way in time does.
    let drift = |row, _, _| 5e-7 * f64::from(row) + 1e-3 * normal(&mut state);
    let found = two_cycles("auto", drift).hysteresis.unwrap_err();
    assert!(found.contains("may as well be wandering in time"), "{found}");
}

#[test]
fn a_jump_from_one_log_to_the_next_is_no_hysteresis_and_no_noise() {
    let log = |name: &str, from_s: i32, level: f64, state: &mut u64| {
        let mut text = "time_s,temperature_c,gyro_x_rad_s\n".to_owned();
        for row in 0..3000 {
            // The second goes round the other way, and turns elsewhere.
            let angle = std::f64::consts::TAU * f64::from(row) / 3000.0 + level * 100.0;
            let t = 20.0 - 30.0 * angle.cos();
            text += &format!("{},{t},{}\n", from_s + row, level + 1e-3 * t + 1e-5 * normal(state));
        }
        Source::bytes(name, text.into_bytes())
    };
    let mut state = 5;
    let logs = [log("a.csv", 0, 0.0, &mut state), log("b.csv", 10_000, 0.02, &mut state)];
    let fit = fit(&logs, &FitOptions::default()).unwrap();
    let found = Characteristics::of(&fit.axes[0], None);
    assert!(found.hysteresis.as_ref().is_err_and(|why| why.contains("differ nowhere")), "{:?}", found.hysteresis);
    let noise = found.residual_noise.unwrap();
    // An average of 21 rows of 1e-5.
    assert!(noise.points[0].deviation < 4e-6, "{:?}", noise.points[0]);
    // What the curve misses, and a thousandth of the jump.
    assert!(noise.points.iter().all(|point| point.deviation < 3e-5), "{noise:?}");
}

#[test]
fn the_largest_difference_is_known_as_well_as_the_averages_of_two_bins() {
    // An average of 21 rows of 1e-4 is known to 2.2e-5; a bin of either direction holds two or three of them, more where the
    // temperature turns: two bins differ by 1e-5 to 2.5e-5 by chance.
    let (mut state, mut play) = (3, -13.0_f64);
    let rate = |_, t: f64, _| {
        play = play.clamp(t - 3.0, t + 3.0);
        1e-3 * t + 0.01 * (t - play) / 6.0 + 1e-4 * normal(&mut state)
    };
    let found = two_cycles("poly:1", rate).hysteresis.unwrap();
    // And by a walk that the noise would hide.
    assert!((1e-5..2e-4).contains(&found.standard_error), "{found:?}");
    assert!((found.largest - 0.01).abs() < 5e-4, "{found:?}");
    // At the turns the play has not yet turned.
    assert!(found.mean_standard_error < 1e-4, "{found:?}");
    assert!((0.008..0.0101).contains(&found.mean), "{found:?}");
}

#[test]
fn a_small_hysteresis_everywhere_is_found_with_its_size() {
    let mut state = 11;
    let mut play = -13.0_f64;
    let found = two_cycles("poly:1", |_, t, _| {
        play = play.clamp(t - 3.0, t + 3.0);
        1e-3 * t + 2.5e-3 * (t - play) / 6.0 + 2e-3 * normal(&mut state)
    });
    let found = found.hysteresis.unwrap();
    assert!((found.mean - 2.4e-3).abs() < 3.5 * found.mean_standard_error, "{found:?}");
    assert!((found.rms - 2.4e-3).abs() < 4e-4, "less what noise makes: {found:?}");
}

#[test]
fn a_rate_that_goes_with_the_temperatures_speed_is_told_whatever_the_model_makes_of_it() {
    let mut state = 13;
    let found = two_cycles("auto", |_, t, speed| 1e-3 * t + 0.05 * speed + 1e-4 * normal(&mut state)).ramp_sensitivity;
    let found = found.unwrap();
    assert!((found.value / 0.05 - 1.0).abs() < 0.1, "{found:?}");
}

#[test]
fn a_span_of_a_fraction_of_a_degree_tells_no_hysteresis() {
    let mut text = "time_s,temperature_c,gyro_x_rad_s\n".to_owned();
    for row in 0..4000_i32 {
        let t = 25.0 - 0.1 * (std::f64::consts::TAU * f64::from(row) / 1000.0).cos();
        text += &format!("{row},{t},{}\n", f64::from((row * 617) % 1000) * 1e-7);
    }
    let options = FitOptions { allow_narrow: true, ..FitOptions::default() };
    let fit = fit(&[Source::bytes("soak.csv", text.into_bytes())], &options).unwrap();
    let found = Characteristics::of(&fit.axes[0], None).hysteresis.unwrap_err();
    assert!(found.contains("spans 0.2 C, too little"), "{found}");
}

#[test]
fn ramp_sensitivity_is_told_from_hysteresis_by_the_speeds_within_a_direction() {
    let found = cycle(0.005, 0.2).ramp_sensitivity.unwrap();
    assert!((found.value / 0.2 - 1.0).abs() < 0.15, "{found:?}");
    // The fast cycle is a quarter of the log: without half of it much less is known.
    assert!(found.standard_error > 0.0 && found.standard_error < 0.3, "{found:?}");
}

/// Three equal cycles of a unit with a play and nothing that goes with the speed: at each temperature there is one speed a direction.
#[test]
fn of_equal_cycles_no_ramp_sensitivity_is_told() {
    let mut play = -13.0_f64;
    let found = cycles(&[2000; 3], "poly:1", |row, t, _| {
        play = play.clamp(t - 12.0, t + 12.0);
        let noise = (f64::from((row * 617) % 1000) - 499.5) * 1e-7;
        1e-3 * t + 0.005 * (t - play) / 24.0 + noise
    });
    let found = found.ramp_sensitivity;
    assert!(found.as_ref().is_err_and(|why| why.contains("fast and slowly")), "{found:?}");
}

#[test]
fn what_a_log_does_not_hold_is_refused_with_what_to_do() {
    let mut text = "time_s,temperature_c,gyro_x_rad_s\n".to_owned();
    for row in 0..2000_i32 {
        text += &format!("{row},{},{}\n", 0.02 * f64::from(row), f64::from((row * 617) % 1000) * 1e-7);
    }
    let fit = fit(&[Source::bytes("ramp.csv", text.into_bytes())], &FitOptions::default()).unwrap();
    let found = Characteristics::of(&fit.axes[0], None);
    assert!(found.hysteresis.unwrap_err().contains("let it warm and cool"));
    assert!(found.ramp_sensitivity.unwrap_err().contains("fast and slowly"));
    let noise = found.residual_noise.unwrap();
    assert!(noise.period_s > 5.0 && noise.points.len() > 5, "{noise:?}");
}

fn wandering(seed: u64, cycles: u32, walk: f64, hysteresis: f64) -> Characteristics {
    wandering_with_play(seed, cycles, walk, hysteresis, 3.0)
}

/// One cycle of an hour, or several, of 30 C to either side of 20, at 1 Hz: a line, a walk, a play of so many C to either side, a
/// little noise.
fn wandering_with_play(seed: u64, cycles: u32, walk: f64, hysteresis: f64, half: f64) -> Characteristics {
    let (mut state, mut bias, mut play) = (seed, 0.0, -10.0 - half);
    let mut text = "time_s,temperature_c,gyro_x_rad_s\n".to_owned();
    for row in 0..3600 * cycles {
        let t = 20.0 - 30.0 * (std::f64::consts::TAU * f64::from(row) / 3600.0).cos();
        play = play.clamp(t - half, t + half);
        bias += walk * normal(&mut state);
        let rate = 1e-3 * t + bias + hysteresis * (t - play) / (2.0 * half) + 1e-4 * normal(&mut state);
        text += &format!("{row},{t},{rate}\n");
    }
    let options = FitOptions { model: "poly:3".parse().unwrap(), ..FitOptions::default() };
    let fit = fit(&[Source::bytes("log.csv", text.into_bytes())], &options).unwrap();
    Characteristics::of(&fit.axes[0], None)
}

#[test]
fn a_rate_that_wanders_has_no_hysteresis() {
    let mut told = 0;
    for seed in 1..=40 {
        // After an hour a walk of 1e-5 has gone by 6e-4; noise alone would tell the mean to 3e-6.
        match wandering(seed * 977, 1, 1e-5, 0.0).hysteresis {
            Ok(found) => {
                told += 1;
                assert!(found.one_cycle && found.mean.abs() < 4.0 * found.mean_standard_error, "{found:?}");
            }
            Err(why) => assert!(why.contains("may as well be wandering in time"), "{why}"),
        }
    }
    // One in a hundred is expected; of 40 three or more are then one test in a hundred.
    assert!(told <= 2, "{told} of 40");
}

/// A play turns round over its width at each turn of the temperature, and does so in each cycle again: cycles tell it from wandering.
#[test]
fn cycles_that_repeat_a_wide_hysteresis_tell_its_mean_closely() {
    for seed in 1..=5 {
        let found = wandering_with_play(seed * 311, 4, 1e-6, 2e-2, 10.0).hysteresis.unwrap();
        // Two turns of 20 C in 60, and the first pass begins turned round: 2/3 and 1/24 of the whole.
        let error = found.mean - 2e-2 * (2.0 / 3.0 + 1.0 / 24.0);
        assert!(error.abs() < 3.0 * found.mean_standard_error && found.mean_standard_error < 2e-4, "{found:?}");
    }
}

#[test]
fn wandering_over_several_cycles_is_no_hysteresis() {
    let mut told = 0;
    for seed in 1..=40 {
        if let Ok(found) = wandering(seed * 1409, if seed % 2 == 0 { 2 } else { 4 }, 1e-5, 0.0).hysteresis {
            told += 1;
            assert!(found.mean.abs() < 4.0 * found.mean_standard_error, "{found:?}");
        }
    }
    assert!(told <= 2, "{told} of 40");
}

#[test]
fn a_hysteresis_above_the_wandering_is_told_with_the_wandering_in_its_error() {
    let (mut held, mut held_largest, mut errors) = (0, 0, (0.0, 0.0));
    for seed in 1..=20 {
        let found = wandering(seed * 617, 1, 1e-5, 5e-3).hysteresis.unwrap();
        assert!(found.one_cycle && found.mean_standard_error > 5e-5, "{found:?}");
        // Between the turns the play is wholly through.
        held_largest += usize::from((found.largest - 5e-3).abs() < 2.0 * found.standard_error);
        errors = (errors.0 + found.standard_error, errors.1 + found.mean_standard_error);
        // A cycle that has not begun to heat within the play has less of it at the cold turn.
        held += usize::from((found.mean - 4.75e-3).abs() < 2.0 * found.mean_standard_error);
        assert!(!wandering(seed * 617, 3, 1e-5, 5e-3).hysteresis.unwrap().one_cycle);
    }
    assert!(held >= 17 && held_largest >= 17, "{held} and {held_largest} of 20");
    // All temperatures wander together: the largest is known no better than the mean that it is drawn to.
    assert!(errors.0 > 0.95 * errors.1, "{errors:?}");
}
