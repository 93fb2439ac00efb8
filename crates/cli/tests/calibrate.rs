//! The main job as people and scripts meet it: what it writes, what it prints, what it leaves when it cannot go on.

#![allow(clippy::unwrap_used, missing_docs)] // what a test cannot do without

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

#[allow(dead_code)] // The other tests hold what commands print, too.
#[path = "command/schema.rs"]
mod schema;

const FILES: [&str; 10] = [
    "calibration.json",
    "certificate.html",
    "compensation-test-hybrid.parquet",
    "compensation-test-trim.parquet",
    "device-record.bin",
    "full-temperature.parquet",
    "report.html",
    "soaks.parquet",
    "summary.json",
    "trim-sweep.parquet",
];

fn zerorate(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_zerorate")).args(arguments).current_dir(folder).output().unwrap()
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// A set-up with a shorter ramp and two soaks, for what does not depend on how long they are.
fn short_set_up(folder: &Path) {
    let text = "[chamber]\nramp_groups = 1600\nsoak_s = 600.0\nsoaks_c = [0.0, 20.0]\n";
    fs::write(folder.join("short.toml"), text).unwrap();
}

#[test]
fn the_main_job_writes_its_ten_files_and_the_same_json_twice() {
    let folder = tempfile::tempdir().unwrap();
    let first = zerorate(&["calibrate", "--json", "--serial", "ZR-9"], folder.path());
    assert!(first.status.success(), "{}", String::from_utf8_lossy(&first.stderr));
    let out = folder.path().join("calibration");
    assert_eq!(names(&out), FILES);
    let printed: Value = serde_json::from_slice(&first.stdout).unwrap();
    let written: Value = serde_json::from_slice(&fs::read(out.join("summary.json")).unwrap()).unwrap();
    assert_eq!(printed, written);
    schema::hold("summary.json", &written);
    schema::hold(
        "calibration.json",
        &serde_json::from_slice(&fs::read(out.join("calibration.json")).unwrap()).unwrap(),
    );
    assert_eq!((&printed["schema"], &printed["plant"], &printed["seed"]), (&2.into(), &"paper".into(), &1.into()));
    assert_eq!(printed["axes"]["x"]["drift_raw_coefficients"].as_array().unwrap().len(), 3);
    let tests: Vec<String> = printed["tests"]
        .as_array()
        .unwrap()
        .iter()
        .map(|test| ["mode", "axis", "control", "direction"].map(|key| test[key].as_str().unwrap()).join(" "))
        .collect();
    let expected = ["trim x y heating", "hybrid x y heating", "trim x y cooling", "hybrid x y cooling"];
    assert_eq!(tests, [&expected[..], &["trim y x heating", "hybrid y x heating"]].concat());

    // The same seed again: the same bits, but for the time by the wall clock.
    let before: Vec<Vec<u8>> = FILES.map(|file| fs::read(out.join(file)).unwrap()).into();
    assert!(zerorate(&["calibrate", "--serial", "ZR-9"], folder.path()).status.success());
    for (file, before) in FILES.iter().zip(before).filter(|(file, _)| **file != "summary.json") {
        assert!(fs::read(out.join(file)).unwrap() == before, "{file} differs");
    }
}

#[test]
fn the_results_of_another_unit_are_kept_unless_they_are_given_up() {
    let folder = tempfile::tempdir().unwrap();
    short_set_up(folder.path());
    let calibrate = |more: &[&str]| zerorate(&[&["calibrate", "--setup", "short.toml"], more].concat(), folder.path());
    let ramp = || fs::read(folder.path().join("calibration/full-temperature.parquet")).unwrap();
    calibrate(&["--serial", "A-1"]);
    let first = ramp();
    for other in [&["--serial", "B-2"][..], &["--serial", "A-1", "--seed", "9"]] {
        let refused = calibrate(other);
        let told = String::from_utf8(refused.stderr).unwrap();
        assert_eq!(refused.status.code(), Some(2), "{told}");
        assert!(told.contains("the simulated unit A-1 (plant paper, seed 1)") && told.contains("--force"), "{told}");
        assert!(ramp() == first);
    }
    calibrate(&["--serial", "B-2", "--seed", "9", "--force"]);
    assert!(ramp() != first);
    // Without soaks none of an earlier run stay beside the new results.
    assert!(folder.path().join("calibration/soaks.parquet").exists());
    fs::write(folder.path().join("short.toml"), "[chamber]\nramp_groups = 1600\nsoak_s = 600.0\nsoaks_c = []\n")
        .unwrap();
    calibrate(&["--serial", "B-2", "--seed", "9"]);
    assert!(!folder.path().join("calibration/soaks.parquet").exists());
}

/// A real unit's results: those of a simulated one without what says so.
fn make_real(folder: &Path) {
    let file = folder.join("calibration/summary.json");
    let mut summary: Value = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
    for field in ["plant", "seed"] {
        summary.as_object_mut().unwrap().remove(field);
    }
    fs::write(file, summary.to_string()).unwrap();
}

#[test]
fn simulated_results_never_take_a_real_units_place_and_no_run_takes_a_users_files() {
    let folder = tempfile::tempdir().unwrap();
    short_set_up(folder.path());
    let calibrate = |more: &[&str]| {
        let ran = zerorate(&[&["calibrate", "--setup", "short.toml"], more].concat(), folder.path());
        (ran.status.code(), String::from_utf8(ran.stderr).unwrap())
    };
    calibrate(&[]);
    make_real(folder.path());
    for more in [&[][..], &["--force"], &["--serial", "B-2", "--force"]] {
        let (code, told) = calibrate(more);
        assert_eq!(code, Some(2), "{told}");
        assert!(told.contains("the real unit ZR-0001") && told.contains("--out"), "{told}");
    }
    fs::create_dir(folder.path().join("mine")).unwrap();
    fs::write(folder.path().join("mine/report.html"), "my page").unwrap();
    let (code, told) = calibrate(&["--out", "mine"]);
    assert!(code == Some(2) && told.contains("report.html is there and is no run's"), "{told}");
    assert_eq!(names(&folder.path().join("mine")), ["report.html"]);
    // What a real run has finished is not lost to a simulated one either.
    let finished = folder.path().join("days/in-progress/finished");
    fs::create_dir_all(&finished).unwrap();
    for file in ["run.txt", "full-temperature.bin"] {
        fs::write(finished.join(file), "of days").unwrap();
    }
    let (code, told) = calibrate(&["--out", "days", "--force"]);
    assert!(code == Some(2) && told.contains("stopped before its end"), "{told}");
    assert_eq!(names(&finished), ["full-temperature.bin", "run.txt"]);
}

#[test]
fn a_run_that_cannot_begin_leaves_no_empty_folders() {
    let folder = tempfile::tempdir().unwrap();
    // Groups that the native board does not take.
    fs::write(folder.path().join("other.toml"), "[trim]\nspan_counts = 4000.0\n[board]\ncentre_counts = 200.0\n")
        .unwrap();
    let ran = zerorate(&["calibrate", "--setup", "other.toml"], folder.path());
    assert_eq!(ran.status.code(), Some(2));
    assert_eq!(names(folder.path()), ["other.toml"]);
}

#[test]
fn a_unit_outside_its_limits_is_rejected_with_the_reason_and_exit_code_1() {
    let folder = tempfile::tempdir().unwrap();
    short_set_up(folder.path());
    let strict =
        fs::read_to_string(folder.path().join("short.toml")).unwrap() + "[limits]\ntrim_residual_pp_counts = 5.0\n";
    fs::write(folder.path().join("strict.toml"), strict).unwrap();
    let ran = zerorate(&["calibrate", "--setup", "strict.toml"], folder.path());
    assert_eq!(ran.status.code(), Some(1));
    let told = String::from_utf8(ran.stdout).unwrap();
    assert!(told.contains("rejected") && told.contains("X trim, heating: residual"), "{told}");
    assert_eq!(names(&folder.path().join("calibration")), FILES, "what was measured is kept");
}

/// A file system of its own with room for a part of a ramp.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_keeps_earlier_results_and_what_was_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let mounted = Command::new("mount")
        .args(["-t", "tmpfs", "-o", "size=700k", "tmpfs"])
        .arg(folder.path())
        .stderr(Stdio::null())
        .status();
    if !mounted.is_ok_and(|status| status.success()) {
        eprintln!("skipped for want of the right to mount a small file system");
        return;
    }
    let out = folder.path().join("calibration");
    fs::create_dir(&out).unwrap();
    fs::write(out.join("summary.json"), "earlier").unwrap();
    let ran = zerorate(&["calibrate", "--force"], folder.path());
    let info = zerorate(&["info", "calibration/in-progress/full-temperature.arrows"], folder.path());
    let earlier = fs::read_to_string(out.join("summary.json"));
    Command::new("umount").arg(folder.path()).status().unwrap();
    assert_eq!(ran.status.code(), Some(2));
    let told = String::from_utf8(ran.stderr).unwrap();
    assert!(told.contains("No space left") && told.contains("what was recorded before it is kept there"), "{told}");
    assert_eq!(earlier.unwrap(), "earlier");
    assert!(String::from_utf8(info.stdout).unwrap().contains("CUT"));
}

/// What a run with the short set-up has come to when it is killed: a file of its own that is as large as this, the last
/// when all is there and only has to be put in place.
const MOMENTS: [(&str, u64); 20] = [
    ("full-temperature.arrows", 0),
    ("full-temperature.arrows", 1),
    ("full-temperature.arrows", 50_000),
    ("full-temperature.arrows", 700_000),
    ("full-temperature.arrows", 2_000_000),
    ("full-temperature.parquet.partial", 0),
    ("full-temperature.parquet", 0),
    ("trim-sweep.parquet", 0),
    ("compensation-test-trim.arrows", 1),
    ("compensation-test-trim.arrows", 1_234_567),
    ("compensation-test-trim.arrows", 3_000_000),
    ("compensation-test-trim.arrows", 7_000_001),
    ("compensation-test-trim.parquet", 0),
    ("compensation-test-hybrid.arrows", 123_456),
    ("compensation-test-hybrid.arrows", 5_000_000),
    ("compensation-test-hybrid.arrows", 8_000_000),
    ("compensation-test-hybrid.parquet", 0),
    ("soaks.arrows", 0),
    ("calibration.json", 0),
    ("summary.json", 0),
];
/// Guards against a run that hangs, however slow the machine.
const HANGS: Duration = Duration::from_secs(600);

/// Starts a run in an empty folder and kills it when it has come to a moment. A run that was over before is none: whether
/// it was killed in time.
fn killed(folder: &Path, (file, bytes): (&str, u64)) -> bool {
    let file = folder.join("calibration/in-progress").join(file);
    let mut child = Command::new(env!("CARGO_BIN_EXE_zerorate"))
        .args(["calibrate", "--setup", "short.toml", "--force"])
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let began = Instant::now();
    while fs::metadata(&file).map_or(true, |file| file.len() < bytes) && child.try_wait().unwrap().is_none() {
        assert!(began.elapsed() < HANGS, "{} does not become {bytes} bytes", file.display());
        std::thread::sleep(Duration::from_micros(200));
    }
    child.kill().unwrap();
    // What ended by itself has a code.
    child.wait().unwrap().code().is_none()
}

#[test]
fn a_run_killed_at_any_moment_leaves_every_whole_group_and_earlier_results() {
    let mut in_time = 0;
    for (kill, moment) in MOMENTS.into_iter().enumerate() {
        let folder = tempfile::tempdir().unwrap();
        short_set_up(folder.path());
        let out = folder.path().join("calibration");
        fs::create_dir(&out).unwrap();
        fs::write(out.join("summary.json"), "earlier").unwrap();
        fs::write(out.join("notes.txt"), "mine").unwrap();
        in_time += usize::from(killed(folder.path(), moment));

        // Between two renames neither set is in place, and both are beside.
        let found = if out.exists() { names(&out) } else { Vec::new() };
        if found.iter().any(|name| name == "report.html") {
            // It had put everything in place, or had begun to: then all of it is there.
            assert!(FILES.iter().all(|file| found.iter().any(|name| name == file)), "kill {kill}: {found:?}");
        } else if !found.is_empty() {
            assert_eq!(fs::read_to_string(out.join("summary.json")).unwrap(), "earlier", "kill {kill}");
            let left = out.join("in-progress");
            // The half-written Parquet beside a stream that is still whole is not a recording.
            let recordings =
                names(&left).into_iter().filter(|name| [".arrows", ".parquet"].iter().any(|end| name.ends_with(end)));
            for name in recordings {
                let info = zerorate(&["info", "--json", &format!("calibration/in-progress/{name}")], folder.path());
                let told = String::from_utf8_lossy(&info.stderr);
                // A kill before the header is on disk leaves no recording to speak of, and that is said.
                let cut_at_the_head = told.contains("before its header was whole");
                assert!(info.status.success() || cut_at_the_head, "kill {kill}, {name}: {told}");
            }
        }

        if kill % 5 == 4 {
            // The next run takes no harm from what is left, and loses nothing of it.
            let next = zerorate(&["calibrate", "--setup", "short.toml", "--force"], folder.path());
            assert!(next.status.success(), "kill {kill}");
            let found = names(&out);
            assert!(FILES.iter().chain(&["notes.txt"]).all(|file| found.iter().any(|name| name == file)), "{found:?}");
            assert_eq!(names(folder.path()), ["calibration", "short.toml"], "kill {kill}");
        }
    }
    // A machine that is busy with other things may let a run or two come to its end first.
    assert!(in_time > 0, "no run was killed before its end");
}

#[test]
fn what_cannot_be_is_refused_before_anything_is_run() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    fs::write(folder.path().join("bad.toml"), "[chamber]\ncold_c = 70.0\n").unwrap();
    for (arguments, part) in [
        (["--out", "file"], "cannot write"),
        (["--setup", "missing.toml"], "missing.toml"),
        (["--setup", "bad.toml"], "cold_c 70 is not below"),
        (["--serial", "a serial of far more than thirty-two bytes"], "32 bytes"),
        (["--plant", "other"], "paper"),
    ] {
        let ran = zerorate(&[&["calibrate"], &arguments[..]].concat(), folder.path());
        let told = String::from_utf8(ran.stderr).unwrap();
        assert_eq!(ran.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(told.contains(part), "{arguments:?}: {told}");
    }
}

#[test]
fn a_study_gives_a_result_a_unit_and_quantiles() {
    let folder = tempfile::tempdir().unwrap();
    let ran = zerorate(&["study", "--units", "4", "--seed", "3", "--json"], folder.path());
    let study: Value = serde_json::from_slice(&ran.stdout).unwrap();
    schema::hold("study.json", &study);
    assert_eq!((&study["schema"], &study["units"], &study["plant"]), (&1.into(), &4.into(), &"typical".into()));
    let results = study["results"].as_array().unwrap();
    assert_eq!(results.len(), 4);
    for (number, result) in results.iter().enumerate() {
        assert_eq!(result["unit"], number);
        let figure = |key: &str| result[key].as_f64().unwrap();
        assert!(figure("hybrid_residual_pp_counts") < figure("drift_pp_counts"));
        assert!(figure("floor_pp_counts") > 0.0);
    }
    assert_eq!(study["quantiles"]["drift_pp_counts"].as_array().unwrap().len(), 8);
    let within = results.iter().filter(|result| result.get("failed_checks").is_none()).count();
    assert_eq!(study["within_limits"], within);
    // A limit that the plants' own figures are all above: none is within it.
    fs::write(folder.path().join("strict.toml"), "[drift]\nmodel = \"auto\"\n[limits]\nmean_offset_counts = 0.001\n")
        .unwrap();
    let ran = zerorate(&["study", "--units", "2", "--setup", "strict.toml"], folder.path());
    let told = String::from_utf8(ran.stdout).unwrap();
    assert!(
        told.starts_with("0 of 2 units meet the limits of the set-up on the X axis, which alone is")
            && told.contains("unit 1: X "),
        "{told}"
    );
}

#[cfg(unix)]
#[test]
fn a_result_that_nobody_hears_is_told_to_be_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    short_set_up(folder.path());
    let mut run = Command::new(env!("CARGO_BIN_EXE_zerorate"));
    run.args(["calibrate", "--setup", "short.toml", "--notify", "echo $ZERORATE_RESULT > message"]);
    let mut run = run.current_dir(folder.path()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // Whoever looked on has gone.
    drop((run.stdout.take(), run.stderr.take()));
    let ended = run.wait().unwrap();
    let message = fs::read_to_string(folder.path().join("message")).unwrap();
    let summary = fs::read(folder.path().join("calibration/summary.json")).unwrap();
    let verdict = serde_json::from_slice::<Value>(&summary).unwrap()["verdict"].clone();
    let expected = if verdict == "rejected" { ("rejected", Some(1)) } else { ("passed", Some(0)) };
    assert_eq!((message.trim(), ended.code()), expected, "{verdict}");
}

#[cfg(unix)]
#[test]
fn a_run_into_a_folder_in_which_one_goes_on_leaves_that_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let in_progress = folder.path().join("calibration/in-progress");
    fs::create_dir_all(&in_progress).unwrap();
    // Begun, and without a group.
    fs::write(in_progress.join("full-temperature.arrows"), "").unwrap();
    let held = fs::File::open(folder.path().join("calibration")).unwrap();
    held.lock().unwrap();
    let ran = zerorate(&["calibrate"], folder.path());
    let told = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.code() == Some(2) && told.contains("a run goes on in calibration"), "{told}");
    assert!(!told.contains("--resume"), "{told}");
    assert_eq!(names(&in_progress), ["full-temperature.arrows"]);
}
