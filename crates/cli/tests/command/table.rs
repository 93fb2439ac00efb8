//! Tables as people have them: in other units, packed, cut, with commas for points.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::process::{Command, Stdio};

use crate::fit::column;
use crate::log::{Log, parabola};
use crate::{Ran, folder_with, zerorate};

/// The synthetic log as CSV with other names, its temperature and rates in other units.
fn csv(names: &str, temperature: fn(f64) -> f64, factor: f64) -> String {
    let log = Log::cycle();
    let mut text = format!("{names}\n");
    for row in 0..log.time_s.len() {
        let [x, y] = [0, 1].map(|axis| log.rates[axis][row] * factor);
        writeln!(text, "{},{},{x},{y}", log.time_s[row], temperature(log.temperature_c[row])).unwrap();
    }
    text
}

fn fit(log: impl AsRef<[u8]>, options: &[&str]) -> Ran {
    let folder = folder_with("log", log);
    zerorate(folder.path(), &[&["fit", "log", "--json"], options].concat())
}

/// The synthetic log's noise and range, which do not depend on how they were written.
#[track_caller]
fn is_of_the_log(ran: &Ran, in_rad_s: f64) {
    assert_eq!(ran.code, 0, "{}", ran.err);
    let json = ran.json();
    let axis = json["axes"].as_object().unwrap().values().next().unwrap();
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    // The drift is a parabola; what is left is noise, uniform over 1 mrad/s, in averages of 21 rows.
    let noise = in_rad_s * number(&axis["held_out"]["rms"]);
    assert!((noise / (1e-3 / 12.0_f64.sqrt() / 21.0_f64.sqrt()) - 1.0).abs() < 0.2, "{noise}");
    assert_eq!(axis["temperature_unit"], "C");
    let range = [0, 1].map(|end| number(&axis["temperature"][end]));
    // By the cosine -17 to 73; a curve is believed up to an eighth beyond.
    assert!(range[0] < -16.9 && range[0] > -30.0 && range[1] > 72.9 && range[1] < 86.0, "{range:?}");
}

#[test]
fn what_a_name_says_of_its_unit_is_converted_where_it_is_read() {
    let degrees = 1.0_f64.to_degrees();
    for (names, temperature, factor, in_rad_s) in [
        ("t_s,temp_F,x_rad_s,y_rad_s", (|c| 1.8 * c + 32.0) as fn(f64) -> f64, 1.0, 1.0),
        ("t_s,temperature [K],gyro_x_mdps,gyro_y_mdps", |c| c + 273.15, 1e3 * degrees, 1.0 / degrees),
        ("t_s,temp_c,x [°/h],y [°/h]", |c| c, 3600.0 * degrees, 1.0 / degrees),
        ("t_s,temp_c,x_mrad_s,y_mrad_s", |c| c, 1e3, 1.0),
    ] {
        let ran = fit(csv(names, temperature, factor), &[]);
        is_of_the_log(&ran, in_rad_s);
        assert_eq!(ran.json()["verdict"], "good", "{names}");
    }
}

#[test]
fn temperatures_that_can_be_no_celsius_ask_for_their_unit() {
    let kelvin = csv("t_s,temperature,x_rad_s,y_rad_s", |c| c + 273.15, 1.0);
    fit(&kelvin, &[]).is_error(&["column 'temperature' goes from 256 to 346", "--temperature-unit kelvin"]);
    is_of_the_log(&fit(&kelvin, &["--temperature-unit", "kelvin"]), 1.0);
    is_of_the_log(&fit(&kelvin, &["--temperature-unit", "K"]), 1.0);
    // And one that is said, and cannot be true.
    fit(&kelvin, &["--temperature-unit", "C"]).is_error(&["which no gyro sees in degrees C"]);
    // An option is of all logs: what is said of one of them may be wrong of another.
    let celsius = csv("t_s,temperature,x_rad_s,y_rad_s", |c| c, 1.0);
    let folder = folder_with("kelvin.csv", &kelvin);
    fs::write(folder.path().join("celsius.csv"), celsius).unwrap();
    let both = ["fit", "kelvin.csv", "celsius.csv"];
    zerorate(folder.path(), &both).is_error(&["kelvin.csv", "--temperature-unit kelvin", "convert it"]);
    zerorate(folder.path(), &[&both[..], &["--temperature-unit", "kelvin"]].concat()).is_error(&[
        "celsius.csv",
        "from -17 to 73, which no gyro sees in kelvin",
        "--temperature-unit celsius",
        "convert it where another log is in another",
    ]);
}

#[test]
fn a_column_in_two_units_of_temperature_is_told_to_be() {
    let mixed = csv("t_s,temperature,x_rad_s,y_rad_s", |c| if c > 30.0 { c + 273.15 } else { c }, 1.0);
    let ran = fit(&mixed, &[]);
    ran.is_error(&["goes from -17 to 346", "it seems to be in two units: convert it to degrees C"]);
    assert!(!ran.err.contains("fahrenheit"), "{}", ran.err);
}

#[test]
fn temperatures_that_may_be_fahrenheits_are_a_warning_and_those_of_a_chamber_a_note() {
    // 23 to 131 degrees Fahrenheit, -5 to 55 C.
    let fahrenheit = |c: f64| 23.0 + (c + 17.0) * 108.0 / 90.0;
    let ran = fit(csv("t_s,temp,x_rad_s,y_rad_s", fahrenheit, 1.0), &[]);
    let json = ran.json();
    assert_eq!((ran.code, &json["verdict"]), (0, &"warning".into()), "{}", ran.err);
    let reasons = json["reasons"].as_array().unwrap();
    let doubt = reasons.iter().find(|reason| reason["kind"] == "guessed-unit").expect("a doubt");
    assert!(doubt["text"].as_str().unwrap().starts_with("'temp' goes up to 131, and few gyros are rated"), "{doubt}");
    let told = fit(csv("t_s,temp,x_rad_s,y_rad_s", fahrenheit, 1.0), &["--temperature-unit", "celsius"]).json();
    assert_eq!(told["verdict"], "good", "who says it is believed: {told}");
    let chamber = fit(csv("t_s,temp,x_rad_s,y_rad_s", |c| c + 12.0, 1.0), &[]).json();
    assert_eq!((&chamber["verdict"], chamber["reasons"].as_array().unwrap().len()), (&"good".into(), 1), "{chamber}");
}

#[test]
fn a_guess_that_the_numbers_speak_against_is_refused_and_asked_about() {
    // A drift of 2 deg/s, peak to peak: in rad/s nobody's gyro.
    let bare = csv("t_s,temp_c,gx,gy", |c| c, 100.0);
    fit(&bare, &[]).is_error(&["column 'gx' names no unit", "would never rest", "--rate-unit dps"]);
    let given = fit(&bare, &["--rate-unit", "dps"]);
    assert_eq!((given.code, given.json()["axes"]["gx"]["rate_unit"].as_str()), (0, Some("dps")));
}

#[test]
fn what_is_cut_in_its_last_line_is_read_without_it_and_warned_about() {
    let log = Log::cycle().csv();
    for cut in [1, 5, 15] {
        let ran = fit(&log[..log.len() - cut], &[]);
        let json = ran.json();
        assert_eq!((ran.code, json["verdict"].as_str()), (0, Some("warning")), "{}", ran.err);
        assert_eq!(json["reasons"][0]["kind"], "truncated");
        assert!(json["reasons"][0]["text"].as_str().unwrap().contains("line 8401"));
        assert_eq!(json["axes"]["x_rad_s"]["samples_used"], 8399);
    }
}

#[test]
fn tables_are_read_as_people_write_them() {
    let log = Log::cycle().csv();
    is_of_the_log(&fit(log.replace(',', ";").replace('.', ","), &[]), 1.0);
    is_of_the_log(&fit(format!("# chamber 3\n# by hand\n{log}"), &[]), 1.0);
    let units = log.replacen("t_s,temperature_c,x_rad_s,y_rad_s\n", "time,temp,x,y\ns,°C,rad/s,rad/s\n", 1);
    let ran = fit(units, &[]);
    is_of_the_log(&ran, 1.0);
    assert_eq!(ran.json()["verdict"], "good");
}

#[test]
fn a_log_that_gzip_packed_is_fitted_applied_and_told() {
    let gzip = Command::new("gzip").arg("-c").stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
    let Ok(mut gzip) = gzip else { return eprintln!("skipped: there is no gzip") };
    let mut input = gzip.stdin.take().unwrap();
    let writer = std::thread::spawn(move || input.write_all(Log::cycle().csv().as_bytes()).unwrap());
    let packed = gzip.wait_with_output().unwrap().stdout;
    writer.join().unwrap();
    is_of_the_log(&fit(&packed, &[]), 1.0);
    let folder = folder_with("log.csv.gz", &packed);
    let run = |arguments: &[&str]| {
        let ran = zerorate(folder.path(), arguments);
        assert_eq!(ran.code, 0, "{}", ran.err);
        ran
    };
    run(&["fit", "log.csv.gz", "--out", "c.json"]);
    run(&["apply", "c.json", "log.csv.gz", "--out", "out.csv"]).says(&["8400 rows"]);
    run(&["info", "log.csv.gz"]).says(&["log.csv.gz: a log, 8400 rows"]);
    fs::write(folder.path().join("cut.gz"), &packed[..packed.len() / 2]).unwrap();
    zerorate(folder.path(), &["fit", "cut.gz"])
        .is_error(&["the packed file ends before its contents", "copy it again"]);
}

#[test]
fn several_gyros_of_one_table_are_fitted_each_by_itself() {
    let log = Log::cycle();
    let mut text = "t_s,gyro0_x_dps,gyro0_y_dps,temp0_c,gyro1_x_dps,gyro1_y_dps,temp1_c\n".to_owned();
    for row in 0..log.time_s.len() {
        let (t, [x, y]) = (log.temperature_c[row], [0, 1].map(|axis| log.rates[axis][row]));
        writeln!(text, "{},{x},{y},{t},{y},{x},{}", log.time_s[row], t - 10.0).unwrap();
    }
    let folder = folder_with("log.csv", text);
    let json = zerorate(folder.path(), &["fit", "log.csv", "--out", "c.json", "--json"]).json();
    let axes = json["axes"].as_object().unwrap();
    assert_eq!(axes.len(), 4);
    let middle = |axis: &str| {
        let range = &axes[axis]["temperature"];
        f64::midpoint(range[0].as_f64().unwrap(), range[1].as_f64().unwrap())
    };
    assert!((middle("gyro0_x_dps") - middle("gyro1_x_dps") - 10.0).abs() < 0.1, "each by its own temperature");
    // Each range is told of those that have it, on the screen and on the page, and no range that none has.
    let ran = zerorate(folder.path(), &["fit", "log.csv", "--out", "c.json", "--report", "r.html", "--force"]);
    let page = std::fs::read_to_string(folder.path().join("r.html")).unwrap();
    for (told, degree) in [(ran.out.replace('\n', " "), "C"), (page, "°C")] {
        let of_first = format!("-17.0 to 73.0 {degree} (gyro0_x_dps, gyro0_y_dps)");
        let of_second = format!("-27.0 to 63.0 {degree} (gyro1_x_dps, gyro1_y_dps)");
        assert!(told.contains(&format!("{of_first} and {of_second}")), "{told}");
        assert!(!told.contains(&format!("-27.0 to 73.0 {degree}")), "{told}");
    }
    let one = zerorate(folder.path(), &["fit", "log.csv", "--sensor", "gyro1", "--json"]).json();
    assert_eq!(one["axes"].as_object().unwrap().keys().collect::<Vec<_>>(), ["gyro1_x_dps", "gyro1_y_dps"]);
    let applied = zerorate(folder.path(), &["apply", "c.json", "log.csv", "--out", "out.csv"]);
    assert_eq!(applied.code, 0, "{}", applied.err);
    let rms = |name: &str| {
        let values = column(&folder.path().join("out.csv"), name);
        (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
    };
    assert!(rms("corrected_gyro0_x_dps") < 4e-4 && rms("corrected_gyro1_y_dps") < 4e-4);
}

#[test]
fn a_correction_stays_in_the_unit_of_its_column() {
    let folder = folder_with("log.csv", csv("t_s,temp_F,x_mdps,y_mdps", |c| 1.8 * c + 32.0, 1e3));
    assert_eq!(zerorate(folder.path(), &["fit", "log.csv", "--out", "c.json"]).code, 0);
    let ran = zerorate(folder.path(), &["apply", "c.json", "log.csv", "--out", "out.csv"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    let predicted = column(&folder.path().join("out.csv"), "predicted_x_mdps");
    let first_c = Log::cycle().temperature_c[0];
    assert!((predicted[0] / (1e3 * parabola(first_c)) - 1.0).abs() < 0.02, "{}", predicted[0]);
}

#[test]
fn a_hole_in_time_is_named_with_its_place_and_how_long_it_is() {
    let log = Log::cycle();
    let both = [log.rows(0..2403), log.rows(4443..8400)];
    let csv = both[0].csv() + both[1].csv().split_once('\n').unwrap().1;
    let json = fit(csv, &[]).json();
    assert_eq!((json["reasons"].as_array().unwrap().len(), &json["reasons"][0]["kind"]), (1, &"gap".into()), "{json}");
    let text = json["reasons"][0]["text"].as_str().unwrap();
    assert!(
        text.starts_with("nothing was logged for 17 min, from 1201 s to 2222 s, between rows 2403 and 2404, at "),
        "{text}"
    );
}

#[test]
fn without_a_time_column_a_place_is_told_by_its_rows() {
    let mut log = Log::cycle();
    (5000..5060).for_each(|row| log.rates[0][row] += 2.0);
    let text: String = log.csv().lines().map(|line| line.split_once(',').unwrap().1.to_owned() + "\n").collect();
    let folder = folder_with("log.csv", text);
    let ran = zerorate(folder.path(), &["fit", "log.csv", "--explain", "--out", "c.json", "--report", "r.html"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    ran.says(&["the unit was moved in rows ", "in averages over about 21 rows", "its zero in the first average"]);
    let page = fs::read_to_string(folder.path().join("r.html")).unwrap();
    assert!(page.contains("in averages over about 21 rows"));
    let verified = zerorate(folder.path(), &["verify", "log.csv", "--with", "c.json", "--in-sample"]);
    verified.says(&["the run's first average"]);
    // A page names what is typed.
    assert!(page.contains("no time column was found (--time says which)"), "{page}");
    for text in [ran.out, page, verified.out] {
        let told = ["NaN", "about 10 s", "half minute"].into_iter().find(|part| text.contains(part));
        assert_eq!(told, None, "of a log without times: {text}");
    }
}

#[test]
fn a_time_that_does_not_move_is_no_time() {
    let mut log = Log::cycle();
    log.time_s.fill(5.0);
    let folder = folder_with("log.csv", log.csv());
    let ran = zerorate(folder.path(), &["fit", "log.csv"]);
    ran.says(&["in averages over about 21 rows", "does not move: taken as no time (--time names another column)"]);
}

#[test]
fn the_model_s_figures_have_digits_in_any_unit() {
    let folder = folder_with("log.csv", Log::cycle().csv());
    let ran = zerorate(folder.path(), &["fit", "log.csv", "--units", "rad/s"]);
    let row = ran.out.lines().skip_while(|line| !line.starts_with("Model, and what it leaves")).nth(3).unwrap();
    let figures = row.split_whitespace().rev().take(4).map(|figure| figure.parse::<f64>().unwrap());
    assert!(figures.into_iter().all(|figure| figure > 0.0), "{row}");
}
