use super::*;
use zerorate_cal::fit::fit;
use zerorate_cal::log_fit::FitOptions;
use zerorate_cal::source::Source;

/// Two cycles between -10 and 50 C, the second three times as fast, as a log: a line of 1e-3 a degree, a play of 3 C by
/// which heating is `hysteresis` above cooling, `ramp` times the temperature's speed, a little noise.
fn cycle(hysteresis: f64, ramp: f64) -> Characteristics {
    let mut text = "time_s,temperature_c,gyro_x_rad_s\n".to_owned();
    let mut play = -13.0_f64;
    for row in 0..4000_i32 {
        let turn = std::f64::consts::TAU / if row < 3000 { 3000.0 } else { 1000.0 };
        let angle = turn * f64::from(if row < 3000 { row } else { row - 3000 });
        let (t, speed) = (20.0 - 30.0 * angle.cos(), 30.0 * turn * angle.sin());
        play = play.clamp(t - 3.0, t + 3.0);
        let noise = (f64::from((row * 617) % 1000) - 499.5) * 1e-7;
        let rate = 1e-3 * t + hysteresis * (t - play) / 6.0 + ramp * speed + noise;
        text += &format!("{row},{t},{rate}\n");
    }
    let log = Source::bytes("cycle.csv", text.into_bytes());
    let fit = fit(&[log], &FitOptions { model: "poly:1".parse().unwrap(), ..FitOptions::default() }).unwrap();
    Characteristics::of(&fit.axes[0])
}

#[test]
fn a_straight_drift_has_its_slope_and_neither_hysteresis_nor_ramp_sensitivity() {
    let found = cycle(0.0, 0.0);
    assert!((found.temperature_sensitivity.mean / 1e-3 - 1.0).abs() < 0.01, "{found:?}");
    assert!((found.temperature_sensitivity.steepest / 1e-3 - 1.0).abs() < 0.01);
    // Averages of a bin are of different temperatures within it: a bin is 1.5 C wide.
    assert!(found.hysteresis.unwrap().largest.abs() < 1e-3);
    assert!(found.ramp_sensitivity.unwrap().value.abs() < 1e-3);
}

#[test]
fn hysteresis_is_heating_less_cooling() {
    let found = cycle(0.01, 0.0).hysteresis.unwrap();
    assert!((0.008..0.0105).contains(&found.rms) && found.largest > 0.0, "{found:?}");
    assert!((found.share - 0.01 / 0.06).abs() < 0.06, "{found:?}");
}

#[test]
fn ramp_sensitivity_is_told_from_hysteresis_by_the_speeds_within_a_direction() {
    let found = cycle(0.005, 0.2).ramp_sensitivity.unwrap();
    assert!((found.value / 0.2 - 1.0).abs() < 0.15, "{found:?}");
    // The fast cycle is a quarter of the log: without half of it much less is known.
    assert!(found.standard_error > 0.0 && found.standard_error < 0.3, "{found:?}");
}

#[test]
fn what_a_log_does_not_hold_is_refused_with_what_to_do() {
    let mut text = "time_s,temperature_c,gyro_x_rad_s\n".to_owned();
    for row in 0..2000_i32 {
        text += &format!("{row},{},{}\n", 0.02 * f64::from(row), f64::from((row * 617) % 1000) * 1e-7);
    }
    let fit = fit(&[Source::bytes("ramp.csv", text.into_bytes())], &FitOptions::default()).unwrap();
    let found = Characteristics::of(&fit.axes[0]);
    assert!(found.hysteresis.unwrap_err().contains("let it warm and cool"));
    assert!(found.ramp_sensitivity.unwrap_err().contains("fast and slowly"));
    let noise = found.residual_noise.unwrap();
    assert!(noise.period_s > 5.0 && noise.points.len() > 5, "{noise:?}");
}
