//! Every verb on a serial line, for which a pseudo-terminal stands in.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::Value;
use tempfile::TempDir;

use crate::bench;
use crate::board::Board;
use crate::schema;

fn on_a_serial_line() -> (Board, TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let name = folder.path().join("board");
    let board = Board::start(&format!("pty:{}", name.display()), &["--speed", "30"], folder.path());
    assert_eq!(board.port, format!("serial:{}", name.display()));
    fs::write(folder.path().join("calibration.json"), bench::calibration()).unwrap();
    fs::write(folder.path().join("record.bin"), bench::device_record()).unwrap();
    (board, folder)
}

#[test]
fn a_new_board_says_who_it_is_and_refuses_what_needs_a_calibration() {
    let (board, folder) = on_a_serial_line();
    let run = |arguments: &[&str]| board.device(arguments, folder.path());
    let info = run(&["info", "--json"]).json();
    assert_eq!((&info["unit_serial"], &info["samples_per_group"]), (&"ZR-0042".into(), &500.into()));
    assert_eq!((&info["calibrated"], &info["record"]), (&false.into(), &Value::Null));
    run(&["info"]).ends(0, &["ZR-0042", "1.5 s each", "X and Y off", "X and Y at the middle tap 511"]);
    run(&["mode", "both", "hybrid"]).ends(1, &["the device refused", "deploy one first"]);
    let refused = run(&["mode", "x", "trim", "--json"]);
    assert_eq!((refused.code, refused.json()["refused"].is_string()), (Some(1), true));
    run(&["read", "nothing.bin"]).ends(1, &["no calibration stored"]);
    assert!(!folder.path().join("nothing.bin").exists());
}

#[test]
fn a_calibration_goes_on_the_board_and_comes_back_the_same() {
    let (board, folder) = on_a_serial_line();
    let run = |arguments: &[&str]| board.device(arguments, folder.path());
    run(&["deploy", "calibration.json"]).ends(
        0,
        &[
            "ZR-0042",
            "read back and the same",
            "axis X is in mode hybrid, axis Y in mode hybrid",
            "the acquisition stands still",
        ],
    );
    run(&["read", "back.bin"]).ends(0, &["back.bin"]);
    assert_eq!(fs::read(folder.path().join("back.bin")).unwrap(), bench::device_record());
    assert_eq!(run(&["info", "--json"]).json()["calibrated"], true);
    let told = run(&["deploy", "record.bin", "--json"]).json();
    assert_eq!((&told["deployed"], &told["modes"]), (&true.into(), &serde_json::json!(["hybrid", "hybrid"])));
    assert_eq!(run(&["info", "--json"]).json()["modes"], serde_json::json!(["hybrid", "hybrid"]));
    run(&["info"]).ends(0, &["X and Y in mode hybrid"]);

    // What is of no gyro takes no gyro's place unasked.
    let simulated = bench::calibration().replacen('{', "{ \"simulated\": \"plant paper, seed 1\",", 1);
    fs::write(folder.path().join("simulated.json"), simulated).unwrap();
    run(&["deploy", "simulated.json"]).ends(2, &["made on the simulated bench (plant paper, seed 1)", "--simulated"]);
    run(&["deploy", "simulated.json", "--simulated"]).ends(0, &["read back and the same"]);
    // Nor does its record, beside it.
    fs::create_dir(folder.path().join("run")).unwrap();
    fs::copy(folder.path().join("simulated.json"), folder.path().join("run/calibration.json")).unwrap();
    fs::copy(folder.path().join("record.bin"), folder.path().join("run/device-record.bin")).unwrap();
    run(&["deploy", "run/device-record.bin"]).ends(2, &["made on the simulated bench", "--simulated"]);

    // A record that was read before may be all that is left of it.
    let another = bench::record_of(&bench::calibration().replace("-200.0", "-210.0"));
    fs::write(folder.path().join("back.bin"), &another).unwrap();
    run(&["read", "back.bin"]).ends(0, &["another calibration of this unit", "back.earlier.bin"]);
    assert_eq!(fs::read(folder.path().join("back.earlier.bin")).unwrap(), another);
    run(&["read", "back.bin"]).ends(0, &["back.bin"]);
    assert!(!folder.path().join("back.earlier-2.bin").exists(), "the same once more");

    let other = bench::calibration().replace("ZR-0042", "ZR-0043");
    fs::write(folder.path().join("other.json"), other).unwrap();
    run(&["deploy", "other.json"]).ends(1, &["another serial", "ZR-0043", "the board is ZR-0042"]);
    assert_eq!(run(&["read", "still.bin", "--json"]).json()["file"], "still.bin");
    assert_eq!(fs::read(folder.path().join("still.bin")).unwrap(), bench::device_record(), "what it had stays");
    run(&["deploy", "board"]).ends(2, &["this is no file"]);
    run(&["deploy", "missing.json"]).ends(2, &["missing.json", "cannot be read"]);
}

#[test]
fn modes_and_taps_show_in_the_groups() {
    let (board, folder) = on_a_serial_line();
    let run = |arguments: &[&str]| board.device(arguments, folder.path());
    run(&["tap", "y", "500"]).ends(0, &["axis Y at tap 500"]);
    run(&["info"]).ends(0, &["X at the middle tap 511, Y at tap 500"]);
    let plain = run(&["monitor", "--groups", "3"]);
    plain.ends(0, &["group=0 axis=x", "group=2 axis=y", "tap=500", "rate_dps=", "mode=off", "temperature_c="]);
    assert_eq!(plain.out.lines().count(), 6);
    run(&["deploy", "calibration.json"]).ends(0, &[]);
    assert_eq!(run(&["mode", "both", "hybrid", "--json"]).json()["mode"], "hybrid");
    let groups = run(&["monitor", "--groups", "4", "--json"]);
    let groups: Vec<Value> = groups.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(groups.len(), 4);
    groups.iter().for_each(|group| schema::hold("device-monitor.json", group));
    // The virtual board stands at 25 C; the gyro's package is a kelvin or two above it.
    let degrees = groups[0]["axes"][0]["temperature_c"].as_f64().unwrap();
    assert!((24.5..28.0).contains(&degrees), "{degrees}");
    for (number, group) in groups.iter().enumerate() {
        assert_eq!(group["group"], number);
        assert_eq!(group["axes"][0]["mode"], "hybrid");
    }
    // The law moves the wiper when the first group closes.
    assert_eq!(groups[0]["axes"][1]["moved_to"], groups[1]["axes"][1]["tap"]);
    run(&["tap", "x", "2000"]).ends(2, &["2000 is no tap"]);
}

#[test]
fn a_command_takes_effect_at_the_group_that_it_names() {
    let (board, folder) = on_a_serial_line();
    let mut watching = Command::new(env!("CARGO_BIN_EXE_zerorate"))
        .args(["device", "--port", &board.port, "monitor"])
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    BufReader::new(watching.stdout.take().unwrap()).lines().next().unwrap().unwrap();
    // Killed, it cannot stop the acquisition that it has started.
    watching.kill().unwrap();
    watching.wait().unwrap();
    let info = board.device(&["info", "--json"], folder.path()).json();
    assert_eq!(info["taps"], serde_json::json!([511, 511]));
    // Three seconds off, or as long as it takes to start the command before the group is there.
    let mut ahead = 60;
    let told = loop {
        let group = board.device(&["info", "--json"], folder.path()).json()["group"].as_u64().unwrap() + ahead;
        let told = board.device(&["tap", "x", "520", "--at", &group.to_string(), "--json"], folder.path()).json();
        if told["from_group"] == group || ahead > 100_000 {
            assert_eq!(told["from_group"], group);
            break told;
        }
        ahead *= 4;
    };
    assert_eq!(told["axes"], serde_json::json!(["x"]));
    let first = board.device(&["monitor", "--groups", "1", "--json"], folder.path()).json();
    assert_eq!((&first["axes"][0]["tap"], &first["axes"][1]["tap"]), (&520.into(), &511.into()));
}

/// At work alone after its power has come.
#[test]
fn the_second_line_gives_every_scan_as_csv_and_as_json() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("calibration.json"), bench::calibration()).unwrap();
    let more = ["--speed", "20", "--scans-on", "tcp:127.0.0.1:0"];
    let mut board = Board::start("tcp:127.0.0.1:0", &more, folder.path());
    let scans = board.said().trim().rsplit(' ').next().unwrap().to_owned();
    board.device(&["deploy", "calibration.json"], folder.path()).ends(0, &[]);
    board.order("power");
    board.port = scans;
    let json = board.device(&["stream", "--scans", "1500", "--json"], folder.path());
    let heard: Vec<Value> = json.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!((json.code, heard.len()), (Some(0), 1500), "{}", json.err);
    heard.iter().for_each(|scan| schema::hold("device-stream.json", scan));
    let numbers: Vec<u64> = heard.iter().map(|scan| scan["scan"].as_u64().unwrap()).collect();
    assert!(numbers.windows(2).all(|pair| pair[1] == pair[0] + 1), "{numbers:?}");
    let last = &heard[1499];
    assert_eq!(last["x"]["flags"], serde_json::json!(["hybrid", "at_work"]));
    assert!((last["time_s"].as_f64().unwrap() - 0.003 * last["scan"].as_f64().unwrap()).abs() < 1e-6);
    let x = last["x"]["counts"].as_f64().unwrap();
    assert!((x - 8200.0).abs() < 40.0, "{x}: near the centre, its noise on it");
    let csv = board.device(&["stream", "--scans", "20", "--scan-period-us", "1000"], folder.path());
    csv.ends(0, &["scan,time_s,x_counts,x_flags,y_counts,y_flags", "hybrid at_work"]);
    assert_eq!(csv.out.lines().count(), 21);
    // The host's line is none.
    board.device(&["stream", "--scan-period-us", "0"], folder.path()).ends(2, &["--scan-period-us"]);
}

#[test]
fn the_fault_counters_are_told() {
    let (mut board, folder) = on_a_serial_line();
    let faults = board.device(&["faults", "--json"], folder.path()).json();
    assert_eq!((&faults["lost_sets"], &faults["trim_errors"]), (&0.into(), &0.into()));
    assert!(board.order("break spi").contains("DeadSpi"));
    board.device(&["tap", "x", "600"], folder.path()).ends(1, &["potentiometer could not be written", "SPI"]);
    let faults = board.device(&["faults", "--json"], folder.path()).json();
    assert!(faults["trim_errors"].as_u64().unwrap() > 0, "{faults}");
    board.device(&["faults"], folder.path()).ends(0, &["trim errors"]);
}

#[test]
fn the_power_up_tap_is_stored_only_when_it_is_agreed_to() {
    let (board, folder) = on_a_serial_line();
    board.device(&["first-time"], folder.path()).ends(2, &["--yes", "wears"]);
    let done = board.device(&["first-time", "--yes", "--json"], folder.path()).json();
    assert_eq!(
        (&done["tap"], &done["store_answered"], &done["after_power_up"], &done["fault"]),
        (&511.into(), &true.into(), &Value::Null, &Value::Null)
    );
    // Eight taps are 248 counts, and recalled they are gone again.
    for axis in [0, 1] {
        let [before, away, recalled] =
            [&done["before_counts"], &done["recalled"]["away_counts"], &done["recalled"]["recalled_counts"]]
                .map(|counts| counts[axis].as_f64().unwrap());
        assert!(((away - before).abs() - 248.0).abs() < 15.0 && (recalled - before).abs() < 8.0, "{done}");
    }
    board.device(&["first-time", "--yes"], folder.path()).ends(0, &["not checked: --power-cycle does"]);
}

#[test]
fn a_potentiometer_that_keeps_no_tap_is_found() {
    let (mut board, folder) = on_a_serial_line();
    assert!(board.order("break memory").contains("WornMemory"));
    // Its maker stored tap 511; a board with another middle shows that this one is not kept.
    fs::write(folder.path().join("setup.toml"), "[board]\nmiddle_tap = 520\n").unwrap();
    board
        .device(&["first-time", "--yes", "--setup", "setup.toml"], folder.path())
        .ends(1, &["was to be stored", "does not keep its tap"]);
}

/// Runs first-time with a power cycle, which `cycle` carries out when it is asked for; it ends with `code`.
fn first_time_over_a_power_cycle(port: &str, folder: &Path, code: i32, mut cycle: impl FnMut()) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_zerorate"))
        .args(["device", "--port", port, "first-time", "--yes", "--power-cycle", "--json"])
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let told = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    let mut cycles = 0;
    for line in told {
        if line.contains("switch gyros and board off") {
            cycle();
            cycles += 1;
        }
    }
    assert_eq!(cycles, 1);
    let output = child.wait_with_output().unwrap();
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(code), "{found}");
    assert!(found["after_power_up"]["recalled_counts"][0].is_number(), "{found}");
}

#[test]
fn the_power_up_tap_is_checked_over_a_power_cycle() {
    let (mut board, folder) = on_a_serial_line();
    let port = board.port.clone();
    first_time_over_a_power_cycle(&port, folder.path(), 0, || {
        board.order("power");
    });
}

#[test]
fn so_it_is_on_a_board_that_goes_to_work_when_its_power_comes() {
    let (mut board, folder) = on_a_serial_line();
    board.device(&["deploy", "calibration.json"], folder.path()).ends(0, &["nothing is compensated until it runs"]);
    let port = board.port.clone();
    first_time_over_a_power_cycle(&port, folder.path(), 0, || {
        board.order("power");
    });
    let modes = || board.device(&["info", "--json"], folder.path()).json()["modes"].clone();
    assert_eq!(board.device(&["info", "--json"], folder.path()).json()["acquiring"], true);
    assert_eq!(modes(), serde_json::json!(["hybrid", "hybrid"]), "it goes on");
    board.device(&["first-time", "--yes"], folder.path()).ends(0, &["is stored for power-up"]);
    assert_eq!(modes(), serde_json::json!(["hybrid", "hybrid"]), "and after a check without a power cycle, too");
}

#[test]
fn a_port_that_goes_with_the_boards_power_is_opened_again() {
    let (mut board, folder) = on_a_serial_line();
    let port = board.port.clone();
    let on = port.replace("serial:", "pty:");
    // What comes back is a new board, on whose potentiometer nobody has stored a tap.
    first_time_over_a_power_cycle(&port, folder.path(), 1, || {
        board.kill();
        // It is missing for a while; however long that is, the port is tried again.
        std::thread::sleep(Duration::from_secs(1));
        board = Board::start(&on, &["--speed", "30"], folder.path());
    });
}
