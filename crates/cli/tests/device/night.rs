//! Nobody at the bench: chamber and supply of a virtual board obey the program, by Modbus and SCPI.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use zerorate_cal::recording::Recording;

use crate::board::{Board, await_end, await_that, send};
use crate::fault_line::{Does, FaultLine};
use crate::schema;
use crate::server::Server;

/// Three hours of chamber time, over 30 K.
pub const NIGHT: &str = "\
[chamber]
cold_c = 10.0
hot_c = 40.0
soak_s = 60.0
soak_groups = 4
ramp_groups = 400
soaks_c = [10.0]
[chamber.controller]
preset = \"watlow-f4t\"
[supply]
voltmeter_x = \"MEAS:VOLT? (@2)\"
voltmeter_y = \"MEAS:VOLT? (@3)\"
[trim]
points = 3
groups_per_point = 2
span_counts = 300.0
margin_taps = 1
";

struct Bench {
    board: Board,
    chamber: String,
    supply: String,
    folder: tempfile::TempDir,
}

impl Bench {
    fn start(chamber_on: &str) -> Self {
        Self::start_at("300", chamber_on)
    }

    fn start_at(speed: &str, chamber_on: &str) -> Self {
        Self::of(NIGHT, speed, chamber_on)
    }

    /// A night whose numbers do not depend on how late the chamber is sent off, by a machine that is slow, at 300 times its time: its
    /// soaks warm the whole board from wherever it was, and its ramps are longer than the chamber needs.
    fn unhurried() -> Self {
        let setup = NIGHT.replace("soak_s = 60.0", "soak_s = 1200.0").replace("ramp_groups = 400", "ramp_groups = 800");
        Self::of(&setup, "300", "tcp:127.0.0.1:0")
    }

    fn of(setup: &str, speed: &str, chamber_on: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("night.toml"), setup).unwrap();
        let more =
            ["--chamber-on", chamber_on, "--supply-on", "tcp:127.0.0.1:0", "--speed", speed, "--setup", "night.toml"];
        let mut board = Board::start("tcp:127.0.0.1:0", &more, folder.path());
        let [chamber, supply] = [0, 1].map(|_| board.said().rsplit(' ').next().unwrap().to_owned());
        Self { board, chamber, supply, folder }
    }

    fn calibrate(&self, more: &[&str]) -> Child {
        self.calibrate_by(&self.chamber, &self.supply, more)
    }

    fn calibrate_by(&self, chamber: &str, supply: &str, more: &[&str]) -> Child {
        Command::new(env!("CARGO_BIN_EXE_zerorate"))
            .args(["calibrate", "--device", &self.board.port, "--chamber", chamber, "--supply", supply])
            .args(["--setup", "night.toml", "--json"])
            .args(more)
            .current_dir(self.path())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    /// The chamber's set point and mode, and the supply's output, asked by hand. Each hears one host at a time.
    fn at_the_end(&self) -> (f32, u16, String) {
        let connect = |address: &str| {
            let stream = TcpStream::connect(address).unwrap();
            stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
            stream
        };
        let mut chamber = connect(self.chamber.strip_prefix("modbus-tcp:").unwrap());
        let mut read = |register: u16, count: u8| {
            let [high, low] = register.to_be_bytes();
            chamber.write_all(&[0, 9, 0, 0, 0, 6, 1, 3, high, low, 0, count]).unwrap();
            let mut answer = vec![0; 9 + 2 * usize::from(count)];
            chamber.read_exact(&mut answer).unwrap();
            answer[9..].to_vec()
        };
        let words = read(2782, 2);
        let set_point = f32::from_be_bytes([words[2], words[3], words[0], words[1]]);
        let mode = read(2730, 1);
        let mut supply = connect(self.supply.strip_prefix("scpi:").unwrap());
        supply.write_all(b"OUTP?\n").unwrap();
        let mut output = String::new();
        BufReader::new(supply).read_line(&mut output).unwrap();
        (set_point, u16::from_be_bytes([mode[0], mode[1]]), output.trim().to_owned())
    }
}

/// Holds a run's numbers against those of the simulated bench's own run of the same unit, in one program.
fn hold_against_the_simulated(bench: &Bench, summary: &Value) {
    let simulated = Command::new(env!("CARGO_BIN_EXE_zerorate"))
        .args(["calibrate", "--json", "--out", "simulated", "--setup", "night.toml"])
        .current_dir(bench.path())
        .output()
        .unwrap();
    let simulated: Value = serde_json::from_slice(&simulated.stdout).unwrap();
    for axis in ["x", "y"] {
        let [own, theirs] = [summary, &simulated].map(|summary| summary["axes"][axis].clone());
        let of = |field: &str| [&own, &theirs].map(|axis| axis[field].as_f64().unwrap());
        let [own, theirs] = of("drift_pp_counts");
        // Group means have 0.4 counts of noise, and the chamber's ripple is at another place.
        assert!((own - theirs).abs() < 4.0, "{axis}: {own} and {theirs}");
    }
    let residuals = |summary: &Value| -> Vec<f64> {
        let tests = summary["tests"].as_array().unwrap().iter();
        tests.map(|test| test["residual_pp_counts"].as_f64().unwrap()).collect()
    };
    for (own, theirs) in residuals(summary).iter().zip(residuals(&simulated)) {
        assert!((own - theirs).abs() < 4.0, "{own} and {theirs}");
    }
}

/// Waits until a file is longer than so many bytes; returns its length.
fn await_file(file: &Path, than: u64) -> u64 {
    let began = Instant::now();
    loop {
        let length = file.metadata().map_or(0, |file| file.len());
        if length > than {
            return length;
        }
        assert!(began.elapsed() < Duration::from_secs(60), "{length} bytes are in {}", file.display());
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn told(child: &mut Child) -> String {
    let mut told = String::new();
    child.stderr.take().unwrap().read_to_string(&mut told).unwrap();
    told
}

#[test]
fn a_night_without_anybody_ends_with_a_report_a_message_and_everything_off() {
    let bench = Bench::unhurried();
    // Somebody has left the supply on, with an error in its queue.
    let mut supply = TcpStream::connect(bench.supply.strip_prefix("scpi:").unwrap()).unwrap();
    supply.write_all(b"FOO\nVOLT 2.5\nOUTP ON\nOUTP?\n").unwrap();
    let mut output = String::new();
    BufReader::new(&supply).read_line(&mut output).unwrap();
    assert_eq!(output.trim(), "1");
    drop(supply);
    let mut run = bench.calibrate(&["--notify", "echo $ZERORATE_RESULT: $ZERORATE_MESSAGE > message"]);
    let mut summary = String::new();
    run.stdout.take().unwrap().read_to_string(&mut summary).unwrap();
    let told = told(&mut run);
    assert_eq!(await_end(&mut run), Some(0), "{told}");
    let summary: Value = serde_json::from_str(&summary).unwrap();
    schema::hold("summary.json", &summary);
    assert_eq!(summary["tests"].as_array().unwrap().len(), 6);
    hold_against_the_simulated(&bench, &summary);
    let report = fs::read_to_string(bench.path().join("calibration/report.html")).unwrap();
    let recording = Recording::read(&bench.path().join("calibration/trim-sweep.parquet").as_path().into()).unwrap();
    let supply = format!("{} (Zerorate,virtual supply,0,{})", bench.supply, env!("CARGO_PKG_VERSION"));
    assert!(report.contains(&supply));
    assert_eq!(recording.info.labels.get("supply"), Some(&supply));
    assert_eq!(recording.info.labels.get("chamber"), Some(&bench.chamber));
    assert!(summary["started"].as_str().unwrap().starts_with("20"));
    assert!(told.contains("its output is on, and is switched off before the run begins"), "{told}");
    assert!(told.contains("step 7 of 7: soaks to compare with") && !told.contains(">>"), "{told}");
    assert_eq!(
        fs::read_to_string(bench.path().join("message")).unwrap(),
        "passed: the unit passed; the report is in calibration\n"
    );
    assert_eq!(bench.at_the_end(), (25.0, 62, "0".into()));
}

/// The summary of a run that has passed.
fn passed(run: &mut Child) -> Value {
    let mut summary = String::new();
    run.stdout.take().unwrap().read_to_string(&mut summary).unwrap();
    let told = told(run);
    assert_eq!(await_end(run), Some(0), "{told}");
    serde_json::from_str(&summary).unwrap()
}

/// Waits until the ramp of the full-temperature test is under way.
fn await_the_ramp(bench: &Bench) {
    // Its head is there from the beginning. Groups come after the soak: four of it, then those of the ramp.
    let recording = bench.path().join("calibration/in-progress/full-temperature.arrows");
    let head = await_file(&recording, 0);
    let group = await_file(&recording, head) - head;
    await_file(&recording, head + 20 * group);
}

/// The last number of an address.
fn port(address: &str) -> &str {
    address.rsplit(':').next().unwrap()
}

#[test]
#[ignore = "needs pymodbus and sinstruments: cargo xtask test instruments"]
fn a_night_by_servers_of_others_loses_no_group_when_the_line_to_the_chamber_is_cut() {
    // A ramp of twenty minutes takes four seconds.
    let bench = Bench::unhurried();
    let chamber = Server::start("chamber.py", &["--behind", port(&bench.chamber)]);
    let supply = Server::start("supply.py", &["--behind", port(&bench.supply)]);
    let line = FaultLine::tcp(chamber.port);
    let mut run =
        bench.calibrate_by(&format!("modbus-tcp:{}", line.place), &format!("scpi:127.0.0.1:{}", supply.port), &[]);
    await_the_ramp(&bench);
    line.does(Does::Cut);
    // Three times as long as an answer may take, and more.
    std::thread::sleep(Duration::from_millis(4500));
    line.does(Does::Pass);
    hold_against_the_simulated(&bench, &passed(&mut run));
    let rows = Recording::read(&(&bench.path().join("calibration/full-temperature.parquet")).into()).unwrap().rows;
    let mut groups: Vec<u32> = rows.iter().map(|row| row.group).collect();
    groups.dedup();
    let all = u32::try_from(groups.len()).unwrap();
    assert!(groups == (0..all).collect::<Vec<_>>() && all >= 804, "{all} groups");
    assert!(rows.iter().any(|row| row.chamber_c.is_nan()), "where the chamber was is not known meanwhile");
    drop((chamber, supply));
    let (set_point, _, output) = bench.at_the_end();
    assert_eq!((set_point, output.as_str()), (25.0, "0"));
}

/// A line to the bench's chamber, and its address for `--chamber`.
fn faulty(bench: &Bench) -> (FaultLine, String) {
    let line = FaultLine::tcp(port(&bench.chamber).parse().unwrap());
    let address = format!("modbus-tcp:{}", line.place);
    (line, address)
}

#[test]
fn a_controller_that_is_busy_is_waited_for() {
    let bench = Bench::unhurried();
    let (line, chamber) = faulty(&bench);
    let mut run = bench.calibrate_by(&chamber, &bench.supply, &[]);
    await_the_ramp(&bench);
    line.does(Does::Refuse(&[], 6));
    std::thread::sleep(Duration::from_secs(4));
    line.does(Does::Pass);
    hold_against_the_simulated(&bench, &passed(&mut run));
    assert_eq!(bench.at_the_end(), (25.0, 62, "0".into()));
}

/// The word that sends it off arrives, and its answer does not: it heats for twenty minutes, and nobody sees it.
#[test]
fn a_chamber_that_has_left_before_its_ramp_is_held_once_more() {
    let bench = Bench::unhurried();
    let (line, chamber) = faulty(&bench);
    let mut run = bench.calibrate_by(&chamber, &bench.supply, &[]);
    let recording = bench.path().join("calibration/in-progress/full-temperature.arrows");
    let head = await_file(&recording, 0);
    await_file(&recording, head);
    line.does(Does::Refuse(&[], 6));
    std::thread::sleep(Duration::from_secs(4));
    line.does(Does::Pass);
    hold_against_the_simulated(&bench, &passed(&mut run));
}

/// Set point 25.0 at 2782, low word first, and off, 62, at 2730: what a controller is at that starts anew.
const ANEW: &[u8] =
    &[0, 1, 0, 0, 0, 11, 1, 16, 0x0A, 0xDE, 0, 2, 4, 0, 0, 0x41, 0xC8, 0, 2, 0, 0, 0, 6, 1, 6, 0x0A, 0xAA, 0, 62];

/// Its connection is made anew within one question, so that nothing seems to have been amiss.
#[test]
fn a_ramp_in_which_the_controller_starts_anew_is_run_again() {
    // A ramp of ten minutes takes twelve seconds.
    let bench = Bench::start_at("50", "tcp:127.0.0.1:0");
    let (line, chamber) = faulty(&bench);
    let mut run = bench.calibrate_by(&chamber, &bench.supply, &[]);
    await_the_ramp(&bench);
    line.does(Does::Instead(&[], ANEW));
    let mut told = BufReader::new(run.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(told.any(|line| line.contains("started anew during the ramp") && line.contains("run again, once")));
    assert!(told.any(|line| line.contains("step 1 of 7: full-temperature test")));
    send("TERM", run.id());
    told.for_each(drop);
    assert_eq!(await_end(&mut run), Some(2));
    assert_eq!(bench.at_the_end(), (25.0, 62, "0".into()));
}

/// All was measured, and the chamber heats on: that is what whoever is woken by the message must hear first.
#[test]
fn a_controller_that_does_not_stop_at_the_end_is_told_of_first() {
    let bench = Bench::start("tcp:127.0.0.1:0");
    let (line, chamber) = faulty(&bench);
    // Off, 62, is refused as a failure.
    line.does(Does::Refuse(&[6, 0x0A, 0xAA, 0, 62], 4));
    let mut run = bench.calibrate_by(
        &chamber,
        &bench.supply,
        &["--notify", "echo $ZERORATE_RESULT: $ZERORATE_MESSAGE > message"],
    );
    let told = told(&mut run);
    assert_eq!(await_end(&mut run), Some(2), "{told}");
    let message = fs::read_to_string(bench.path().join("message")).unwrap();
    for told in [&told, &message] {
        assert!(told.contains("GO THERE AND SWITCH IT OFF BY HAND") && told.contains("all was measured"), "{told}");
    }
    assert!(bench.path().join("calibration/summary.json").is_file());
}

#[test]
fn a_controller_that_is_busy_at_the_end_is_told_to_stop_until_it_does() {
    let bench = Bench::start("tcp:127.0.0.1:0");
    let (line, chamber) = faulty(&bench);
    line.does(Does::Refuse(&[6, 0x0A, 0xAA, 0, 62], 6));
    let notify = ["--notify", "echo $ZERORATE_RESULT: $ZERORATE_MESSAGE > message"];
    let mut run = bench.calibrate_by(&chamber, &bench.supply, &notify);
    // The last that is written before all is brought to rest.
    await_that("the results are there", || bench.path().join("calibration/summary.json").is_file());
    std::thread::sleep(Duration::from_secs(4));
    assert!(run.try_wait().unwrap().is_none(), "it waits for a chamber that heats on");
    line.does(Does::Pass);
    passed(&mut run);
    // Its ramps are shorter than the chamber needs.
    assert_eq!(
        fs::read_to_string(bench.path().join("message")).unwrap(),
        "passed: the unit passed, with warnings; the report is in calibration\n"
    );
    assert_eq!(bench.at_the_end(), (25.0, 62, "0".into()));
}

#[test]
fn a_run_that_is_stopped_leaves_the_chamber_safe_and_the_supply_off() {
    let bench = Bench::start("tcp:127.0.0.1:0");
    let mut run = bench.calibrate(&["--notify", "echo $ZERORATE_RESULT > message"]);
    // On the way to 10 C, or at it.
    await_file(&bench.path().join("calibration/in-progress/full-temperature.arrows"), 0);
    send("TERM", run.id());
    let told = told(&mut run);
    assert_eq!(await_end(&mut run), Some(2), "{told}");
    assert!(told.contains("stopped by Ctrl-C, or by a signal to end"), "{told}");
    assert_eq!(fs::read_to_string(bench.path().join("message")).unwrap(), "stopped\n");
    assert_eq!(bench.at_the_end(), (25.0, 62, "0".into()));
}

/// A board on the table, and the chamber of another: its first soak is an hour and a half, eighteen seconds here, and a ramp as long.
#[test]
fn a_board_that_is_not_in_the_chamber_is_told_before_its_first_ramp_is_over_and_all_is_brought_to_rest() {
    let setup = NIGHT.replace("cold_c = 10.0", "cold_c = -40.0").replace("hot_c = 40.0", "hot_c = 60.0");
    let setup = setup.replace("soak_s = 60.0", "soak_s = 3600.0").replace("ramp_groups = 400", "ramp_groups = 2400");
    let [on_the_table, other] = [(); 2].map(|()| Bench::of(&setup, "300", "tcp:127.0.0.1:0"));
    let notify = ["--notify", "echo $ZERORATE_RESULT: $ZERORATE_MESSAGE > message"];
    let mut run = on_the_table.calibrate_by(&other.chamber, &on_the_table.supply, &notify);
    let told = told(&mut run);
    assert_eq!(await_end(&mut run), Some(2), "{told}");
    assert!(told.contains("the board does not follow the chamber") && told.contains("lies in this chamber"), "{told}");
    assert!(!told.contains("step 2 of") && !told.contains("allow"), "{told}");
    assert!(fs::read_to_string(on_the_table.path().join("message")).unwrap().starts_with("failed: "));
    // It was told in the soak, or in the first minutes of the ramp.
    let recording = on_the_table.path().join("calibration/in-progress/full-temperature.arrows");
    let groups = Recording::read(&(&recording).into()).map_or(0, |recording| recording.groups());
    assert!(groups < 1200, "{groups} groups of the ramp's 2400");
    let (set_point, mode, _) = other.at_the_end();
    assert_eq!((set_point, mode), (25.0, 62));
}

#[test]
fn the_plan_is_told_beforehand_and_nothing_is_moved() {
    let bench = Bench::start("pty");
    let mut run = bench.calibrate(&["--dry-run"]);
    let mut plan = String::new();
    run.stdout.take().unwrap().read_to_string(&mut plan).unwrap();
    let told = told(&mut run);
    assert_eq!(await_end(&mut run), Some(0), "{told}");
    let plan: Value = serde_json::from_str(&plan).unwrap();
    schema::hold("plan.json", &plan);
    assert_eq!(plan["steps"].as_array().unwrap().len(), 7);
    // 30 K in 400 groups of 1.5 s.
    assert!((plan["ramp_k_per_min"].as_f64().unwrap() - 3.0).abs() < 1e-9);
    let found = plan["instruments"].to_string();
    assert!(
        found.contains("modbus-rtu:") && found.contains("is set to 25.0 C") && found.contains("ZR-0042"),
        "{found}"
    );
    assert!(!bench.path().join("calibration").exists());
}

#[test]
fn an_instrument_that_is_not_there_or_not_known_is_told_before_anything_begins() {
    let bench = Bench::start("tcp:127.0.0.1:0");
    fs::write(bench.path().join("no-controller.toml"), "").unwrap();
    let calibrate = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_zerorate"))
            .args(["calibrate", "--device", &bench.board.port])
            .args(arguments)
            .current_dir(bench.path())
            .stdin(Stdio::null())
            .output()
            .unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    for (arguments, told) in [
        (&["--chamber", "modbus-tcp:127.0.0.1:1", "--setup", "night.toml"][..], "Connection refused"),
        (&["--chamber", "modbus-tcp:127.0.0.1:1"], "does not say which controller this is"),
        (&["--chamber", "gpib:7"], "give modbus-tcp:HOST:PORT"),
        (&["--chamber", &bench.chamber, "--supply", &bench.chamber, "--setup", "night.toml"], "give scpi:HOST:PORT"),
        (&["--chamber", "simulated"], "no simulated chamber"),
    ] {
        let (code, error) = calibrate(arguments);
        assert!(code == Some(2) && error.contains(told), "{told} is missing from: {error}");
    }
}
