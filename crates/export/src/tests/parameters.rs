//! Parameter files, read back by PEERS' description of the formats and evaluated as the autopilots do.

// Values that were written are to be read back as they were; the autopilots keep singles.
#![allow(clippy::float_cmp, clippy::cast_possible_truncation)]

use std::collections::BTreeMap;

use super::calibrations::{axis, calibration, drift, three_axes};
use crate::{Cubic, ExportError, ExportOptions, ExportedAxis, Format, Loss, export};
use zerorate_cal::calibration::Calibration;
use zerorate_cal::units::{RateScale, RateUnit};
use zerorate_core::drift::ValidRange;
use zerorate_fit::drift_fit::StaticCubic;
use zerorate_fit::predict::TimeDrift;

/// Reads lines of `1 1 NAME VALUE TYPE` with tabs between; singles for floats.
fn read_px4(text: &str) -> BTreeMap<String, f32> {
    let mut found = BTreeMap::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let cells: Vec<&str> = line.split('\t').collect();
        let [vehicle, component, name, value, kind] = cells[..] else { panic!("{line}") };
        assert_eq!((vehicle, component), ("1", "1"), "{line}");
        assert!(name.len() <= 16, "MAVLink's names have 16 letters at most: {name}");
        let number = match kind {
            "6" => value.parse::<i32>().unwrap() as f32,
            "9" => value.parse::<f32>().unwrap(),
            other => panic!("type {other}"),
        };
        assert!(found.insert(name.to_owned(), number).is_none(), "{name} stands twice");
    }
    found
}

/// Reads lines of a name and a value with a space or a comma between.
fn read_ardupilot(text: &str, between: char) -> BTreeMap<String, f32> {
    let mut found = BTreeMap::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let (name, value) = line.split_once(between).unwrap_or_else(|| panic!("{line}"));
        assert!(name.len() <= 16 && name.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_'));
        assert!(found.insert(name.to_owned(), value.parse().unwrap()).is_none(), "{name} stands twice");
    }
    found
}

/// PX4's formula in singles.
fn px4_offset(p: &BTreeMap<String, f32>, sensor: &str, axis: usize, temperature: f32) -> f32 {
    let of = |name: &str| p[&format!("TC_{sensor}_{name}")];
    let x = |power: usize| of(&format!("X{power}_{axis}"));
    let d = temperature.clamp(of("TMIN"), of("TMAX")) - of("TREF");
    x(0) + x(1) * d + x(2) * d * d + x(3) * d * d * d
}

/// ArduPilot's formula in singles.
fn ardupilot_polynomial(p: &BTreeMap<String, f32>, imu: u8, kind: &str, axis: char, temperature: f32) -> f32 {
    let of = |name: String| p[&format!("INS_TCAL{imu}_{name}")];
    let c = |power: usize| of(format!("{kind}{power}_{axis}"));
    let x = temperature.clamp(of("TMIN".to_owned()), of("TMAX".to_owned())) - 35.0;
    (c(1) + (c(2) + c(3) * x) * x) * x * 1.0e-6
}

fn with_id() -> ExportOptions {
    ExportOptions { device_id: Some(2_621_448), instance: None }
}

/// Our static cubics, beside the files.
fn cubics(calibration: &Calibration) -> Vec<Cubic> {
    calibration.axes.values().map(Cubic::of).collect()
}

fn temperatures() -> impl Iterator<Item = f64> {
    (-300..=900).map(|tenth| f64::from(tenth) / 10.0)
}

#[test]
fn px4s_formula_on_the_written_file_gives_our_static_cubic() {
    let calibration = three_axes();
    let written = export(&calibration, Format::Px4, &with_id()).unwrap();
    let parameters = read_px4(&written.text);
    assert_eq!(parameters["TC_G_ENABLE"], 1.0);
    assert_eq!(parameters["TC_G0_ID"], 2_621_448.0);
    for (place, cubic) in cubics(&calibration).iter().enumerate() {
        let mut furthest = 0.0_f64;
        for temperature in temperatures() {
            let theirs = f64::from(px4_offset(&parameters, "G0", place, temperature as f32));
            furthest = furthest.max((theirs - cubic.evaluate(temperature)).abs());
        }
        assert!(furthest < 1e-7, "axis {place}: {furthest} rad/s");
    }
}

#[test]
fn ardupilots_formula_on_the_written_file_gives_our_static_cubic_up_to_a_constant() {
    let calibration = three_axes();
    for (format, between) in [(Format::ArduPilot, ' '), (Format::MethodicConfigurator, ',')] {
        let written = export(&calibration, format, &ExportOptions::default()).unwrap();
        let parameters = read_ardupilot(&written.text, between);
        assert_eq!(parameters["INS_TCAL1_ENABLE"], 1.0);
        assert_eq!(parameters.len(), 3 + 9, "no accelerometer was calibrated, and none is written");
        for (cubic, letter) in cubics(&calibration).iter().zip(['X', 'Y', 'Z']) {
            let difference = |temperature: f64| {
                f64::from(ardupilot_polynomial(&parameters, 1, "GYR", letter, temperature as f32))
                    - cubic.evaluate(temperature)
            };
            let constant = difference(35.0);
            let furthest = temperatures().map(|t| (difference(t) - constant).abs()).fold(0.0, f64::max);
            assert!(furthest < 1e-7, "axis {letter}: {furthest} rad/s");
        }
    }
}

#[test]
fn a_cubic_is_exported_as_it_is_and_a_richer_curve_as_the_nearest_cubic() {
    let calibration = three_axes();
    let cubics = cubics(&calibration);
    let furthest = |place: usize, name: &str| {
        let drift = calibration.axes[name].drift();
        temperatures().map(|t| (cubics[place].evaluate(t) - drift.evaluate(t).0).abs()).fold(0.0, f64::max)
    };
    assert!(furthest(1, "gyro0.y") < 1e-15, "Y is a cubic");
    assert!(furthest(0, "gyro0.x") > 1e-4, "X is of order 5");
    // No other cubic is nearer in the mean square: moving any coefficient makes it worse.
    let drift = calibration.axes["gyro0.x"].drift();
    let squares = |cubic: &Cubic| {
        let inside = temperatures().filter(|t| (-17.5..=74.0).contains(t));
        inside.map(|t| (cubic.evaluate(t) - drift.evaluate(t).0).powi(2)).sum::<f64>()
    };
    let best = squares(&cubics[0]);
    for power in 0..4 {
        for sign in [-1.0, 1.0] {
            let mut moved = cubics[0].clone();
            moved.coefficients[power] += sign * 3e-4 / 46_f64.powi(i32::try_from(power).unwrap());
            assert!(squares(&moved) > best, "{power} {sign}");
        }
    }
}

#[test]
fn values_survive_a_round_trip_to_the_last_bit_of_a_single() {
    let calibration = three_axes();
    let written = export(&calibration, Format::Px4, &with_id()).unwrap();
    let parameters = read_px4(&written.text);
    let sensor = &written.sensors[0];
    let axis = sensor.axes[0].as_ref().unwrap();
    for power in 0..4 {
        assert_eq!(parameters[&format!("TC_G0_X{power}_0")], axis.cubic.coefficients[power] as f32);
    }
    assert_eq!(f64::from(parameters["TC_G0_TMIN"]), sensor.range[0]);
    assert_eq!(f64::from(parameters["TC_G0_TREF"]), axis.cubic.reference);
    let written = export(&calibration, Format::ArduPilot, &ExportOptions::default()).unwrap();
    let parameters = read_ardupilot(&written.text, ' ');
    let axis = written.sensors[0].axes[2].as_ref().unwrap();
    for power in 1..4 {
        let read = f64::from(parameters[&format!("INS_TCAL1_GYR{power}_Z")]);
        assert!((read - 1e6 * axis.cubic.coefficients[power]).abs() <= 6e-8 * read.abs() + 1e-9);
    }
}

#[test]
fn rates_in_degrees_are_turned_to_radians_and_a_missing_axis_is_left_at_zero() {
    let line = drift(&[1.0, 0.5], false, 0.0, 40.0);
    let calibration = calibration(vec![("gyro_z", axis(line, RateUnit::Dps))]);
    let written = export(&calibration, Format::Px4, &with_id()).unwrap();
    let parameters = read_px4(&written.text);
    assert!((px4_offset(&parameters, "G0", 2, 40.0) - 1.5_f32.to_radians()).abs() < 1e-8);
    assert_eq!(px4_offset(&parameters, "G0", 0, 40.0), 0.0);
    assert!(written.notes.iter().any(|note| note.contains("gyro 0 X: not calibrated")), "{:?}", written.notes);
    assert!(
        written.text.lines().all(|line| line.starts_with('#') || line.split('\t').count() == 5),
        "one line a comment"
    );
}

#[test]
fn sensors_have_places_of_their_own() {
    let line = |slope: f64| axis(drift(&[0.0, slope], false, 0.0, 40.0), RateUnit::RadPerS);
    let two = calibration(vec![("gyro0.x", line(1e-3)), ("gyro1.x", line(2e-3))]);
    let written = export(&two, Format::ArduPilot, &ExportOptions::default()).unwrap();
    let parameters = read_ardupilot(&written.text, ' ');
    let difference = |imu| {
        ardupilot_polynomial(&parameters, imu, "GYR", 'X', 40.0)
            - ardupilot_polynomial(&parameters, imu, "GYR", 'X', 0.0)
    };
    assert!((difference(1) - 2e-3).abs() < 1e-8 && (difference(2) - 4e-3).abs() < 1e-8);
    // `AP_InertialSensor_Params.cpp`: from the fourth IMU on each has a group of its own.
    let later = calibration(vec![("gyro3.x", line(1e-3)), ("gyro4.x", line(2e-3))]);
    let written = export(&later, Format::ArduPilot, &ExportOptions::default()).unwrap().text;
    let set = |name: &str| -> f64 {
        let line = written.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
        line.unwrap_or_else(|| panic!("{name} in {written}")).parse().unwrap()
    };
    // Slopes of 1e-3 over a half span of 20 C, in millionths.
    assert!((set("INS4_TCAL_GYR1_X") - 50.0).abs() < 1e-6 && (set("INS5_TCAL_GYR1_X") - 100.0).abs() < 1e-6);
    assert!((set("INS4_TCAL_ENABLE") - 1.0).abs() < 1e-12 && (set("INS5_TCAL_TMAX") - 40.0).abs() < 1e-6);
    assert!(written.contains("INS4_TCAL_ACC1_X to ACC3_Z stay") && !written.contains("INS_TCAL"), "{written}");
    let sixth = calibration(vec![("gyro5.x", line(1e-3))]);
    let refused = export(&sixth, Format::ArduPilot, &ExportOptions::default()).unwrap_err();
    assert!(matches!(refused, ExportError::NoPlace { places: 5, .. }));
}

#[test]
fn one_device_id_is_not_given_to_two_parts() {
    let line = || axis(drift(&[0.0, 1e-3], false, 0.0, 40.0), RateUnit::RadPerS);
    let two = calibration(vec![("gyro0.x", line()), ("gyro1.x", line())]);
    let refused = export(&two, Format::Px4, &with_id()).unwrap_err();
    assert_eq!(refused, ExportError::OneIdForSeveral { sensors: "gyro 0, gyro 1".to_owned() });
    assert!(export(&calibration(vec![("gyro0.x", line())]), Format::Px4, &with_id()).is_ok());
}

#[test]
fn another_autopilots_log_is_told_of_in_the_file() {
    let line = axis(drift(&[0.0, 1e-3], false, 0.0, 40.0), RateUnit::RadPerS);
    let mut own = calibration(vec![("gyro0.x", line)]);
    own.sources[0].content = "px4-log".to_owned();
    let told = |format| export(&own, format, &with_id()).unwrap().text.contains("the log is PX4's");
    assert_eq!([Format::Px4, Format::ArduPilot, Format::MethodicConfigurator].map(told), [false, true, true]);
}

/// The name is that of the calibration's own list of candidates, which `fit` shows.
#[test]
fn a_model_is_named_as_its_fit_names_it_and_what_no_format_holds_is_told() {
    let mut own = three_axes();
    let fit = &mut own.axes.get_mut("gyro0.y").unwrap().fit;
    fit.model.time_drift = Some(TimeDrift::straight(1e-7, 2000.0));
    let candidate = r#"{"model": "poly:3 + time", "in_sample_rms": 1e-4, "chosen": true}"#;
    fit.statistics.candidates = vec![serde_json::from_str(candidate).unwrap()];
    for format in Format::ALL {
        let written = export(&own, format, &with_id()).unwrap();
        let notes: Vec<&String> = written.notes.iter().filter(|note| note.contains("drift in time")).collect();
        let [note] = notes[..] else { panic!("{format}: {:?}", written.notes) };
        assert!(note.contains("gyro0.y is not exported"), "{note}");
        assert_eq!(written.text.contains("poly:3 + time"), format != Format::Csv, "{format}");
        assert!(export(&three_axes(), format, &with_id()).unwrap().notes.iter().all(|other| other != note));
    }
}

#[test]
fn a_cubic_that_is_better_than_the_model_is_not_told_as_a_loss() {
    let (model, cubic) = ("table:16".to_owned(), Cubic { reference: 0.0, coefficients: [0.0; 4], range: [0.0, 1.0] });
    let cost = |chosen_rms, cubic_rms| {
        let loss = Loss {
            chosen_rms: Some(chosen_rms),
            cubic_rms: Some(cubic_rms),
            furthest: 0.0,
            over_whole_log: true,
            chosen_by: None,
        };
        let (name, measured) = ("x".to_owned(), cubic.range);
        ExportedAxis { name, model: model.clone(), cubic: cubic.clone(), loss, has_history: false, measured }
            .cost(RateScale::own(RateUnit::RadPerS))
    };
    assert_eq!(
        cost(1.0e-3, 0.8e-3),
        "this cubic leaves 8.000e-4 rad/s rms of a whole log, held out, its zero taken at the start, 20 % less than the chosen table:16 (0.001000)"
    );
    assert_eq!(
        cost(1.0e-3, 1.5e-3),
        "this cubic leaves 0.001500 rad/s rms of a whole log, held out, its zero taken at the start, 50 % more than the chosen table:16 (0.001000)"
    );
}

#[test]
fn temperatures_without_a_rate_over_which_a_cubic_holds_are_told() {
    let told = |min, max| {
        let mut own = three_axes();
        let fit = &mut own.axes.get_mut("gyro0.x").unwrap().fit;
        let (drift, in_sample) = (fit.model.drift.clone(), fit.statistics.in_sample);
        fit.static_cubic = Some(StaticCubic { drift, in_sample, held_out: None, deployed: None });
        fit.measured = ValidRange::new(min, max).unwrap();
        let written = export(&own, Format::Px4, &with_id()).unwrap();
        written.notes.into_iter().find(|note| note.contains("without a rate"))
    };
    let ends = three_axes().axes["gyro0.x"].fit.model.drift.valid;
    assert_eq!(told(ends.min(), ends.max()), None);
    let note = told(ends.min() + 4.0, ends.max()).expect("a note");
    let wanted = format!("from there to {:.2} C the log has temperatures without a rate", ends.min());
    assert!(note.starts_with("gyro 0 X: rates were measured from") && note.contains(&wanted), "{note}");
}

#[test]
fn what_an_autopilot_cannot_hold_is_refused_with_what_to_do() {
    let line = |unit| axis(drift(&[0.0, 1.0], false, 0.0, 40.0), unit);
    let refused = |axes, format| export(&calibration(axes), format, &ExportOptions::default()).unwrap_err().to_string();
    assert!(refused(vec![("gyro_x", line(RateUnit::RadPerS))], Format::Px4).contains("`device_id`"));
    assert!(refused(vec![("gyro_x", line(RateUnit::Counts))], Format::ArduPilot).contains("in counts"));
    assert!(refused(vec![("rate", line(RateUnit::Dps))], Format::ArduPilot).contains("x, y or z"));
    let both = vec![("gyro_x", line(RateUnit::Dps)), ("x_dps", line(RateUnit::Dps))];
    assert!(refused(both, Format::ArduPilot).contains("both axis X"));
    assert!(refused(Vec::new(), Format::C).contains("no axis"));
    assert!("ulog".parse::<Format>().unwrap_err().to_string().contains("px4, ardupilot"));
}

#[test]
fn the_json_and_the_table_hold_the_same_curves() {
    let mut calibration = three_axes();
    // Two hundred steps from the one to the other end a rounding beyond it.
    let measured = ValidRange::new(-20.006, 59.805).unwrap();
    calibration.axes.values_mut().for_each(|axis| axis.fit.measured = measured);
    let written = export(&calibration, Format::Json, &ExportOptions::default()).unwrap();
    let json: serde_json::Value = serde_json::from_str(&written.text).unwrap();
    let y = &json["sensors"][0]["axes"][1]["cubic"];
    let (c, reference) = (&y["coefficients"], y["reference"].as_f64().unwrap());
    let d = 20.0 - reference;
    let at = (0..4).map(|k| c[k].as_f64().unwrap() * d.powi(i32::try_from(k).unwrap())).sum::<f64>();
    assert!((at - calibration.axes["gyro0.y"].drift().evaluate(20.0).0).abs() < 1e-12);
    let written = export(&calibration, Format::Csv, &ExportOptions::default()).unwrap();
    let mut rows = csv::Reader::from_reader(written.text.as_bytes());
    assert_eq!(&rows.headers().unwrap()[1], "gyro0.x bias, rad/s");
    let mut count = 0;
    for row in rows.records() {
        let row: Vec<f64> = row.unwrap().iter().map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(row[3], calibration.axes["gyro0.z"].drift().evaluate(row[0]).0);
        count += 1;
    }
    assert_eq!(count, 201);
}

#[test]
fn a_guessed_unit_and_one_direction_go_where_the_parameters_go() {
    let told = [
        "'gx' names no unit: taken as rad/s (`rate_unit` says otherwise)",
        "the temperature only rises: the log says nothing of hysteresis, and more",
    ];
    let mut calibration = three_axes();
    calibration.warnings = told.map(str::to_owned).to_vec();
    calibration.warnings.push("something else".to_owned());
    let options = ExportOptions { device_id: Some(7), instance: Some(0) };
    for format in Format::ALL {
        let exported = export(&calibration, format, &options).unwrap();
        for sentence in told {
            let sentence = format!("of the log that was fitted: {sentence}");
            assert!(exported.notes.contains(&sentence), "{format}: {:?}", exported.notes);
            // A table has no place for it.
            assert!(format == Format::Csv || exported.text.contains(&sentence), "{format}: {}", exported.text);
        }
        assert!(!exported.notes.iter().any(|note| note.contains("something else")));
    }
}

#[test]
fn no_sensor_has_the_id_0() {
    let none = ExportOptions { device_id: Some(0), instance: None };
    assert!(matches!(export(&three_axes(), Format::Px4, &none), Err(ExportError::NoDeviceId { .. })));
}
