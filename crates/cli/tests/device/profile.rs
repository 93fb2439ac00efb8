//! A chamber without a board: `zerorate chamber`, against the virtual board's chamber, which hears Modbus.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use zerorate_cal::recording::{ChamberMoment, ChamberRecording, Phase};

use crate::board::{Board, await_end, await_that, send};
use crate::schema;

const SET_UP: &str = "\
[chamber]
cold_c = -20.0
hot_c = 60.0
soaks_c = []
limits_c = [-20.0, 70.0]
[chamber.controller]
preset = \"watlow-f4t\"
";

/// Three seconds at each end, in a chamber whose minutes are a third of a second.
const PROFILE: &str = "\
steps = [
    { soak_c = 22, minutes = 0.05 },
    { ramp_c = 30, k_per_min = 120 },
    { soak_c = 30, minutes = 0.05 },
]
";

struct Alone {
    _board: Board,
    chamber: String,
    folder: tempfile::TempDir,
}

impl Alone {
    fn start() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("bench.toml"), SET_UP).unwrap();
        fs::write(folder.path().join("night.toml"), PROFILE).unwrap();
        let mut board =
            Board::start("tcp:127.0.0.1:0", &["--chamber-on", "tcp:127.0.0.1:0", "--speed", "180"], folder.path());
        let chamber = board.said().rsplit(' ').next().unwrap().to_owned();
        Self { _board: board, chamber, folder }
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    fn command(&self, more: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_zerorate"));
        command.args(["chamber", "night.toml", "--chamber", &self.chamber, "--setup", "bench.toml"]).args(more);
        command.current_dir(self.path()).stdin(Stdio::null());
        command
    }

    fn recording(&self, name: &str) -> ChamberRecording {
        ChamberRecording::read(&(&self.path().join(name)).into()).unwrap()
    }
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn is_of(step: u32, phase: Phase) -> impl Fn(&&ChamberMoment) -> bool {
    move |moment| (moment.step, moment.phase) == (step, phase)
}

#[test]
fn a_profile_is_run_and_recorded_and_the_chamber_is_left_at_rest() {
    let alone = Alone::start();
    let dry = alone.command(&["--dry-run"]).output().unwrap();
    let plan = String::from_utf8_lossy(&dry.stdout).into_owned();
    assert!(dry.status.success() && plan.contains("the plan: 3 steps") && plan.contains("Nothing was moved"), "{plan}");
    assert!(!alone.path().join("night.parquet").exists());

    let notify = "echo \"$ZERORATE_RESULT: $ZERORATE_MESSAGE\" > said";
    let output = alone.command(&["--notify", notify]).output().unwrap();
    assert!(output.status.success(), "{}", told(&output));
    assert!(told(&output).contains("the chamber is at rest"), "{}", told(&output));
    let said = fs::read_to_string(alone.path().join("said")).unwrap();
    assert!(said.starts_with("done: the profile is done"), "{said}");

    let recording = alone.recording("night.parquet");
    assert!(!recording.cut && recording.info.profile == PROFILE && recording.info.labels.contains_key("chamber"));
    let soaked = |step, at: f64| {
        let moments: Vec<_> = recording.moments.iter().filter(is_of(step, Phase::Soak)).collect();
        assert!((2..=5).contains(&moments.len()), "{moments:?}");
        let is_there = |moment: &&ChamberMoment| (moment.air_c - at).abs() < 2.0 && (moment.set_c - at).abs() < 1e-9;
        assert!(moments.iter().all(is_there), "{moments:?}");
    };
    soaked(1, 22.0);
    soaked(3, 30.0);
    let ramp: Vec<f64> = recording.moments.iter().filter(is_of(2, Phase::Heating)).map(|moment| moment.set_c).collect();
    assert!(ramp.len() >= 4 && ramp.is_sorted() && ramp.last() == Some(&30.0), "{ramp:?}");

    // What was recorded is not written over.
    let again = alone.command(&[]).output().unwrap();
    assert!(again.status.code() == Some(2) && told(&again).contains("--force"), "{}", told(&again));
    assert_eq!(alone.recording("night.parquet"), recording);

    let info = Command::new(env!("CARGO_BIN_EXE_zerorate"))
        .args(["info", "night.parquet", "--json"])
        .current_dir(alone.path())
        .output()
        .unwrap();
    let info: Value = serde_json::from_slice(&info.stdout).unwrap();
    schema::hold("info.json", &info);
    assert_eq!(info["files"][0]["kind"], "chamber-recording");
    assert_eq!(info["files"][0]["moments"], recording.moments.len());
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_what_was_recorded_and_a_chamber_at_rest() {
    let alone = Alone::start();
    fs::write(alone.path().join("night.toml"), "steps = [{ soak_c = 24, minutes = 600 }]").unwrap();
    let mut child = alone.command(&["--out", "cut.parquet"]).stderr(Stdio::piped()).spawn().unwrap();
    let stream = alone.path().join("cut.arrows");
    await_that("something is recorded", || {
        ChamberRecording::read(&(&stream).into()).is_ok_and(|recording| recording.moments.len() > 2)
    });
    send("INT", child.id());
    await_end(&mut child);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", told(&output));
    assert!(told(&output).contains("what was recorded is in cut.parquet"), "{}", told(&output));
    let recording = alone.recording("cut.parquet");
    assert!(!recording.cut && recording.moments.len() > 2 && !stream.exists());
}

#[cfg(unix)]
#[test]
fn the_recording_of_a_run_that_was_killed_is_kept_and_it_is_said_where() {
    let alone = Alone::start();
    fs::write(alone.path().join("night.toml"), "steps = [{ soak_c = 24, minutes = 600 }]").unwrap();
    let start = || alone.command(&["--out", "own.parquet"]).stderr(Stdio::piped()).spawn().unwrap();
    let stream = alone.path().join("own.arrows");
    let is_recorded = |file: &Path| ChamberRecording::read(&file.into()).is_ok_and(|read| read.moments.len() > 2);
    let mut first = start();
    await_that("something is recorded", || is_recorded(&stream));
    first.kill().unwrap();
    first.wait().unwrap();
    let mut second = start();
    let kept = alone.path().join("own.cut.arrows");
    await_that("the second records", || is_recorded(&kept) && is_recorded(&stream));
    send("INT", second.id());
    await_end(&mut second);
    let told = told(&second.wait_with_output().unwrap());
    assert!(told.contains("that is kept as own.cut.arrows"), "{told}");
}

/// One after the other, as they are read at the terminal.
#[test]
fn an_error_is_told_before_a_notification_that_hangs_and_that_is_waited_for_with_a_word() {
    let alone = Alone::start();
    fs::write(alone.path().join("night.toml"), "steps = [{ soak_c = 80, minutes = 1 }]").unwrap();
    let output = alone.command(&["--notify", "sleep 3; exit 7"]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let told = told(&output);
    let parts = ["80 C is outside of", "--notify is waited for, 30 s at most: sleep 3", "it ended with exit status: 7"];
    let places = parts.map(|part| told.find(part).unwrap_or_else(|| panic!("{part} is missing from: {told}")));
    assert!(places.is_sorted(), "{told}");
}

#[test]
fn a_profile_beyond_the_chambers_limits_moves_nothing() {
    let alone = Alone::start();
    fs::write(alone.path().join("night.toml"), "steps = [{ soak_c = 80, minutes = 1 }]").unwrap();
    let output = alone.command(&[]).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(
        told(&output).contains("step 1: 80 C is outside of the chamber's limits, -20 to 70 C"),
        "{}",
        told(&output)
    );
    assert!(!alone.path().join("night.arrows").exists());
}

#[cfg(unix)]
#[test]
fn what_another_profile_writes_is_left_to_it_and_a_recording_is_a_file() {
    let [alone, other] = [Alone::start(), Alone::start()];
    let device = alone.command(&["--out", "/dev/null"]).output().unwrap();
    assert!(device.status.code() == Some(2) && told(&device).contains("this is no file"), "{}", told(&device));
    fs::write(alone.path().join("night.toml"), "steps = [{ soak_c = 24, minutes = 600 }]").unwrap();
    let mut first = alone.command(&[]).stderr(Stdio::null()).spawn().unwrap();
    await_that("the recording", || alone.path().join("night.arrows").exists());
    // A chamber hears one at a time.
    let out = alone.path().join("night.parquet");
    let second = other.command(&["--out", out.to_str().unwrap()]).output().unwrap();
    send("INT", first.id());
    assert_eq!(await_end(&mut first), Some(2));
    assert!(second.status.code() == Some(2) && told(&second).contains("another run writes"), "{}", told(&second));
    assert!(!alone.recording("night.parquet").cut);
}
