use zerorate_core::drift::{Drift, History, Memory, Polynomial, Scale, Shape, Term, ValidRange};

use super::*;
use zerorate_cal::calibration::{AxisCalibration, Origin};
use zerorate_cal::log::{Sensor, SensorKind};
use zerorate_cal::quality::ReasonKind;
use zerorate_cal::units::{RateUnit, WrittenRate, WrittenTemperature};

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
    let origin = Origin { rows: fitted.sources[0].rows.written(), ..Origin::of("log", &first()).unwrap() };
    fitted.to_calibration(vec![origin], None).unwrap()
}

fn second(offset: f64, extra: f64, limits: &Limits, own: &Calibration) -> Result<Verified, VerifyError> {
    let log = Source::bytes("second.csv", log(733, offset, extra).into_bytes());
    verify(&log, own, &VerifyOptions { limits: limits.clone(), ..VerifyOptions::default() })
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
    // The fit's groups are longer, and end a little before the log does.
    assert!(x.outside < 0.01 && verified.reasons.is_empty(), "{verified:?}");
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
    let refused = verify(&first(), &own, &VerifyOptions::default()).unwrap_err();
    assert!(refused.to_string().contains("fitted on this very log"), "{refused}");
    // Its rows are known in whatever form: packed, with another header, a part of it.
    let rows = |log: &str, from: usize| {
        let body: String = log.lines().skip(from).map(|line| format!("{line}\n")).collect();
        let text = format!("t_s,temp_c,gyro_x_rad_s,gyro_y_rad_s\n{body}");
        verify(&Source::bytes("copy.csv", text.into_bytes()), &own, &VerifyOptions::default())
    };
    for from in [1, 2000] {
        let refused = rows(&log(617, 0.0, 0.0), from).unwrap_err();
        assert!(refused.to_string().contains("on rows of it or on a copy"), "{refused}");
    }
    let thinned = log(617, 0.0, 0.0).lines().step_by(2).map(|line| format!("{line}\n")).collect::<String>();
    let refused = rows(&thinned, 1).unwrap_err();
    assert!(refused.to_string().contains("on rows of it or on a copy"), "{refused}");
    assert!(rows(&log(733, 0.0, 0.0), 1).is_ok());
    let looked = verify(&first(), &own, &VerifyOptions { in_sample: true, ..VerifyOptions::default() }).unwrap();
    assert!(looked.in_sample && looked.passed.is_none());
}

#[test]
fn an_axis_that_is_dead_or_missing_fails_with_limits_and_without() {
    let own = calibration();
    let text = log(733, 0.0, 0.0);
    let rows = text.lines().skip(1).map(|row| row.split(',').collect::<Vec<_>>());
    let header = "time_s,temperature_c,gyro_x_rad_s,gyro_y_rad_s\n";
    let [mut dead, mut stuck, mut stops, mut missing] =
        [header, header, header, "time_s,temperature_c,gyro_y_rad_s\n"].map(str::to_owned);
    for (place, row) in rows.enumerate() {
        dead += &format!("{},{},,{}\n", row[0], row[1], row[3]);
        stuck += &format!("{},{},0,{}\n", row[0], row[1], row[3]);
        stops += &format!("{},{},{},{}\n", row[0], row[1], if place < 2000 { row[2] } else { "0.01" }, row[3]);
        missing += &format!("{},{},{}\n", row[0], row[1], row[3]);
    }
    for text in [dead, stuck, stops, missing] {
        let log = Source::bytes("second.csv", text.into_bytes());
        for limits in [Limits::default(), limits("1 rad/s", "1 rad/s")] {
            let verified = verify(&log, &own, &VerifyOptions { limits, ..VerifyOptions::default() }).unwrap();
            assert_eq!((verified.passed, verified.missing.len(), verified.axes.len()), (Some(false), 1, 1));
            assert!(verified.missing[0].starts_with("gyro_x_rad_s: "), "{:?}", verified.missing);
        }
    }
}

/// Its other axis is known for the very noise, and the log for no test; what is lost is lost.
#[test]
fn an_axis_that_was_lost_fails_by_the_own_log_too() {
    let mut state = 1_u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) * 1e-11
    };
    let rows: Vec<[f64; 2]> = (0..4000).map(|row| [1e-6 * f64::from(row) + noise(), noise()]).collect();
    let table = |x: &dyn Fn(f64) -> String| {
        let row = |(place, [own, y]): (usize, &[f64; 2])| format!("{place},{},{},{y}\n", 0.01 * place as f64, x(*own));
        let rows: String = rows.iter().enumerate().map(row).collect();
        let text = format!("time_s,temperature_c,gyro_x_rad_s,gyro_y_rad_s\n{rows}");
        Source::bytes("log.csv", text.into_bytes())
    };
    let (whole, dead) = (table(&|x| x.to_string()), table(&|_| String::new()));
    let fitted = fit(std::slice::from_ref(&whole), &FitOptions::default()).unwrap();
    let origin = Origin { rows: fitted.sources[0].rows.written(), ..Origin::of("log", &whole).unwrap() };
    let own = fitted.to_calibration(vec![origin], None).unwrap();
    let verified = verify(&dead, &own, &VerifyOptions::default()).unwrap();
    assert!(verified.in_sample && verified.passed == Some(false) && verified.missing.len() == 1, "{verified:?}");
}

#[test]
fn gyros_alone_are_verified_where_that_is_said_and_else_it_is_said_how() {
    let mut own = calibration();
    let sensor = |kind| Some(Sensor { kind, instance: 0, device_id: None });
    own.axes.values_mut().for_each(|axis| axis.sensor = sensor(SensorKind::Gyro));
    let accelerometer = AxisCalibration {
        rate_unit: RateUnit::MetresPerS2,
        sensor: sensor(SensorKind::Accelerometer),
        ..own.axes["gyro_x_rad_s"].clone()
    };
    own.axes.insert("accel0.x".into(), accelerometer);
    let log = Source::bytes("second.csv", log(733, 0.0, 0.0).into_bytes());
    let verified = |sensor| verify(&log, &own, &VerifyOptions { sensor, ..VerifyOptions::default() }).unwrap();
    let told = "accel0.x: the log has no accelerometer; to verify the gyros alone give `sensor` gyro";
    assert_eq!(verified(None).missing, [told]);
    let gyros = verified(Some(SensorChoice::Kind(SensorKind::Gyro)));
    assert!(gyros.passed.is_none() && gyros.missing.is_empty(), "{gyros:?}");
}

#[test]
fn another_log_is_refused_with_what_it_has() {
    let own = calibration();
    let text = log(733, 0.0, 0.0);
    let refused = |text: String, columns: &Columns| {
        let other = Source::bytes("other.csv", text.into_bytes());
        let options = VerifyOptions { columns: columns.clone(), ..VerifyOptions::default() };
        verify(&other, &own, &options).unwrap_err().to_string()
    };
    let columns = Columns { rates: vec!["gyro_p".to_owned(), "gyro_q".to_owned()], ..Columns::default() };
    let named = refused(text.replace("gyro_x_rad_s,gyro_y_rad_s", "gyro_p,gyro_q"), &columns);
    assert!(named.contains("it has gyro_p, gyro_q, and the calibration is for gyro_x_rad_s"), "{named}");
    let columns = Columns { rate_unit: Some(WrittenRate::Counts), ..Columns::default() };
    let in_counts = refused(text + "4000,50.0,0.1,0.2\n", &columns);
    assert!(in_counts.contains("is in counts, and the calibration's in rad/s"), "{in_counts}");
}

#[test]
fn an_axis_that_the_calibration_does_not_have_is_named() {
    let mut own = calibration();
    own.axes.remove("gyro_y_rad_s");
    let verified = second(0.0, 0.0, &Limits::default(), &own).unwrap();
    assert_eq!(verified.axes.len(), 1);
    assert_eq!(verified.notes, ["not in the calibration, and not verified: gyro_y_rad_s"]);
}

#[test]
fn temperatures_outside_the_calibrated_range_are_counted_and_warned_of() {
    let mut own = calibration();
    let narrow = zerorate_core::drift::ValidRange::new(0.0, 40.0).unwrap();
    own.axes.values_mut().for_each(|axis| axis.fit.measured = narrow);
    let verified = second(0.0, 0.0, &Limits::default(), &own).unwrap();
    assert!((verified.axes[0].outside - 1.0 / 3.0).abs() < 0.02, "{}", verified.axes[0].outside);
    let [reason] = &verified.reasons[..] else { panic!("{:?}", verified.reasons) };
    assert_eq!(reason.kind, ReasonKind::OutsideRange);
    // 134 of 400 averages.
    let text = "gyro_x_rad_s, gyro_y_rad_s: 34 % of the averages are outside the 0.0 to 40.0 C";
    assert!(reason.text.starts_with(text), "{}", reason.text);
}

/// Of a calibration of 0 to 40 C, widened by hand to -300 to 300: the log's 60 C are a tenth.
#[test]
fn a_run_of_few_of_the_calibrated_temperatures_says_so() {
    let mut own = calibration();
    let wide = ValidRange::new(-300.0, 300.0).unwrap();
    own.axes.values_mut().for_each(|axis| axis.fit.measured = wide);
    let verified = second(0.0, 0.0, &Limits::default(), &own).unwrap();
    let [note] = &verified.notes[..] else { panic!("{:?}", verified.notes) };
    assert!(note.starts_with("the log has 10 % of the temperatures that were calibrated, "), "{note}");
    // One axis alone.
    let mut own = calibration();
    own.axes.get_mut("gyro_y_rad_s").unwrap().fit.measured = wide;
    let verified = second(0.0, 0.0, &Limits::default(), &own).unwrap();
    let [note] = &verified.notes[..] else { panic!("{:?}", verified.notes) };
    assert!(
        note.starts_with("gyro_y_rad_s: its rates are at 10 % of the temperatures that were calibrated, "),
        "{note}"
    );
    assert!(second(0.0, 0.0, &Limits::default(), &calibration()).unwrap().notes.is_empty());
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

#[test]
fn a_step_of_the_second_run_stands_in_what_is_left_and_misses_a_limit() {
    let line = |t: f64| 1e-3 * t;
    let run = |stepped: bool| {
        let mut text = "time_s,temperature_c,gyro_x_rad_s\n".to_owned();
        for row in 0..4000_i32 {
            let t = 20.0 - 30.0 * (std::f64::consts::TAU * f64::from(row) / 4000.0).cos();
            let noise = (f64::from((row * 617) % 1000) - 499.5) * 1e-7;
            let step = if stepped && row >= 1000 { 0.02 } else { 0.0 };
            text += &format!("{row},{t},{}\n", line(t) + noise + step);
        }
        Source::bytes("run.csv", text.into_bytes())
    };
    let options = FitOptions { model: Model::Poly(1), ..FitOptions::default() };
    let own = fit(&[run(false)], &options).unwrap().to_calibration(Vec::new(), None).unwrap();
    let limits = Limits { max_pp: Some("0.01rad/s".parse().unwrap()), ..Limits::default() };
    let verified = verify(&run(true), &own, &VerifyOptions { limits, ..VerifyOptions::default() }).unwrap();
    assert_eq!(verified.passed, Some(false));
    assert!((verified.axes[0].corrected.pp - 0.02).abs() < 1e-3, "{:?}", verified.axes[0]);
    let told = verified.reasons.iter().find(|reason| reason.kind == ReasonKind::Step).unwrap();
    assert!(told.text.ends_with("it stands in what is left"), "{}", told.text);
}

/// Rows `step_s` apart of a slow swing of temperature, a rate in proportion and a sine of 60 s.
fn sine(rows: u32, step_s: f64, size: f64) -> Source {
    let mut text = "time_s,temperature_c,gyro_x_rad_s,gyro_y_rad_s\n".to_owned();
    for row in 0..rows {
        let time = f64::from(row) * step_s;
        let t = 20.0 + 15.0 * (std::f64::consts::TAU * f64::from(row) / f64::from(rows)).sin();
        let rate = 1e-3 * t + size * (std::f64::consts::TAU * time / 60.0).sin();
        text += &format!("{time},{t},{rate},{rate}\n");
    }
    Source::bytes("sine.csv", text.into_bytes())
}

/// The mean of a sine of 60 s over 10 s is the sine times sin(pi / 6) / (pi / 6) = 3 / pi.
#[test]
fn what_is_told_is_of_ten_seconds_however_long_or_short_the_log_is() {
    let quiet = sine(8000, 1.0, 0.0);
    let own = fit(&[quiet], &FitOptions::default()).unwrap().to_calibration(Vec::new(), None).unwrap();
    let true_rms = 0.01 / 2.0_f64.sqrt() * 3.0 / std::f64::consts::PI;
    // Half a day, five minutes at 20 Hz, and three hours of a row a second, where the fit would take 21.
    for (rows, step_s) in [(86_400, 0.5), (6000, 0.05), (10_800, 1.0)] {
        let verified = verify(&sine(rows, step_s, 0.01), &own, &VerifyOptions::default()).unwrap();
        let rms = verified.axes[0].corrected.rms;
        assert!((rms / true_rms - 1.0).abs() < 0.03, "{rows}: {rms} {true_rms}");
        assert!((verified.averaged_over_s.unwrap() - 10.0).abs() < 0.6, "{:?}", verified.averaged_over_s);
    }
}

#[test]
fn without_times_nobody_says_ten_seconds() {
    let text = log(733, 0.0, 0.0).replace("time_s,", "mark,");
    let log = Source::bytes("second.csv", text.into_bytes());
    let verified = verify(&log, &calibration(), &VerifyOptions::default()).unwrap();
    assert_eq!(verified.averaged_over_s, None);
}

/// What the calibration was fitted on, with other names and another unit; `dps` is 180 / pi to a radian.
#[test]
fn a_calibration_of_other_names_and_units_is_matched_by_role_and_says_the_same() {
    let own = calibration();
    let expected = second(0.001, 0.0, &Limits::default(), &own).unwrap();
    let text = log(733, 0.001, 0.0);
    let mut turned = "GyrY,t_s,GyrX,temperature_c\n".to_owned();
    for row in text.lines().skip(1) {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        let [x, y] = [cells[2], cells[3]].map(|rate| rate * 57.295_779_513_082_32);
        turned += &format!("{y},{},{x},{}\n", cells[0], cells[1]);
    }
    let other = Source::bytes("other.csv", turned.into_bytes());
    let columns = Columns { rate_unit: Some(WrittenRate::Dps), ..Columns::default() };
    let verified = verify(&other, &own, &VerifyOptions { columns, ..VerifyOptions::default() }).unwrap();
    assert!(verified.missing.is_empty());
    for (axis, expected) in verified.axes.iter().zip(&expected.axes) {
        assert_eq!((axis.name.as_str(), axis.rate_unit), (expected.name.as_str(), RateUnit::RadPerS));
        assert!((axis.corrected.rms / expected.corrected.rms - 1.0).abs() < 1e-6, "{axis:?}");
        assert!((axis.offset - expected.offset).abs() < 1e-9);
    }
    assert!(verified.notes.contains(&"'GyrX' of the log is taken for gyro_x_rad_s of the calibration".to_owned()));
}

#[test]
fn a_correction_that_is_worse_than_none_is_told_and_fails_by_limits_alone() {
    let text = log(733, 0.0, 0.0);
    // The other way: what is taken off is added.
    let mut turned = String::new();
    for (place, row) in text.lines().enumerate() {
        let cells: Vec<&str> = row.split(',').collect();
        let rate = cells[2].parse().map_or(cells[2].to_owned(), |rate: f64| (-rate).to_string());
        turned += &format!("{},{},{rate},{}\n", cells[0], cells[1], cells[3]);
        assert!(place > 0 || rate == "gyro_x_rad_s");
    }
    let log = Source::bytes("turned.csv", turned.into_bytes());
    let verify_with =
        |limits| verify(&log, &calibration(), &VerifyOptions { limits, ..VerifyOptions::default() }).unwrap();
    let verified = verify_with(Limits::default());
    assert_eq!((verified.passed, verified.verdict), (None, Verdict::Warning));
    assert_eq!(verified.axes.iter().map(|axis| axis.worse).collect::<Vec<_>>(), [true, false]);
    let [reason] = &verified.reasons[..] else { panic!("{:?}", verified.reasons) };
    assert_eq!(reason.kind, ReasonKind::WorseThanUncorrected);
    assert!(reason.text.starts_with("gyro_x_rad_s: worse than uncorrected: "), "{}", reason.text);
    // Twice the drift is left.
    assert!((verified.axes[0].corrected.rms / verified.axes[0].raw.rms - 2.0).abs() < 1e-3);
    let lax = verify_with(limits("1 rad/s", "1 rad/s"));
    assert_eq!((lax.passed, lax.verdict), (Some(true), Verdict::Warning));
}

#[test]
fn the_share_outside_is_of_what_was_measured_and_not_of_what_is_believed() {
    // Measured to 50 C less half of the last group, and believed an eighth of 60 degrees further.
    let own = calibration();
    let axis = &own.axes["gyro_x_rad_s"];
    assert!((axis.fit.measured.max() - 50.0).abs() < 0.7 && axis.drift().valid.max() > 57.0, "{axis:?}");
    // 60 degrees to 57 C: 7 of them above 50.
    let warmer: String = log(733, 0.0, 0.0)
        .lines()
        .map(|row| {
            let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
            cells[1] = cells[1].parse().map_or(cells[1].clone(), |t: f64| (t + 7.0).to_string());
            cells.join(",") + "\n"
        })
        .collect();
    let log = Source::bytes("warmer.csv", warmer.into_bytes());
    let verified = verify(&log, &own, &VerifyOptions::default()).unwrap();
    assert!((verified.axes[0].outside - 7.0 / 60.0).abs() < 0.01, "{}", verified.axes[0].outside);
    assert_eq!(verified.reasons[0].kind, ReasonKind::OutsideRange);
}

#[test]
fn an_axis_without_most_of_its_rates_does_not_pass() {
    let own = calibration();
    for (kept, covered, passes) in [(10, 0.1, false), (3, 1.0 / 3.0, false), (1, 1.0, true)] {
        // X has a rate in every tenth row, or third.
        let whole = log(733, 0.0, 0.0);
        let rows = whole.lines().enumerate().map(|(row, line)| {
            let cells: Vec<&str> = line.split(',').collect();
            let x = if row == 0 || row % kept == 0 { cells[2] } else { "" };
            format!("{},{},{x},{}\n", cells[0], cells[1], cells[3])
        });
        let text: String = rows.collect();
        let limits = limits("1 mrad/s", "5 mrad/s");
        let options = VerifyOptions { limits, ..VerifyOptions::default() };
        let found = verify(&Source::bytes("holes.csv", text.into_bytes()), &own, &options).unwrap();
        assert_eq!(found.passed, Some(passes), "{found:?}");
        assert!((found.axes[0].covered - covered).abs() < 0.01, "{}", found.axes[0].covered);
        let told = found.axes[0].missed.iter().any(|missed| missed.contains("of its rates are missing"));
        assert_eq!((told, found.axes[1].missed.len()), (!passes, 0), "{found:?}");
    }
}

fn line(slope: f64) -> Drift {
    let scale = Scale::spanning(-100.0, 100.0).unwrap();
    let shape = Shape::Polynomial(Polynomial::from_raw_coefficients(scale, &[0.0, slope]).unwrap());
    Drift { shape, valid: ValidRange::new(-100.0, 100.0).unwrap() }
}

#[test]
fn a_run_that_leaves_much_more_than_the_fit_told_has_something_else() {
    // Two rows a second, so that both are of averages over 10 s.
    let faster = |name: &str, seed: i32, extra: f64| {
        let mut text = String::new();
        for (place, row) in log(seed, 0.0, extra).lines().enumerate() {
            let (time, rest) = row.split_once(',').unwrap();
            let time = if place == 0 { time.to_owned() } else { (time.parse::<f64>().unwrap() / 2.0).to_string() };
            text += &format!("{time},{rest}\n");
        }
        Source::bytes(name, text.into_bytes())
    };
    let first = faster("first.csv", 617, 0.0);
    let fitted = fit(std::slice::from_ref(&first), &FitOptions::default()).unwrap();
    let own = fitted.to_calibration(vec![Origin::of("log", &first).unwrap()], None).unwrap();
    let told = own.axes["gyro_x_rad_s"].fit.statistics.deployed.unwrap().rms;
    let verified = |extra: f64| verify(&faster("second.csv", 733, extra), &own, &VerifyOptions::default()).unwrap();
    assert!(verified(0.0).reasons.is_empty(), "{:?}", verified(0.0).reasons);
    // Turned around the unit is another one, and twice as bad as nothing.
    let mut turned = own.clone();
    let model = &mut turned.axes.get_mut("gyro_x_rad_s").unwrap().fit.model;
    *model = DriftModel::of_curve(line(-1e-3));
    let worse = verify(&faster("second.csv", 733, 0.0), &turned, &VerifyOptions::default()).unwrap();
    let kinds: Vec<ReasonKind> = worse.reasons.iter().map(|reason| reason.kind).collect();
    assert_eq!(kinds, [ReasonKind::WorseThanUncorrected, ReasonKind::MoreThanTold], "{:?}", worse.reasons);
    let other = verified(1e-3);
    let [reason] = &other.reasons[..] else { panic!("{:?}", other.reasons) };
    assert_eq!((reason.kind, other.verdict), (ReasonKind::MoreThanTold, Verdict::Warning));
    let times = format!("{:.1} times what the fit told", other.axes[0].deployed.rms / told);
    assert!(reason.text.starts_with("gyro_x_rad_s: ") && reason.text.contains(&times), "{}", reason.text);
}

/// A device corrects by what its sensor shows. In steps of 1 C a slope of 1 mrad/s per C is wrong by up to half a mrad/s to either side,
/// 1/sqrt(12) of a step, root mean square; averages over less than a twelfth of a step take next to nothing of it.
#[test]
fn of_a_coarse_temperature_what_is_left_has_its_steps() {
    let of_run = |seed: i32, from: f64| {
        let mut text = "time_s,temperature_c,gyro_x_rad_s\n".to_owned();
        for row in 0..14_400_i32 {
            let t = from + 60.0 * f64::from(row) / 14_400.0;
            let noise = (f64::from((row * seed) % 1000) - 499.5) * 1e-7;
            text += &format!("{},{},{}\n", f64::from(row) / 2.0, t.round(), 1e-3 * t + noise);
        }
        Source::bytes("log.csv", text.into_bytes())
    };
    let fitted = fit(&[of_run(617, -10.0)], &FitOptions::default()).unwrap();
    let told = fitted.axes[0].calibration.fit.statistics.deployed.unwrap().rms;
    let own = fitted.to_calibration(Vec::new(), None).unwrap();
    let verified = verify(&of_run(733, -8.3), &own, &VerifyOptions::default()).unwrap();
    let truth = 1e-3 / 12.0_f64.sqrt();
    let left = verified.axes[0].corrected.rms;
    assert!((0.85..1.05).contains(&(left / truth)), "{left} for {truth}");
    // With a zero at the start, which is anywhere on a step.
    assert!((0.85..2.1).contains(&(told / truth)), "{told} for {truth}");
}

#[test]
fn a_run_of_half_a_minute_is_too_short() {
    let short: String = log(733, 0.0, 0.0).lines().take(31).map(|row| row.to_owned() + "\n").collect();
    let refused = verify(&Source::bytes("log.csv", short.into_bytes()), &calibration(), &VerifyOptions::default());
    let refused = refused.unwrap_err().to_string();
    assert!(refused.contains("too few averages over 10 s to tell anything: give a longer log"), "{refused}");
}

#[test]
fn a_model_with_a_lag_needs_times() {
    let mut own = calibration();
    let model = &mut own.axes.get_mut("gyro_x_rad_s").unwrap().fit.model;
    let term = Term { memory: Memory::Lag { time_constant_s: 120.0 }, weight: 1e-4, behind: 0.0, share: 1.0 };
    model.history = History::new(model.drift.shape.clone(), &[term]);
    let timed = log(733, 0.0, 0.0);
    let untimed: String =
        timed.lines().map(|row| row.split_once(',').map_or(row, |(_, rest)| rest).to_owned() + "\n").collect();
    let refused = verify(&Source::bytes("log.csv", untimed.into_bytes()), &own, &VerifyOptions::default()).unwrap_err();
    assert!(refused.to_string().contains("the model needs the time of each row"), "{refused}");
    assert!(verify(&Source::bytes("log.csv", timed.into_bytes()), &own, &VerifyOptions::default()).is_ok());
}

/// What `apply` takes off row by row, averaged over the same rows by hand, is what is told to be left: of a play, which a noisy temperature
/// drives along, and which its averages would not.
#[test]
fn what_remembers_goes_by_rows_as_it_is_applied() {
    use crate::apply::{AppliedModel, AppliedTo, apply};
    use zerorate_cal::table::Table;
    let mut own = calibration();
    let axis = own.axes.get_mut("gyro_x_rad_s").unwrap();
    let term = Term { memory: Memory::Play { half_width: 2.0 }, weight: 1e-3, behind: 0.0, share: 1.0 };
    axis.fit.model.history = History::new(axis.fit.model.drift.shape.clone(), &[term]);
    let model = AppliedModel {
        column: "gyro_x_rad_s".to_owned(),
        temperature: "temperature_c".to_owned(),
        written_temperature: WrittenTemperature::Celsius,
        model: axis.fit.model.clone(),
        measured: axis.fit.measured,
        factor: 1.0,
    };
    let mut text = "time_s,temperature_c,gyro_x_rad_s\n".to_owned();
    for row in 0..6000_i32 {
        let (t, noise) = (-8.0 + 56.0 * f64::from(row) / 6000.0, f64::from((row * 7919) % 1000) / 500.0 - 1.0);
        text += &format!("{},{},{}\n", f64::from(row) / 2.0, t + 1.5 * noise, 1e-3 * t + 1e-5 * t * t);
    }
    let log = Source::bytes("second.csv", text.into_bytes());
    let told = verify(&log, &own, &VerifyOptions::default()).unwrap();
    let told = told.axes.iter().find(|axis| axis.name == "gyro_x_rad_s").unwrap().corrected.rms;
    let mut written = Vec::new();
    let to = AppliedTo { time: None, start: zerorate_fit::predict::Start::Unknown };
    apply(&Table::open(&log).unwrap(), &to, &[model], &mut written).unwrap();
    let written = String::from_utf8(written).unwrap();
    let left = written.lines().skip(1).map(|row| row.rsplit(',').next().unwrap().parse::<f64>().unwrap());
    let left: Vec<f64> = left.collect::<Vec<_>>().chunks_exact(20).map(|ten| ten.iter().sum::<f64>() / 20.0).collect();
    let mean = left.iter().sum::<f64>() / left.len() as f64;
    let truth = (left.iter().map(|left| (left - mean).powi(2)).sum::<f64>() / left.len() as f64).sqrt();
    assert!((told / truth - 1.0).abs() < 0.03, "{told} for {truth}");
}
