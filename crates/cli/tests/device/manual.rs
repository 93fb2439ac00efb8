//! A person at the bench: told by the program, they turn chamber, supply and switch of a virtual board.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde_json::Value;
use zerorate_cal::recording::Recording;

use crate::board::{Board, await_end, send};
use crate::schema;

/// The same procedures over 30 K, with three voltages and one soak: three hours of chamber time.
const SHORT: &str = "\
[chamber]
cold_c = 10.0
hot_c = 40.0
soak_s = 60.0
soak_groups = 4
ramp_groups = 400
soaks_c = [10.0]
[trim]
points = 3
groups_per_point = 2
span_counts = 300.0
margin_taps = 1
";

struct Run {
    child: Child,
    answers: ChildStdin,
    told: BufReader<std::process::ChildStderr>,
    out: ChildStdout,
    /// Everything told so far.
    lines: Vec<String>,
    /// The person says that the gyros are connected again, and leaves the supply where it is.
    forgets_the_gyros: bool,
}

impl Run {
    fn start(board: &Board, more: &[&str], folder: &Path) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_zerorate"))
            .args(["calibrate", "--device", &board.port, "--chamber", "manual", "--supply", "manual", "--json"])
            .args(["--setup", "short.toml"])
            .args(more)
            .current_dir(folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (answers, out) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        let told = BufReader::new(child.stderr.take().unwrap());
        Self { child, answers, told, out, lines: Vec::new(), forgets_the_gyros: false }
    }

    /// Does what the program says, until it says something with `part` in it for the `nth` time, or ends.
    fn obey_until(&mut self, board: &mut Board, part: &str, nth: usize) -> bool {
        let mut line = String::new();
        let mut seen = 0;
        loop {
            line.clear();
            if self.told.read_line(&mut line).unwrap() == 0 {
                return false;
            }
            self.lines.push(line.trim().to_owned());
            seen += usize::from(line.contains(part));
            if seen == nth {
                return true;
            }
            if let Some(what) = line.trim().strip_prefix(">> ") {
                self.obey(board, what);
            }
        }
    }

    fn obey(&mut self, board: &mut Board, what: &str) {
        let word = |text: &str, place: usize| text.split_whitespace().nth(place).unwrap().to_owned();
        let answer = match what {
            _ if what.starts_with("set the chamber to") => {
                board.order(&format!("chamber {}", word(what, 4)));
                return;
            }
            _ if what.starts_with("switch gyros and board off") => {
                board.order("power");
                return;
            }
            _ if what.starts_with("feed") => {
                board.order(&format!("feed {}", word(what, 1)));
                String::new()
            }
            _ if what.contains("connect the gyros") => {
                if !self.forgets_the_gyros {
                    board.order("gyros");
                }
                String::new()
            }
            _ if what.contains("volts are at the X") => word(&board.order("voltmeter"), 2),
            _ if what.contains("volts are at the Y") => word(&board.order("voltmeter"), 4),
            _ if what.contains("chamber show now") => word(&board.order("status"), 2),
            _ => panic!("nobody knows how to: {what}"),
        };
        writeln!(self.answers, "{answer}").unwrap();
    }

    fn count(&self, part: &str) -> usize {
        self.lines.iter().filter(|line| line.contains(part)).count()
    }
}

fn bench(on: &str) -> (Board, tempfile::TempDir) {
    bench_of(on, SHORT)
}

fn bench_of(on: &str, setup: &str) -> (Board, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("short.toml"), setup).unwrap();
    let board = Board::start(on, &["--speed", "400", "--setup", "short.toml"], folder.path());
    (board, folder)
}

fn groups(file: &Path) -> Vec<u32> {
    let mut groups: Vec<u32> = Recording::read(&file.into()).unwrap().rows.iter().map(|row| row.group).collect();
    groups.dedup();
    groups
}

#[test]
fn a_run_by_hand_that_was_stopped_goes_on_and_passes() {
    // Ramps that end, and a soak amid them: how far a ramp reaches that is cut off, or begins after a minute's soak, hangs on how
    // long whoever sets the chamber takes.
    let setup =
        SHORT.replace("ramp_groups = 400", "ramp_groups = 2000").replace("soaks_c = [10.0]", "soaks_c = [25.0]");
    let (mut board, folder) = bench_of("pty", &setup);
    let in_progress = folder.path().join("calibration/in-progress");

    let mut run = Run::start(&board, &[], folder.path());
    // In the second test on axis X the ramp has begun: full temperature, trim heating and cooling, hybrid.
    assert!(run.obey_until(&mut board, "the ramp has begun", 2), "{:#?}", run.lines);
    send("INT", run.child.id());
    run.obey_until(&mut board, "nothing of that kind", 1);
    assert_eq!(await_end(&mut run.child), Some(2));
    assert_eq!(run.count("the plan: 7 steps, about "), 1, "{:#?}", run.lines);
    assert_eq!(run.count("1. full-temperature test: about "), 1, "{:#?}", run.lines);
    assert_eq!(run.count("step 2 of 7: trim experiment"), 1, "{:#?}", run.lines);
    assert_eq!(run.count("4 steps are left after it, and the run ends about"), 1, "{:#?}", run.lines);
    assert!(run.count("stopped by Ctrl-C") == 1 && run.count("--resume") == 1, "{:#?}", run.lines);
    let ramp = fs::read(in_progress.join("full-temperature.parquet")).unwrap();
    assert!(in_progress.join("trim-sweep.parquet").exists());
    let cut = groups(&in_progress.join("compensation-test-trim.arrows"));
    assert!(!cut.is_empty() && cut.windows(2).all(|pair| pair[0] < pair[1]), "{cut:?}");

    // Without --resume nothing is thrown away.
    let mut anew = Run::start(&board, &[], folder.path());
    anew.obey_until(&mut board, "nothing of that kind", 1);
    assert_eq!(await_end(&mut anew.child), Some(2));
    assert_eq!(anew.count("go on with it (--resume)"), 1, "{:#?}", anew.lines);

    let mut run = Run::start(&board, &["--resume"], folder.path());
    run.obey_until(&mut board, "nothing of that kind", 1);
    let mut summary = String::new();
    std::io::Read::read_to_string(&mut run.out, &mut summary).unwrap();
    let code = await_end(&mut run.child);
    assert_eq!(code, Some(0), "{summary}\n{:#?}", run.lines);
    assert_eq!(run.count("feed"), 0, "the trim experiment is not repeated: {:#?}", run.lines);
    assert_eq!(run.count("the ramp has begun"), 6, "{:#?}", run.lines);
    assert_eq!(run.count("are the gyros connected"), 0, "{:#?}", run.lines);

    let summary: Value = serde_json::from_str(&summary).unwrap();
    schema::hold("summary.json", &summary);
    assert_eq!((&summary["verdict"], &summary["serial"]), (&"warning".into(), &"ZR-0042".into()));
    // Half an hour's ramp takes the gyro nearly there.
    assert!((0.9..1.01).contains(&summary["axes"]["x"]["share_of_asked_range"].as_f64().unwrap()), "{summary:#}");
    assert_eq!(summary["tests"].as_array().unwrap().len(), 6);
    assert!(summary["tests"][0].get("floor_pp_counts").is_none(), "nobody knows the truth on a real bench");
    let out = folder.path().join("calibration");
    assert_eq!(
        fs::read(out.join("full-temperature.parquet")).unwrap(),
        ramp,
        "the first ramp is that of the first run"
    );
    let [first, later] = ["full-temperature.parquet", "soaks.parquet"]
        .map(|file| Recording::read(&(&out.join(file)).into()).unwrap().info.started.unwrap());
    assert!(first < later, "each says when it was begun");
    for file in ["compensation-test-trim.parquet", "compensation-test-hybrid.parquet", "soaks.parquet", "report.html"] {
        assert!(out.join(file).exists(), "{file}");
    }
    assert_eq!(groups(&out.join("in-progress/compensation-test-trim.cut.arrows")), cut, "what was cut is kept");
    let info = board.device(&["info", "--json"], folder.path()).json();
    assert_eq!(info["calibrated"], true);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("no floor") || page.contains("A real bench cannot know it"), "no floor is said");
    assert!(!page.contains("taps crossed") && !page.contains("native"), "what is not known is not told");
    let limits: Vec<&str> = summary["checks"].as_array().unwrap().iter().map(|c| c["what"].as_str().unwrap()).collect();
    assert!(limits.contains(&"X hybrid, heating: residual, peak to peak, against what trim leaves"), "{limits:?}");
}

#[test]
fn a_board_that_holds_a_calibration_is_measured_without_it() {
    let (mut board, folder) = bench("pty");
    fs::write(folder.path().join("calibration.json"), crate::bench::calibration()).unwrap();
    board.device(&["deploy", "calibration.json"], folder.path()).ends(0, &["axis X is in mode hybrid"]);
    let mut run = Run::start(&board, &[], folder.path());
    // The ramp was fitted: the next step begins.
    assert!(run.obey_until(&mut board, "step 2 of 7: trim experiment", 1), "{:#?}", run.lines);
    run.child.kill().unwrap();
    run.child.wait().unwrap();
    assert_eq!(run.count("the board holds a calibration: its compensation is off"), 1, "{:#?}", run.lines);
    let ramp = folder.path().join("calibration/in-progress/full-temperature.parquet");
    let rows = Recording::read(&(&ramp).into()).unwrap().rows;
    assert!(rows.iter().all(|row| row.tap == 511 && row.mode.name() == "off"), "the wiper stays");
}

#[test]
fn a_supply_left_in_the_gyros_place_is_told_before_the_ramp() {
    let (mut board, folder) = bench("pty");
    let mut run = Run::start(&board, &[], folder.path());
    run.forgets_the_gyros = true;
    assert!(run.obey_until(&mut board, "are the gyros connected, and is the supply off?", 1), "{:#?}", run.lines);
    run.child.kill().unwrap();
    run.child.wait().unwrap();
    assert_eq!(run.count("the ramp has begun"), 1, "{:#?}", run.lines);
    assert_eq!(run.count("note: Y, which is not compensated, reads "), 1, "{:#?}", run.lines);
}

#[test]
fn a_board_that_goes_in_the_middle_of_a_ramp_leaves_its_groups() {
    let (mut board, folder) = bench("tcp:127.0.0.1:0");
    let mut run = Run::start(&board, &[], folder.path());
    assert!(run.obey_until(&mut board, "the ramp has begun", 1), "{:#?}", run.lines);
    board.kill();
    run.obey_until(&mut board, "nothing of that kind", 1);
    assert_eq!(await_end(&mut run.child), Some(2));
    assert_eq!(run.count("the line to the device is gone"), 1, "{:#?}", run.lines);
    let kept = groups(&folder.path().join("calibration/in-progress/full-temperature.arrows"));
    assert!(kept.len() > 4, "the soak's and the ramp's beginning: {kept:?}");
    assert_eq!(kept, (0..u32::try_from(kept.len()).unwrap()).collect::<Vec<_>>(), "every one that arrived");
}

#[test]
fn a_board_that_hangs_in_the_middle_of_a_ramp_is_told_and_the_run_can_go_on() {
    let (mut board, folder) = bench("pty");
    let mut run = Run::start(&board, &[], folder.path());
    assert!(run.obey_until(&mut board, "the ramp has begun", 1), "{:#?}", run.lines);
    board.signal("STOP");
    run.obey_until(&mut board, "nothing of that kind", 1);
    assert_eq!(await_end(&mut run.child), Some(2));
    assert_eq!(run.count("the device says nothing"), 1, "{:#?}", run.lines);
    board.signal("CONT");
    let mut run = Run::start(&board, &["--resume"], folder.path());
    assert!(run.obey_until(&mut board, "the ramp has begun", 1), "{:#?}", run.lines);
    run.child.kill().unwrap();
    run.child.wait().unwrap();
}
