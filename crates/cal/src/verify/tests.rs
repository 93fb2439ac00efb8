use super::*;
use crate::calibration::Origin;
use crate::units::WrittenRate;

/// A log of a parabola with a second-run offset, noise by `seed`, and a sine of size `extra`.
fn log(seed: i32, offset: f64, extra: f64) -> String {
    let mut text = "time_s,temperature_c,gyro_x_rad_s,gyro_y_rad_s\n".to_owned();
    for row in 0..4000_i32 {
        let t = -10.0 + 60.0 * f64::from(row) / 4000.0;
        let noise = (f64::from((row * seed) % 1000) - 499.5) * 1e-7;
        let x = offset + 1e-3 * t + 1e-5 * t * t + noise + extra * (t / 10.0).sin();
        text += &format!("{row},{t},{x},{}\n", 2e-4 * t + noise);
    }
    text
}

fn first() -> Source {
    Source::bytes("first.csv", log(617, 0.0, 0.0).into_bytes())
}

fn calibration() -> Calibration {
    let fitted = fit(&[first()], &FitOptions::default()).unwrap();
    fitted.to_calibration(vec![Origin::of("log", &first()).unwrap()], None).unwrap()
}

fn second(offset: f64, extra: f64, limits: &Limits, own: &Calibration) -> Result<Verified, VerifyError> {
    let log = Source::bytes("second.csv", log(733, offset, extra).into_bytes());
    verify(&log, own, &Columns::default(), limits, false)
}

fn limits(max_rms: &str, max_pp: &str) -> Limits {
    Limits::for_all(Some(max_rms.parse().unwrap()), Some(max_pp.parse().unwrap()), None)
}

#[test]
fn a_second_run_that_repeats_the_first_passes_and_its_new_zero_is_told_apart() {
    let verified = second(0.003, 0.0, &limits("0.02 mrad/s", "0.1mrad/s"), &calibration()).unwrap();
    assert!(verified.passed == Some(true) && !verified.in_sample, "{verified:?}");
    let x = &verified.axes[0];
    assert!((x.offset - 0.003).abs() < 1e-4, "{}", x.offset);
    assert!(x.raw.pp > 0.06 && x.corrected.pp < 1e-4, "{:?} {:?}", x.raw, x.corrected);
    assert!(x.outside <= 0.0);
}

#[test]
fn a_drift_that_has_changed_misses_its_limits_by_name() {
    let verified = second(0.0, 1e-3, &limits("0.1 mrad/s", "10 dps"), &calibration()).unwrap();
    assert_eq!(verified.passed, Some(false));
    assert_eq!(verified.axes[0].missed.len(), 1, "{:?}", verified.axes[0].missed);
    assert!(verified.axes[0].missed[0].starts_with("gyro_x_rad_s: rms "), "{:?}", verified.axes[0].missed);
    assert!(verified.axes[1].missed.is_empty());
    // The sine's own rms over what was recorded, less what a straight line takes of it.
    assert!((0.5e-3..0.8e-3).contains(&verified.axes[0].corrected.rms), "{}", verified.axes[0].corrected.rms);
}

#[test]
fn the_log_that_was_fitted_is_no_test() {
    let own = calibration();
    let refused = verify(&first(), &own, &Columns::default(), &Limits::default(), false).unwrap_err();
    assert!(refused.to_string().contains("fitted on this very log"), "{refused}");
    let looked = verify(&first(), &own, &Columns::default(), &Limits::default(), true).unwrap();
    assert!(looked.in_sample && looked.passed.is_none());
}

#[test]
fn an_axis_that_is_dead_or_missing_fails_with_limits_and_without() {
    let own = calibration();
    let text = log(733, 0.0, 0.0);
    let rows = text.lines().skip(1).map(|row| row.split(',').collect::<Vec<_>>());
    let [mut dead, mut missing] =
        ["time_s,temperature_c,gyro_x_rad_s,gyro_y_rad_s\n", "time_s,temperature_c,gyro_y_rad_s\n"].map(str::to_owned);
    for row in rows {
        dead += &format!("{},{},,{}\n", row[0], row[1], row[3]);
        missing += &format!("{},{},{}\n", row[0], row[1], row[3]);
    }
    for text in [dead, missing] {
        let log = Source::bytes("second.csv", text.into_bytes());
        for limits in [Limits::default(), limits("1 rad/s", "1 rad/s")] {
            let verified = verify(&log, &own, &Columns::default(), &limits, false).unwrap();
            assert_eq!((verified.passed, verified.missing.len(), verified.axes.len()), (Some(false), 1, 1));
            assert!(verified.missing[0].starts_with("gyro_x_rad_s: "), "{:?}", verified.missing);
        }
    }
}

#[test]
fn another_log_is_refused_with_what_it_has() {
    let own = calibration();
    let text = log(617, 0.0, 0.0);
    let refused = |text: String, columns: &Columns| {
        let other = Source::bytes("other.csv", text.into_bytes());
        verify(&other, &own, columns, &Limits::default(), false).unwrap_err().to_string()
    };
    let columns = Columns { rates: vec!["gyro_p".to_owned(), "gyro_q".to_owned()], ..Columns::default() };
    let named = refused(text.replace("gyro_x_rad_s,gyro_y_rad_s", "gyro_p,gyro_q"), &columns);
    assert!(named.contains("it has gyro_p, gyro_q, and the calibration is for gyro_x_rad_s"), "{named}");
    let columns = Columns { rate_unit: Some(WrittenRate::Dps), ..Columns::default() };
    let in_dps = refused(text + "4000,50.0,0.1,0.2\n", &columns);
    assert!(in_dps.contains("is in dps, and the calibration's in rad/s"), "{in_dps}");
}

#[test]
fn temperatures_outside_the_calibrated_range_are_counted_and_warned_of() {
    let mut own = calibration();
    let narrow = zerorate_core::drift::ValidRange::new(0.0, 40.0).unwrap();
    own.axes.values_mut().for_each(|axis| axis.fit.model.drift.valid = narrow);
    let verified = second(0.0, 0.0, &Limits::default(), &own).unwrap();
    assert!((verified.axes[0].outside - 1.0 / 3.0).abs() < 0.02, "{}", verified.axes[0].outside);
    assert!(verified.warnings.iter().any(|warning| warning.contains("outside the calibrated")));
}

#[test]
fn limits_are_read_with_their_units_and_per_axis() {
    let in_rad = |text: &str| text.parse::<Limit>().unwrap().in_unit("x", RateUnit::RadPerS).unwrap();
    assert!((in_rad("0.5mrad/s") - 5e-4).abs() < 1e-15);
    assert!((in_rad("3600 deg/h") - 1.0_f64.to_radians()).abs() < 1e-15);
    assert!((in_rad("1e-3dps") - 1e-3_f64.to_radians()).abs() < 1e-15);
    for wrong in ["0.5", "mrad/s", "-1 dps", "0 dps", "nan dps", "3 parsec/s", ""] {
        assert!(matches!(wrong.parse::<Limit>(), Err(LimitError::Unclear(_))), "{wrong}");
    }
    assert!("3 counts".parse::<Limit>().unwrap().in_unit("x", RateUnit::RadPerS).is_err());
    let limits: Limits =
        toml::from_str("max_rms = \"1 mrad/s\"\n[axes.gyro_x_rad_s]\nmax_rms = \"1 urad/s\"\n").unwrap();
    let verified = second(0.0, 0.0, &limits, &calibration()).unwrap();
    assert_eq!((verified.axes[0].missed.len(), verified.axes[1].missed.len()), (1, 0));
    assert!(limits.check(["gyro_x_rad_s"].into_iter()).is_ok() && limits.check(["y"].into_iter()).is_err());
    assert!(toml::from_str::<Limits>("max_rsm = \"1 dps\"").is_err());
}
