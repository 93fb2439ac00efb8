use proptest::prelude::*;
use zerorate_core::compensate::{HistoryNumbers, LowPass, Mode};
use zerorate_core::drift::{Drift, Polynomial, Scale, Shape, Table, ValidRange};
use zerorate_core::record::MAX_RECORD_BYTES;
use zerorate_core::trim::{TapEffects, Trim, TrimLine};
use zerorate_core::units::{Axis, Counts, Taps, Volts};

use zerorate_fit::drift_fit::{BandPoint, HeldOut, StaticCubic};
use zerorate_fit::model::Model;
use zerorate_fit::predict::TimeDrift;
use zerorate_fit::residual::ResidualStatistics;
use zerorate_fit::trim::{SupplyPoint, TrimEstimate};

use super::*;
use crate::fit::fit;
use crate::log_fit::{FitOptions, LogFit};
use crate::quality::Judgement;
use crate::ramp_fit::{RampGroup, RampMeans, fit_axis};
use crate::units::RateUnit;

/// A board's axis: eq. (1), X, shifted, with noise; a trim with measured effects whose numbers have all their bits.
fn board_axis(shift: f64) -> AxisCalibration {
    let (temperatures, readings): (Vec<f64>, Vec<f64>) = (0..2400_i32)
        .map(|group| {
            let t = 8500.0 + 3400.0 * f64::from(group) / 2399.0;
            let noise = f64::from((group * 617) % 1000) / 500.0 - 1.0;
            (t, shift + 13_435.7 - 0.894_782 * t + 0.375_298e-4 * t * t + noise)
        })
        .unzip();
    let estimate = TrimEstimate {
        slope_taps_per_count: -0.1 / 3.13,
        slope_standard_error_taps_per_count: 1e-5 / 3.0,
        intercept_taps: -0.02 / 3.0,
        intercept_standard_error_taps: 0.01,
        centre_counts: 8200.0 + 1.0 / 3.0,
        centre_standard_error_counts: 2.0,
        residual_rms_taps: 0.1,
    };
    let line = TrimLine::new(
        estimate.slope_taps_per_count,
        estimate.intercept_taps,
        Counts(estimate.centre_counts),
        Taps::MIDDLE,
    )
    .unwrap();
    let effects: Vec<Counts> = (-16..=16).map(|k| Counts(f64::from(k) * 31.3 + f64::from(k % 5) / 7.0)).collect();
    let trim = TrimCalibration {
        trim: Trim { line, measured: TapEffects::new(Taps::new(495).unwrap(), &effects) },
        points: vec![SupplyPoint {
            supply: Volts(2.517),
            at_middle: Counts(8199.25 + shift),
            trimmed: Counts(8203.7),
            tap: Taps::MIDDLE,
        }],
        paired: Some(estimate),
        paper: Some(estimate),
        dead_band_taps: 0.15,
        low_pass: LowPass::first_order(40.0, 0.003, 0.0001),
        start_up_mode: Mode::Hybrid,
    };
    let mut means = RampMeans::default();
    for (group, (temperature, reading)) in (0..).zip(temperatures.iter().copied().zip(readings)) {
        let time_s = 1.5 * f64::from(group);
        means.push(&RampGroup { group, time_s, temperature, reading, samples: 500, status_bits: 0, tap: 511 });
    }
    let options = FitOptions { model: Model::Poly(2), ..FitOptions::default() };
    let fit = fit_axis("x", &means, None, &options, &mut Judgement::default()).unwrap();
    AxisCalibration { trim: Some(trim), ..fit.calibration }
}

fn board() -> Calibration {
    let sha256 = "0123456789abcdef".repeat(4);
    let origin = Origin {
        content: "full-temperature".into(),
        file: "full-temperature.parquet".into(),
        sha256,
        started: None,
        changed: None,
        rows: Vec::new(),
    };
    let axes = [("x".to_owned(), board_axis(0.0)), ("y".to_owned(), board_axis(17.3))].into();
    let serial = Some("ZR-000042".to_owned());
    Calibration {
        temperature_scale: Some(TemperatureScale::QUARTER_COUNTS),
        group_period_s: Some(1.5),
        warnings: vec!["look at this".to_owned()],
        setup: Some(serde_json::json!({ "group": { "samples": 500 } })),
        ..Calibration::new(Kind::AnalogueBoard, serial, vec![origin], TemperatureUnit::Counts, axes)
    }
}

fn bytes(calibration: &Calibration) -> Vec<u8> {
    let made = calibration.to_device_record().unwrap();
    made.record.encode(&mut [0; MAX_RECORD_BYTES]).unwrap().to_vec()
}

#[test]
fn a_calibration_that_was_written_and_read_is_the_same_and_makes_the_same_record() {
    let board = board();
    let text = board.to_json().unwrap();
    let read = Calibration::read(&Source::bytes("calibration.json", text.as_bytes())).unwrap();
    assert_eq!(read, board);
    assert_eq!(bytes(&read), bytes(&board));
    assert_eq!(read.to_json().unwrap(), text);
}

#[test]
fn the_file_names_its_units() {
    let json: serde_json::Value = serde_json::from_str(&board().to_json().unwrap()).unwrap();
    assert_eq!((&json["schema"], &json["kind"]), (&3.into(), &"analogue-board".into()));
    assert_eq!((&json["temperature_unit"], &json["temperature_scale"]["step"]), (&"counts".into(), &0.25.into()));
    let x = &json["axes"]["x"];
    assert_eq!((&x["model"], &x["rate_unit"]), (&"poly:2".into(), &"counts".into()));
    assert_eq!(x["drift"]["valid_temperature"], serde_json::json!([8500.0, 11_900.0]));
    let raw = x["drift"]["raw_coefficients"][2].as_f64().unwrap();
    assert!((raw / 0.375_298e-4 - 1.0).abs() < 1e-2, "{raw}");
    assert_eq!((&x["fit"]["residual_over"], &x["fit"]["residuals"]), (&"groups".into(), &2400.into()));
    assert_eq!(x["fit"]["candidates"].as_array().unwrap().len(), 1);
    assert_eq!(x["fit"]["covariance"].as_array().unwrap().len(), 3);
    assert_eq!((&x["trim"]["line"]["middle_tap"], &x["trim"]["start_up_mode"]), (&511.into(), &"hybrid".into()));
    assert_eq!(x["trim"]["tap_effects"]["effects_counts"].as_array().unwrap().len(), 33);
}

fn plain_fit(rows: &str) -> LogFit {
    let log = Source::bytes("log.csv", rows.as_bytes());
    fit(&[log], &FitOptions { plain: true, ..FitOptions::default() }).unwrap()
}

#[test]
fn a_log_becomes_a_calibration_of_its_columns() {
    let mut text = "time_s,temperature_c,gyro_x,gyro_y\n".to_owned();
    for row in 0..2000_i32 {
        let t = -20.0 + f64::from(row) * 0.03;
        let noise = f64::from((row * 617) % 1000) * 1e-7;
        text += &format!("{row},{t},{},{}\n", 1e-4 * t + noise, 2e-6 * t * t + noise);
    }
    let calibration = plain_fit(&text).to_calibration(Vec::new(), None).unwrap();
    assert_eq!(calibration.axes.keys().collect::<Vec<_>>(), ["gyro_x", "gyro_y"]);
    let y = &calibration.axes["gyro_y"];
    assert_eq!((y.model(), y.fit.statistics.residuals), (Model::Poly(2), 2000));
    let read = Calibration::from_json(&calibration.to_json().unwrap()).unwrap();
    assert_eq!(read, calibration);
    assert_eq!(read.to_device_record(), Err(NoDeviceRecord::NotABoard));
}

#[test]
fn a_rejected_log_makes_no_calibration() {
    let rows: String = (0..500).map(|row| format!("{row},25.0,0.001\n")).collect();
    let fit = plain_fit(&format!("time_s,temperature_c,gyro_x\n{rows}"));
    let refused = fit.to_calibration(Vec::new(), None).unwrap_err();
    assert!(refused.to_string().contains("the temperature stays at 25.00"), "{refused}");
}

/// The hash of "abc": FIPS 180-4's own example.
#[test]
fn of_a_log_is_told_when_its_file_was_last_changed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.csv");
    std::fs::write(&path, "abc").unwrap();
    // `date -u -d 2026-03-01T08:00:00Z +%s`
    let eight = std::time::SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(1_772_352_000);
    std::fs::File::options().write(true).open(&path).unwrap().set_modified(eight).unwrap();
    let changed = |source: &Source| Origin::of_log(None, source).unwrap().changed;
    assert_eq!(changed(&(&path).into()).as_deref(), Some("2026-03-01T08:00:00Z"));
    assert_eq!(changed(&Source::bytes("log.csv", *b"abc")), None);
}

#[test]
fn an_origin_is_known_by_the_hash_of_its_bytes() {
    let origin = Origin::of("trim-sweep", &Source::bytes("folder/abc.parquet", *b"abc")).unwrap();
    assert_eq!(origin.file, "abc.parquet");
    assert_eq!(origin.sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    assert!(Origin::of("log", &"/nowhere/none.csv".into()).is_err());
}

#[test]
fn an_unknown_schema_is_named_before_anything_else() {
    let refused = |text: &str| Calibration::from_json(text).unwrap_err().to_string();
    let newer = refused(r#"{ "schema": 7, "axes": "in another form" }"#);
    assert!(newer.starts_with("schema 7,") && newer.ends_with("use a newer zerorate"), "{newer}");
    assert!(refused(r#"{ "schema": 0 }"#).ends_with("calibrate or fit again"));
    for other in [r#"{ "plant": "paper" }"#, r#"{ "schema": "1" }"#, "{}"] {
        assert!(refused(other).contains("this is not a calibration"), "{other}");
    }
}

#[test]
fn a_malformed_file_is_refused_with_line_and_column() {
    let text = board().to_json().unwrap();
    let place = |text: &str| match Calibration::from_json(text).unwrap_err() {
        CalibrationFault::Malformed { line, column, what, .. } => (line, column, what),
        other => panic!("{other}"),
    };
    let cut = &text[..text.len() / 2];
    assert_eq!(place(cut).0, cut.lines().count());
    let (line, column, what) = place(&text.replacen("\"kind\": \"analogue-board\"", "\"kind\": \"toaster\"", 1));
    assert_eq!((line, column), (3, 19));
    assert!(what.contains("unknown variant 'toaster'") && !what.contains("line"), "{what}");
    let refused = Calibration::from_json(&text.replacen("\"sources\"", "\"origins\"", 1)).unwrap_err();
    assert!(refused.to_string().contains("missing field 'sources'"), "{refused}");
}

#[test]
fn contradictions_in_a_file_are_refused() {
    let text = board().to_json().unwrap();
    let refused = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        Calibration::from_json(&text.replacen(from, to, 1)).unwrap_err().to_string()
    };
    assert!(
        refused("\"model\": \"poly:2\",\n      \"drift\"", "\"model\": \"poly:3\",\n      \"drift\"")
            .contains("model poly:3")
    );
    let raw = "\"raw_coefficients\": [\n          1";
    assert!(refused(raw, &raw.replace('1', "2")).contains("are not the same polynomial"));
    assert!(refused("\"scaled_coefficients\"", "\"coefficients\"").contains("either scaled_coefficients or knots"));
    assert!(refused("\"temperature_half_span\": ", "\"temperature_half_span\": -").contains("above zero"));
    assert!(refused("\"slope_taps_per_count\": -", "\"slope_taps_per_count\": ").contains("below zero"));
    assert!(refused("\"middle_tap\": 511", "\"middle_tap\": 1511").contains("0 to 1023"));
    assert!(refused("\"first_tap\": 495", "\"first_tap\": 1000").contains("33 tap effects from tap 1000"));
    assert!(refused("\"hybrid\"", "\"automatic\"").contains("'automatic' is no mode: there are off"));
}

#[test]
fn files_that_are_something_else_are_refused() {
    let refused = |source: &Source| Calibration::read(source).unwrap_err();
    let record = refused(&Source::bytes("device-record.bin", [0x5a, 0x52, 0xff, 0x00]));
    assert!(matches!(record.fault, CalibrationFault::NotOne), "{record}");
    let summary =
        refused(&Source::bytes("summary.json", *br#"{ "schema": 2, "plant": "paper", "axes": { "x": {} } }"#));
    assert!(matches!(summary.fault, CalibrationFault::NotOne), "{summary}");
    let none = refused(&"/nowhere/none".into());
    assert!(none.to_string().starts_with("/nowhere/none: cannot be read"), "{none}");
}

#[test]
fn what_would_not_read_back_is_not_written() {
    let mut bad = board();
    bad.axes.get_mut("x").unwrap().fit.statistics.in_sample.rms = f64::NAN;
    assert!(matches!(bad.to_json(), Err(CalibrationFault::Unwritable { .. })));
}

#[test]
fn what_a_record_needs_and_is_missing_is_named() {
    let refused = |change: fn(&mut Calibration)| {
        let mut changed = board();
        change(&mut changed);
        changed.to_device_record().unwrap_err()
    };
    assert_eq!(refused(|c| c.unit_serial = None), NoDeviceRecord::NoSerial);
    assert_eq!(refused(|c| c.temperature_scale = None), NoDeviceRecord::NoTemperatureScale);
    assert_eq!(refused(|c| drop(c.axes.remove("y"))), NoDeviceRecord::NoAxis { axis: "y" });
    assert_eq!(refused(|c| c.axes.values_mut().for_each(|a| a.trim = None)), NoDeviceRecord::NoTrim { axis: "x" });
    let in_rates = refused(|c| c.axes.values_mut().for_each(|a| a.rate_unit = RateUnit::Dps));
    assert_eq!(in_rates.to_string(), "axis x is in dps: a device works in counts");
    let band = refused(|c| c.axes.values_mut().filter_map(|a| a.trim.as_mut()).for_each(|t| t.dead_band_taps = 2.0));
    assert!(band.to_string().starts_with("axis x: a dead band of 2 taps"), "{band}");
}

#[test]
fn an_axis_whose_wiper_cannot_follow_is_named_and_runs_digitally() {
    let mut board = board();
    let line = TrimLine::new(-0.3, 0.0, Counts(8200.0), Taps::MIDDLE).unwrap();
    if let Some(trim) = board.axes.get_mut("y").and_then(|y| y.trim.as_mut()) {
        // A tap of 3 counts, and no tap measured: the drift of 380 counts needs more than the table of edges holds.
        trim.trim = Trim { line, measured: None };
    }
    let made = board.to_device_record().unwrap();
    assert_eq!(made.digital_only.iter().map(|(axis, _)| *axis).collect::<Vec<_>>(), [Axis::Y]);
    assert_eq!(made.record.axis(Axis::Y).start_up_mode, Mode::Digital);
    assert!(made.record.axis(Axis::X).law.edges.is_some());
}

fn drifts() -> impl Strategy<Value = Drift> {
    let scales = (-1e4_f64..1e4, 1e-3_f64..1e4).prop_map(|(centre, half)| Scale::new(centre, half).unwrap());
    let values = |most| prop::collection::vec(-1e5_f64..1e5, 2..=most);
    let polynomial = (scales.clone(), values(6))
        .prop_map(|(scale, values)| (scale, Shape::Polynomial(Polynomial::new(scale, &values).unwrap())));
    let table =
        (scales, values(33)).prop_map(|(scale, values)| (scale, Shape::Table(Table::new(scale, &values).unwrap())));
    prop_oneof![polynomial, table].prop_map(|(scale, shape)| {
        let valid = ValidRange::new(scale.temperature(-1.0), scale.temperature(1.0)).unwrap();
        Drift { shape, valid }
    })
}

proptest! {
    #[test]
    fn every_drift_reads_back_to_the_same_bits(drift in drifts()) {
        let mut calibration = board();
        calibration.axes.get_mut("x").unwrap().fit.model.drift = drift;
        let read = Calibration::from_json(&calibration.to_json().unwrap()).unwrap();
        prop_assert_eq!(read, calibration);
    }
}

/// A play and a lag on the curve of an axis.
fn with_history(axis: &mut AxisCalibration) {
    use zerorate_core::drift::{History, Memory, Term};
    let terms = [
        Term { memory: Memory::Play { half_width: 123.4 }, weight: 0.0117, behind: 0.0, share: 0.6 },
        Term { memory: Memory::Lag { time_constant_s: 240.0 }, weight: -0.3, behind: 0.25, share: 0.4 },
    ];
    axis.fit.model.history = History::new(axis.drift().shape.clone(), &terms);
}

/// The board's record carries an axis's history and the time it runs by, and is refused where that is not known.
#[test]
fn a_boards_history_stands_in_its_record() {
    let mut calibration = board();
    with_history(calibration.axes.get_mut("x").unwrap());
    let [x, y] = calibration.to_device_record().unwrap().record.axes;
    // Rounded to the device's integers: a group of 1.5 s.
    let (axis, scale) = (&calibration.axes["x"], calibration.temperature_scale.unwrap());
    let centre = axis.trim.as_ref().unwrap().trim.line.centre();
    let rounded =
        HistoryNumbers::new(axis.fit.model.history.as_ref().unwrap(), axis.drift(), centre, scale, 1.5).unwrap();
    assert_eq!((x.law.history, y.law.history), (Some(rounded), None));
    calibration.group_period_s = None;
    assert_eq!(calibration.to_device_record(), Err(NoDeviceRecord::NoGroupPeriod { axis: "x" }));
}

/// A history, a drift in time, a static cubic and a band read back to the same bits.
#[test]
fn a_calibration_with_a_history_reads_back_as_it_was_written() {
    let mut calibration = board();
    let axis = calibration.axes.get_mut("x").unwrap();
    with_history(axis);
    axis.fit.model.time_drift = Some(TimeDrift::straight(1e-3, 2122.25));
    axis.fit.band = vec![BandPoint { temperature: 8500.0, half_width: 1.0 / 3.0 }];
    axis.fit.next_run_band = vec![BandPoint { temperature: 8500.0, half_width: 2.0 / 3.0 }];
    let in_sample = ResidualStatistics { rms: 0.1, pp: 0.7, rms_standard_error: None };
    axis.fit.static_cubic =
        Some(StaticCubic { drift: axis.drift().clone(), in_sample, held_out: None, deployed: None });
    let text = calibration.to_json().unwrap();
    assert_eq!(Calibration::from_json(&text).unwrap(), calibration);
    for (good, bad) in [("\"half_width\": 123.4", "\"half_width\": -1"), ("\"share\": 0.6", "\"share\": 0.9")] {
        let error = Calibration::from_json(&text.replace(good, bad)).unwrap_err().to_string();
        assert!(error.contains("a history has 1 to 6 terms"), "{error}");
    }
}

/// Names that were changed are read by the old ones, too.
#[test]
fn a_file_with_earlier_names_is_still_read() {
    let mut calibration = board();
    let statistics = &mut calibration.axes.get_mut("x").unwrap().fit.statistics;
    let [rms, none] = [Some(0.5), None];
    statistics.nested = Some(HeldOut {
        folds: 8,
        in_recording: rms,
        deployed_warm: rms,
        deployed_cold: none,
        cubic_in_recording: none,
        cubic_deployed: rms,
    });
    let mut text = calibration.to_json().unwrap();
    for (now, then) in [("held_out_folds", "held_out_stretches"), ("\"folds\"", "\"stretches\"")] {
        assert!(text.contains(now), "{now}");
        text = text.replace(now, then);
    }
    assert_eq!(Calibration::from_json(&text).unwrap(), calibration);
}

/// Files of the first schema have none of it, and are still read.
#[test]
fn the_first_schema_is_still_read() {
    let calibration = board();
    let text = calibration.to_json().unwrap().replacen("\"schema\": 3", "\"schema\": 1", 1);
    assert_eq!(Calibration::from_json(&text).unwrap(), calibration);
}
