use std::fs;

use crate::log::Log;
use crate::{bench, folder_with, zerorate};

#[test]
fn the_report_made_again_is_the_one_that_fit_made() {
    for options in [&[][..], &["--plain", "--model", "poly:3"], &["--model", "table:6"]] {
        let folder = folder_with("log.csv", Log::cycle().csv());
        let fit = ["fit", "log.csv", "--out", "calibration.json"];
        assert_eq!(zerorate(folder.path(), &[&fit, options].concat()).code, 0);
        assert_eq!(zerorate(folder.path(), &[&["fit", "log.csv", "--report", "first.html"], options].concat()).code, 0);
        let ran = zerorate(folder.path(), &["report", "."]);
        assert_eq!(ran.code, 0, "{}", ran.err);
        ran.says(&["report.html, from "]);
        let read = |name| fs::read_to_string(folder.path().join(name)).unwrap();
        assert!(read("report.html") == read("first.html"), "another report, with {options:?}");
    }
}

#[test]
fn another_log_than_the_calibrations_own_is_refused() {
    let folder = folder_with("log.csv", Log::cycle().csv());
    zerorate(folder.path(), &["fit", "log.csv", "--out", "calibration.json"]);
    fs::write(folder.path().join("report.html"), "earlier").unwrap();
    fs::write(folder.path().join("other.csv"), "t_s,temperature_c,x_rad_s,y_rad_s\n").unwrap();
    zerorate(folder.path(), &["report", "calibration.json", "--log", "other.csv"])
        .is_error(&["other.csv: not the log", "SHA-256"]);
    fs::remove_file(folder.path().join("log.csv")).unwrap();
    zerorate(folder.path(), &["report", "calibration.json"])
        .is_error(&["log.csv: cannot be read", "--log says where it is"]);
    assert_eq!(fs::read_to_string(folder.path().join("report.html")).unwrap(), "earlier");
}

#[test]
fn a_boards_calibration_is_refused_with_the_reason() {
    let folder = folder_with("calibration.json", bench::calibration());
    zerorate(folder.path(), &["report", "."]).is_error(&["the calibration of an analogue board"]);
    zerorate(folder.path(), &["report", "nothing"]).is_error(&["nothing: cannot be read"]);
}
