use crate::log::Log;
use crate::{folder_with, zerorate};

#[test]
fn a_ramp_has_sensitivities_and_its_noise_is_refused_but_not_its_residuals() {
    let folder = folder_with("log.csv", Log::cycle().csv());
    let ran = zerorate(folder.path(), &["characterise", "log.csv"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    ran.says(&["Noise of the longest soak", "Sensitivities of the bias", "x_rad_s"]);
    assert_eq!(zerorate(folder.path(), &["fit", "log.csv", "--out", "calibration.json"]).code, 0);
    let ran = zerorate(folder.path(), &["characterise", "log.csv", "--with", "calibration.json", "--json"]);
    let json = ran.json();
    assert_eq!((ran.code, &json["noise"][0]["of"]), (0, &"residual".into()));
    let points = json["noise"][0]["noise"]["points"].as_array().unwrap();
    assert!(points.len() > 10 && points[0]["tau_s"].as_f64().unwrap() > 0.0);
    assert!(json["sensitivities"][0]["temperature_sensitivity"]["mean"].is_f64());
}

#[test]
fn a_log_at_rest_tells_its_noise() {
    let rows: String = (0..4000_u64)
        .scan(42_u64, |n, row| {
            *n = 16_807 * *n % 2_147_483_647;
            let noise = *n as f64 / 2_147_483_647.0 - 0.5;
            Some(format!("{},25.0,{noise}\n", row as f64 / 10.0))
        })
        .collect();
    let folder = folder_with("soak.csv", format!("time_s,temperature_c,gyro_x_dps\n{rows}"));
    let ran = zerorate(folder.path(), &["characterise", "soak.csv"]);
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    // 0.289 dps a sample at 10 Hz: 0.0913 deg/s a root hertz, 5.5 deg a root hour.
    ran.says(&["gyro_x_dps  5.", "deg/rt-h", "4000"]);
    let other = folder_with("empty.csv", "time_s,temperature_c,gyro_x_dps\n0,25,1\n1,25,1\n");
    let ran = zerorate(other.path(), &["characterise", "empty.csv"]);
    assert_eq!(ran.code, 1, "{}{}", ran.out, ran.err);
}

/// A converter whose step is as large as the noise: the warning of the text stands in the JSON, as every one does.
#[test]
fn what_the_text_warns_of_stands_in_the_json() {
    let rows: String = (0..4000_u64)
        .scan(42_u64, |n, row| {
            *n = 16_807 * *n % 2_147_483_647;
            let noise = 0.12 * (*n as f64 / 2_147_483_647.0 - 0.5);
            let rate = 0.1 * (noise / 0.1).round();
            Some(format!("{},25.0,{rate}\n", row as f64 / 10.0))
        })
        .collect();
    let folder = folder_with("soak.csv", format!("time_s,temperature_c,gyro_x_dps\n{rows}"));
    let text = zerorate(folder.path(), &["characterise", "soak.csv"]).out;
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let json = zerorate(folder.path(), &["characterise", "soak.csv", "--json"]).json();
    let warnings: Vec<&str> = json["warnings"].as_array().unwrap().iter().filter_map(|told| told.as_str()).collect();
    let step = "gyro_x_dps: the rate comes in steps of 0.1000 dps, as large as its noise";
    assert!(warnings.iter().any(|told| told.starts_with(step)), "{warnings:?}");
    warnings.iter().for_each(|told| assert!(words(&text).contains(&words(told)), "{told} is not in {text}"));
}

/// The calibration's axes are found by what they measure, in whatever unit: N of the residuals is that of the noise.
#[test]
fn the_residuals_of_a_log_in_another_unit_are_those_of_the_same_axes() {
    let log = Log::cycle();
    let folder = folder_with("log.csv", log.csv());
    assert_eq!(zerorate(folder.path(), &["fit", "log.csv", "--out", "calibration.json"]).code, 0);
    let mut text = "t_s,temp_c,gyro_x_mdps,gyro_y_mdps\n".to_owned();
    for row in 0..log.time_s.len() {
        let [x, y] = [0, 1].map(|axis| 1e3 * log.rates[axis][row].to_degrees());
        text += &format!("{},{},{x},{y}\n", log.time_s[row], log.temperature_c[row]);
    }
    std::fs::write(folder.path().join("other.csv"), text).unwrap();
    let ran = zerorate(folder.path(), &["characterise", "other.csv", "--with", "calibration.json", "--json"]);
    let json = ran.json();
    assert_eq!(json["noise"][0]["name"], "gyro_x_mdps", "{}", ran.err);
    let n = json["noise"][0]["noise"]["coefficients"]["angle_random_walk"]["value"].as_f64().unwrap();
    // Uniform over 1 mrad/s, two rows a second; a table in mdps is of dps.
    let truth = 1e-3_f64.to_degrees() / 12.0_f64.sqrt() / 2.0_f64.sqrt();
    assert!((n / truth - 1.0).abs() < 0.05, "{n} for {truth}");
}
