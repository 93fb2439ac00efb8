//! What is there already: another log's, another unit's, the user's. Nothing of it is lost unless it is given up.

use std::fs;
use std::path::Path;

use crate::log::Log;
use crate::{bench, folder_with, zerorate};

/// Two logs of the same names of columns, and a file of the user's.
fn folder() -> tempfile::TempDir {
    let log = Log::cycle();
    let folder = folder_with("a.csv", log.csv());
    fs::write(folder.path().join("b.csv"), log.rows(0..log.time_s.len() - 100).csv()).unwrap();
    fs::write(folder.path().join("mine.txt"), "mine, and no copy of it\n").unwrap();
    folder
}

fn read(folder: &Path, file: &str) -> Vec<u8> {
    fs::read(folder.join(file)).unwrap()
}

#[test]
fn a_fit_takes_its_own_places_again_and_no_other_logs() {
    let folder = folder();
    let fit = |arguments: &[&str]| zerorate(folder.path(), &[&["fit"], arguments].concat());
    let to = ["--out", "m.json", "--report", "r.html"];
    let of = |log| [&[log], &to[..]].concat();
    assert_eq!(fit(&of("a.csv")).code, 0);
    assert_eq!(fit(&of("a.csv")).code, 0, "the same command again");
    assert_eq!(fit(&[&of("a.csv")[..], &["--model", "poly:2", "--serial", "U7"]].concat()).code, 0);
    let before = ["m.json", "r.html"].map(|file| read(folder.path(), file));

    fit(&["b.csv", "--out", "m.json"]).is_error(&["--out m.json", "the calibration of a.csv", "--force"]);
    fit(&["b.csv", "--report", "r.html"]).is_error(&["--report r.html", "another source", "--force"]);
    fit(&["a.csv", "--out", "m.json", "--serial", "U8"]).is_error(&["the calibration of unit U7"]);
    let no_serial = fit(&["a.csv", "--out", "m.json", "--serial", ""]);
    assert!(no_serial.code == 2 && no_serial.err.contains("--serial"), "{}", no_serial.err);
    for option in ["--out", "--report"] {
        fit(&["a.csv", option, "mine.txt"]).is_error(&[option, "mine.txt", "--force"]);
    }
    assert_eq!(before, ["m.json", "r.html"].map(|file| read(folder.path(), file)));
    assert_eq!(read(folder.path(), "mine.txt"), b"mine, and no copy of it\n");
    assert_eq!(fit(&[&of("b.csv")[..], &["--force"]].concat()).code, 0);
    assert_ne!(before[0], read(folder.path(), "m.json"));
}

#[test]
fn what_came_of_a_log_before_it_went_on_is_set_aside() {
    let folder = folder();
    let fit = || zerorate(folder.path(), &["fit", "a.csv", "--out", "m.json", "--report", "r.html", "--json"]);
    assert_eq!(fit().code, 0);
    let before = ["m.json", "r.html"].map(|file| read(folder.path(), file));
    fs::copy(folder.path().join("b.csv"), folder.path().join("a.csv")).unwrap();
    let again = fit();
    assert_eq!(again.code, 0, "{}", again.err);
    again.says(&["it is kept as m.earlier.json", "it is kept as r.earlier.html"]);
    assert_eq!(before, ["m.earlier.json", "r.earlier.html"].map(|file| read(folder.path(), file)));
    assert_ne!(before[0], read(folder.path(), "m.json"));
}

#[test]
fn apply_export_and_report_write_over_their_own_alone() {
    let folder = folder();
    let run = |arguments: &[&str]| zerorate(folder.path(), arguments);
    for (log, out) in [("a.csv", "a.json"), ("b.csv", "b.json")] {
        assert_eq!(run(&["fit", log, "--out", out]).code, 0);
    }
    let mine = "# all of my vehicle's parameters\n1\t1\tTC_G_ENABLE\t0\t6\n";
    fs::write(folder.path().join("vehicle.params"), mine).unwrap();
    let export =
        |of: &str, format: &str, out: &str| run(&["export", of, "--format", format, "--device-id", "5", "--out", out]);
    export("a.json", "px4", "vehicle.params").is_error(&["vehicle.params", "has not written", "--force"]);
    assert_eq!(read(folder.path(), "vehicle.params"), mine.as_bytes());
    for format in ["px4", "c", "json", "csv"] {
        let out = format!("exported.{format}");
        assert_eq!((export("a.json", format, &out).code, export("a.json", format, &out).code), (0, 0), "{format}");
    }
    export("b.json", "px4", "exported.px4").is_error(&["another source", "--force"]);
    export("b.json", "csv", "exported.csv").is_error(&["does not say what it came of", "--force"]);

    let apply = |log: &str, out: &str| run(&["apply", "a.json", log, "--out", out]);
    assert_eq!((apply("a.csv", "c.csv").code, apply("a.csv", "c.csv").code), (0, 0));
    let set_aside = |log: &str, aside: &str| {
        let there = read(folder.path(), "c.csv");
        let ran = apply(log, "c.csv");
        assert_eq!(ran.code, 0, "{}", ran.err);
        assert!(
            ran.err.contains("the corrected rows of another log; it is kept as") && ran.err.contains(aside),
            "{}",
            ran.err
        );
        assert_eq!(read(folder.path(), aside), there);
    };
    set_aside("b.csv", "c.earlier.csv");
    let by_hand = String::from_utf8(read(folder.path(), "c.csv")).unwrap().replace('\n', ",mine\n");
    fs::write(folder.path().join("c.csv"), &by_hand).unwrap();
    set_aside("b.csv", "c.earlier-2.csv");
    apply("a.csv", "b.csv").is_error(&["no corrected log", "--force"]);
    apply("a.csv", "a.csv").is_error(&["would be lost"]);

    assert_eq!(run(&["report", "a.json", "--log", "a.csv"]).code, 0);
    assert_eq!(run(&["report", "a.json", "--log", "a.csv"]).code, 0);
    run(&["report", "b.json", "--log", "b.csv"]).is_error(&["report.html", "another source", "--force"]);
}

#[test]
fn a_boards_record_is_read_over_its_own_alone() {
    let folder = folder_with("other.bin", bench::device_record());
    // The simulated board is ZR-0001 and has nothing stored; the file is ZR-0042's.
    let read_to = |file: &str| zerorate(folder.path(), &["device", "--port", "native", "read", file]);
    read_to("other.bin").is_error(&["other.bin", "the device record of unit ZR-0042", "--force"]);
    assert_eq!(read(folder.path(), "other.bin"), bench::device_record());
}
