//! A page for those who look on: a run from its beginning to its end, and a recording.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use serde_json::Value;

use super::{bench, zerorate};

/// A command that serves a page.
struct Serving {
    process: Child,
    host: String,
}

impl Serving {
    fn start(folder: &Path, arguments: &[&str]) -> Self {
        let mut process = Command::new(env!("CARGO_BIN_EXE_zerorate"))
            .args(arguments)
            .current_dir(folder)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let told = BufReader::new(process.stderr.take().unwrap());
        let mut words = told
            .lines()
            .map_while(Result::ok)
            .flat_map(|line| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>());
        let url = words.find(|word| word.starts_with("http://")).unwrap();
        // What it tells besides is read to its end, or it would wait to be heard.
        std::thread::spawn(move || words.for_each(drop));
        Self { process, host: url.trim_start_matches("http://").trim_end_matches('/').to_owned() }
    }

    fn ask(&self, path: &str) -> TcpStream {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {}\r\n\r\n", self.host).unwrap();
        stream
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Looks on from before the first group: who is there at the end gets it, and the figures are those of the summary.
#[test]
fn a_run_is_looked_on_to_its_end_and_its_figures_are_the_reports() {
    let folder = tempfile::tempdir().unwrap();
    let serving = Serving::start(folder.path(), &["calibrate", "--live", "127.0.0.1:0"]);
    let mut all = String::new();
    serving.ask("/events").read_to_string(&mut all).unwrap();
    assert!(all.ends_with("event: over\ndata:\n\n"), "{all}");
    for part in ["The unit passed", "the last", "soaks to compare with", "full-temperature test"] {
        assert!(all.contains(part), "'{part}' is missing");
    }
    // What is over is not done now.
    let last = all.rsplit("data: plan").next().unwrap();
    assert!(!last.contains("<b>now</b>"), "{last}");
    drop(serving);

    let summary: Value =
        serde_json::from_slice(&fs::read(folder.path().join("calibration/summary.json")).unwrap()).unwrap();
    let rms = ["x", "y"].map(|axis| summary["axes"][axis]["fit_rms_counts"].as_f64().unwrap());
    let serving =
        Serving::start(folder.path(), &["live", "calibration/full-temperature.parquet", "--on", "127.0.0.1:0"]);
    let lines = BufReader::new(serving.ask("/events")).lines().map(Result::unwrap);
    let now = lines.skip_while(|line| line != "data: now").nth(1).unwrap();
    let told = format!("X\u{a0}{:.2}, Y\u{a0}{:.2} counts rms, in-sample, poly:2", rms[0], rms[1]);
    assert!(now.contains(&told) && now.contains("The recording is finished"), "{told}: {now}");
}

/// A board's groups, of which nobody knows when they end.
#[test]
fn a_monitor_is_looked_on() {
    let folder = tempfile::tempdir().unwrap();
    let mut board = Command::new(env!("CARGO_BIN_EXE_zerorate"))
        .args(["virtual-board", "--on", "tcp:127.0.0.1:0", "--speed", "20"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = String::new();
    BufReader::new(board.stdout.take().unwrap()).read_line(&mut said).unwrap();
    let port = said.trim().rsplit(' ').next().unwrap();
    let serving = Serving::start(folder.path(), &["device", "--port", port, "monitor", "--live", "127.0.0.1:0"]);
    let mut lines = BufReader::new(serving.ask("/events")).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.contains(", 0 lost")));
    assert!(lines.any(|line| line.contains(" groups so far")));
    drop(serving);
    board.kill().unwrap();
    board.wait().unwrap();
}

/// A recording that another program writes is shown as it grows.
#[test]
fn a_recording_is_looked_on_as_it_grows() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = bench::recording(&folder.path().join("run.parquet"));
    (0..30).for_each(|number| writer.write_group(&bench::group(number)).unwrap());
    let serving = Serving::start(folder.path(), &["live", "run.arrows", "--on", "127.0.0.1:0"]);
    let mut lines = BufReader::new(serving.ask("/events")).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.contains("30 groups so far")));
    writer.write_group(&bench::group(30)).unwrap();
    assert!(lines.any(|line| line.contains("31 groups so far")));
}

#[test]
fn a_place_that_is_taken_or_is_none_is_told_and_nothing_is_run() {
    let folder = tempfile::tempdir().unwrap();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = taken.local_addr().unwrap().to_string();
    let refused = zerorate(folder.path(), &["calibrate", "--live", &place]);
    refused.is_error(&[&place, "127.0.0.1:0 finds a port that is free"]);
    assert!(!folder.path().join("calibration/summary.json").exists());
    let refused = zerorate(folder.path(), &["calibrate", "--live", "5495"]);
    assert_eq!(refused.code, 2);
    refused.says(&["'5495' is no place to listen", "127.0.0.1:5495"]);
    zerorate(folder.path(), &["live", "nothing.parquet"]).is_error(&["nothing.parquet"]);
}
