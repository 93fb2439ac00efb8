//! Several virtual boards in one chamber, each with a supply of its own or all with one.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use zerorate_cal::recording::Recording;

use crate::board::{Board, await_that};
use crate::fault_line::{Does, FaultLine};
use crate::night::NIGHT;
use crate::schema;

/// Boards in one process; where each listens, the chamber, and the supplies.
struct Bench {
    boards: Board,
    devices: Vec<String>,
    chamber: String,
    supplies: Vec<String>,
    folder: tempfile::TempDir,
}

impl Bench {
    fn start(boards: usize) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("night.toml"), NIGHT).unwrap();
        let (any, number) = ("tcp:127.0.0.1:0", boards.to_string());
        let more = ["--chamber-on", any, "--supply-on", any, "--speed", "300", "--setup", "night.toml", "--boards"];
        let mut first = Board::start(any, &[&more[..], &[&number]].concat(), folder.path());
        let said: Vec<String> = (0..2 * boards).map(|_| first.said().rsplit(' ').next().unwrap().to_owned()).collect();
        let [chamber, supply, others @ ..] = &said[..] else { panic!("{said:?}") };
        let others = || others.chunks_exact(2);
        let devices = std::iter::once(first.port.clone()).chain(others().map(|board| board[0].clone())).collect();
        let supplies = std::iter::once(supply.clone()).chain(others().map(|board| board[1].clone())).collect();
        Self { boards: first, devices, chamber: chamber.clone(), supplies, folder }
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    fn calibrate(&self, supplies: &[String], more: &[&str]) -> Output {
        self.command(supplies, more).output().unwrap()
    }

    fn command(&self, supplies: &[String], more: &[&str]) -> Command {
        let each = |option: &'static str, values: &[String]| -> Vec<String> {
            values.iter().flat_map(|value| [option.to_owned(), value.clone()]).collect()
        };
        let mut command = Command::new(env!("CARGO_BIN_EXE_zerorate"));
        command
            .args(["calibrate", "--setup", "night.toml", "--out", "lot", "--chamber", &self.chamber])
            .args(each("--device", &self.devices))
            .args(each("--supply", supplies))
            .args(more)
            .current_dir(self.path())
            .stdin(Stdio::null());
        command
    }
}

fn told(output: &Output) -> (Option<i32>, String) {
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn three_boards_go_through_a_night_together_and_one_that_cannot_begin_is_not_waited_for() {
    let mut bench = Bench::start(3);
    let second = bench.path().join("lot/ZR-0042-2");
    fs::create_dir_all(&second).unwrap();
    fs::write(second.join("report.html"), "somebody's").unwrap();
    let output = bench.calibrate(&bench.supplies, &["--json", "--notify", "echo $ZERORATE_RESULT > message"]);
    let (code, told) = told(&output);
    assert_eq!(code, Some(2), "{told}");
    let ended: Value = serde_json::from_slice(&output.stdout).unwrap();
    schema::hold("calibrations.json", &ended);
    let units = ended["units"].as_array().unwrap();
    let of = |field: &str| -> Vec<&str> { units.iter().filter_map(|unit| unit[field].as_str()).collect() };
    assert_eq!(of("serial"), ["ZR-0042-1", "ZR-0042-2", "ZR-0042-3"]);
    assert_eq!(of("result"), ["passed", "failed", "passed"], "{told}");
    assert!(of("message")[0].contains("report.html"), "{ended}");
    assert_eq!(fs::read_to_string(bench.path().join("message")).unwrap(), "failed\n");
    assert!(told.contains("ZR-0042-3: step 7 of 7"), "{told}");
    // At once, and not when the others are done.
    assert!(told.contains("ZR-0042-2: it ended before it was done"), "{told}");
    // Units of their own, in one chamber: none lost a group, and all were as warm.
    for unit in ["ZR-0042-1", "ZR-0042-3"] {
        let recording = bench.path().join("lot").join(unit).join("full-temperature.parquet");
        let rows = Recording::read(&recording.as_path().into()).unwrap().rows;
        let mut groups: Vec<u32> = rows.iter().map(|row| row.group).collect();
        groups.dedup();
        assert_eq!(groups, (0..u32::try_from(groups.len()).unwrap()).collect::<Vec<_>>(), "{unit}");
        let ramp: Vec<f64> = rows.iter().filter(|row| row.phase.is_ramp()).map(|row| row.chamber_c).collect();
        assert!(ramp.len() == 800 && ramp[0] < 12.0 && ramp[799] > 33.0, "{unit}: {} {}", ramp[0], ramp[799]);
    }
    let drift = |unit: usize| units[unit]["summary"]["axes"]["x"]["drift_pp_counts"].as_f64().unwrap();
    // One design, and noise of their own.
    assert!(drift(0) > 20.0 && (drift(0) - drift(2)).abs() < 4.0, "{} {}", drift(0), drift(2));
    assert!(bench.boards.order("status").contains("acquisition"));
    // What was done is not done again.
    let (code, told) = self::told(&bench.calibrate(&bench.supplies, &["--resume", "--force", "--dry-run"]));
    assert_eq!(code, Some(0), "{told}");
}

/// The second board's line is cut in its ramp; who looks on sees all three to their ends.
#[test]
fn a_board_whose_line_is_cut_leaves_the_others_running_and_one_page_shows_them_all() {
    let mut bench = Bench::start(3);
    let line = FaultLine::tcp(bench.devices[1].rsplit(':').next().unwrap().parse().unwrap());
    bench.devices[1] = format!("tcp:{}", line.place);
    let mut command = bench.command(&bench.supplies, &["--json", "--live", "127.0.0.1:0"]);
    let mut run = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut words = BufReader::new(run.stderr.take().unwrap())
        .lines()
        .map_while(Result::ok)
        .flat_map(|line| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>());
    // The page of all is told first.
    let url = words.find(|word| word.starts_with("http://")).unwrap();
    std::thread::spawn(move || words.for_each(drop));
    let host = url.trim_start_matches("http://").trim_end_matches('/').to_owned();
    let mut looking = TcpStream::connect(&host).unwrap();
    write!(looking, "GET /events HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
    let recording = bench.path().join("lot/ZR-0042-2/in-progress/full-temperature.arrows");
    await_that("the second board's groups come", || recording.metadata().is_ok_and(|file| file.len() > 20_000));
    line.does(Does::Cut);
    let mut seen = String::new();
    looking.read_to_string(&mut seen).unwrap();
    let output = run.wait_with_output().unwrap();
    let ended: Value = serde_json::from_slice(&output.stdout).unwrap();
    let results: Vec<&str> =
        ended["units"].as_array().unwrap().iter().filter_map(|unit| unit["result"].as_str()).collect();
    assert_eq!((output.status.code(), &results[..]), (Some(2), &["passed", "failed", "passed"][..]), "{ended}");
    // What the board had said before is kept.
    assert!(recording.metadata().unwrap().len() > 20_000);
    let last = seen.rsplit("data: now").next().unwrap();
    assert!(last.contains("3 of 3 over") && last.contains("event: over"), "{last}");
    for (unit, how) in
        [("ZR-0042-1", "The unit passed"), ("ZR-0042-2", "It ended before it was done"), ("ZR-0042-3", "passed")]
    {
        let row = last.split("<tr>").find(|row| row.contains(&format!(">{unit}</a>"))).unwrap();
        assert!(row.contains(how), "{row}");
    }
}

#[test]
fn boards_that_cannot_be_run_together_are_told_so() {
    let bench = Bench::start(2);
    let twice = [bench.supplies.clone(), bench.supplies.clone()].concat();
    let same = [bench.supplies[0].clone(), bench.supplies[0].clone()];
    for (supplies, more, expected) in [
        (&twice[..], &[][..], "4 supplies for 2 boards"),
        (&[], &[], "0 supplies for 2 boards"),
        (&same, &[], "was given twice"),
        (&bench.supplies, &["--serial", "ZR-1"], "several boards say themselves who they are"),
        (&bench.supplies, &["--device", "native"], "several boards at once are real ones"),
    ] {
        let (code, told) = told(&bench.calibrate(supplies, more));
        assert!(code == Some(2) && told.contains(expected), "{told}");
    }
    // One supply for all, used in turns, and nothing is moved by a plan.
    let output = bench.calibrate(&bench.supplies[..1], &["--dry-run"]);
    let (code, told) = told(&output);
    let plan = String::from_utf8(output.stdout).unwrap();
    assert!(code == Some(0) && plan.contains("is ZR-0042-2"), "{told}{plan}");
}
