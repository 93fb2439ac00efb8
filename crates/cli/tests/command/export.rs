use std::fs;

use tempfile::TempDir;

use crate::log::Log;
use crate::{folder_with, zerorate};

fn calibrated() -> TempDir {
    let folder = folder_with("log.csv", Log::cycle().csv());
    let ran = zerorate(folder.path(), &["fit", "log.csv", "--out", "calibration.json"]);
    assert_eq!(ran.code, 0, "{}", ran.err);
    folder
}

#[test]
fn parameters_are_written_and_their_loss_is_told() {
    let folder = calibrated();
    let to = ["--device-id", "2621448", "--out", "vehicle.params"];
    let ran = zerorate(folder.path(), &[&["export", "calibration.json", "--format", "px4"], &to[..]].concat());
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    ran.says(&["Wrote vehicle.params, for px4.", "gyro 0, -17.0 to 73.0 C", "x_rad_s", "calibrate the gyros again"]);
    let text = fs::read_to_string(folder.path().join("vehicle.params")).unwrap();
    assert!(text.contains("1\t1\tTC_G0_ID\t2621448\t6\n") && text.contains("# gyro 0 X: "), "{text}");
}

#[test]
fn the_page_shows_the_very_text_that_export_writes_and_both_say_whose_axes_they_are_and_what_is_in_which_unit() {
    let folder = folder_with("flight.ulg", Log::cycle().ulg());
    let fit = ["fit", "flight.ulg", "--out", "calibration.json", "--report", "report.html", "--force"];
    let parameters = |units: &[&str]| {
        assert_eq!(zerorate(folder.path(), &[&fit[..], units].concat()).code, 0);
        let page = fs::read_to_string(folder.path().join("report.html")).unwrap().replace("&gt;", ">");
        for format in ["px4", "ardupilot", "methodic-configurator"] {
            let text = zerorate(folder.path(), &["export", "calibration.json", "--format", format]).out;
            assert!(page.contains(&text), "{format} on the page is not what export writes: {text}");
        }
        let text = zerorate(folder.path(), &["export", "calibration.json", "--format", "ardupilot"]).out;
        assert!(text.contains("# the log is PX4's and these are ArduPilot's parameters: axes"), "{text}");
        text.lines().map(str::to_owned).partition::<Vec<_>, _>(|line| line.starts_with('#'))
    };
    let (own_words, own) = parameters(&[]);
    let (words, asked) = parameters(&["--units", "deg/h"]);
    assert_eq!(own, asked, "parameters stay in the autopilot's unit");
    assert!(
        own_words
            .iter()
            .any(|line| line.ends_with("in the autopilot's own unit, rad/s; what they leave is told in mrad/s"))
    );
    assert!(words.iter().any(|line| line.ends_with("unit, rad/s; what they leave is told in deg/h")), "{words:#?}");
    assert!(!words.iter().any(|line| line.contains(" mrad/s") || line.contains(" rad/s rms")), "{words:#?}");
    let info = zerorate(folder.path(), &["info", "calibration.json"]);
    assert!(info.out.contains("pp, deg/h") && !info.out.contains("rad/s"), "{}", info.out);
    let again = ["report", "calibration.json", "--out", "again.html"];
    assert_eq!(zerorate(folder.path(), &again).code, 0);
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(read("again.html").contains("rate, deg/h") && !read("again.html").contains("mrad/s"));
}

#[test]
fn without_a_place_the_text_alone_is_on_standard_output() {
    let folder = calibrated();
    let ran = zerorate(folder.path(), &["export", "calibration.json", "--format", "methodic-configurator"]);
    assert_eq!(ran.code, 0);
    assert!(ran.out.lines().all(|line| line.starts_with('#') || line.starts_with("INS_TCAL1_")), "{}", ran.out);
    assert!(ran.out.contains("INS_TCAL1_ENABLE,1\n") && ran.err.contains("note: "));
    let table = zerorate(folder.path(), &["export", "calibration.json", "--format", "csv"]);
    assert!(table.out.starts_with("temperature_c,"), "{}", table.out);
}

#[test]
fn json_tells_what_was_written() {
    let folder = calibrated();
    let arguments = ["export", "calibration.json", "--format", "ardupilot", "--out", "tcal.parm", "--json"];
    let json = zerorate(folder.path(), &arguments).json();
    assert_eq!((&json["format"], &json["sensors"][0]["kind"]), (&"ardupilot".into(), &"gyro".into()));
    // The cubic is fitted by itself beside the parabola that was chosen: apart by the noise, 6e-5 a group.
    assert!(json["sensors"][0]["axes"][0]["loss"]["furthest"].as_f64().unwrap() < 6e-5);
}

#[test]
fn what_cannot_be_exported_is_an_error_that_says_what_to_do() {
    let folder = calibrated();
    zerorate(folder.path(), &["export", "calibration.json", "--format", "px4"]).is_error(&["device id", "--device-id"]);
    let wrong = zerorate(folder.path(), &["export", "calibration.json", "--format", "inav"]);
    assert_eq!(wrong.code, 2);
    wrong.says(&["'inav' is no format: give px4, ardupilot"]);
    let help = zerorate(folder.path(), &["export", "--help"]);
    assert!(!help.out.contains("rust"), "what there is no more is not offered: {}", help.out);
    zerorate(folder.path(), &["export", "none.json", "--format", "c"]).is_error(&["none.json: cannot be read"]);
}
