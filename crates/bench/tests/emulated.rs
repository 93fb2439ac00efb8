//! The firmware in QEMU against the application run natively. Run by `cargo xtask test firmware`.

#![cfg(unix)]
#![allow(clippy::unwrap_used)] // what a test cannot do without

mod paper_record;

use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use zerorate_bench::calibrate::calibrate;
use zerorate_bench::calibrated::Unit;
use zerorate_bench::checkpoint::Keep;
use zerorate_bench::client::Group;
use zerorate_bench::emulated;
use zerorate_bench::instruments::Bench;
use zerorate_bench::output::IN_PROGRESS;
use zerorate_bench::plants::PlantKind;
use zerorate_bench::run::{Session, Silent};
use zerorate_bench::setup::SetUp;
use zerorate_bench::simulated;
use zerorate_board_run::summary::Summary;
use zerorate_cal::recording::Recording;
use zerorate_core::record::UnitSerial;
use zerorate_core::units::Axis;
use zerorate_core::wire::{GroupReport, Request, SampleWindow};
use zerorate_sim::{Fault, Plant};

const WHY: &str = "needs QEMU and the firmware: cargo xtask test firmware";

fn native() -> Bench {
    native_on(PlantKind::Paper.build(1))
}

fn native_on(plant: Plant) -> Bench {
    simulated::bench(plant, &SetUp::paper(), &UnitSerial::try_from("ZR-0001").unwrap())
}

fn emulated(firmware: &Path) -> Bench {
    emulated_on(PlantKind::Paper.build(1), firmware)
}

fn emulated_on(plant: Plant, firmware: &Path) -> Bench {
    let unit = UnitSerial::try_from("ZR-0001").unwrap();
    emulated::bench(plant, &SetUp::paper(), &unit, firmware).expect(WHY)
}

fn firmware() -> PathBuf {
    emulated::find_firmware(None).expect(WHY)
}

/// A firmware of its own name, by which its emulator is found.
fn own_firmware(folder: &Path) -> PathBuf {
    let own = folder.join("firmware.elf");
    std::fs::copy(firmware(), &own).unwrap();
    own
}

/// The emulator that runs a firmware.
fn emulator_of(firmware: &Path) -> Option<Pid> {
    let name = firmware.to_str().unwrap();
    let processes = std::fs::read_dir("/proc").unwrap().flatten();
    let runs = |pid: i32| {
        let line = std::fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
        let line = String::from_utf8_lossy(&line).into_owned();
        line.starts_with("qemu-system-arm") && line.contains(name)
    };
    let pid = |entry: std::fs::DirEntry| entry.file_name().to_str()?.parse::<i32>().ok();
    processes.filter_map(pid).find(|&pid| runs(pid)).map(Pid::from_raw)
}

/// Groups with every sample; in the middle something is done.
fn groups(bench: &mut Bench, n: usize, in_the_middle: impl FnOnce()) -> Vec<Group> {
    let (setup, mut progress) = (SetUp::paper(), Silent);
    let mut session = Session::new(bench, &setup, &mut progress);
    session.begin().unwrap();
    session.start(SampleWindow::ALL).unwrap();
    let mut taken = Vec::new();
    let mut act = Some(in_the_middle);
    while taken.len() < n {
        if taken.len() == n / 2
            && let Some(act) = act.take()
        {
            act();
        }
        taken.push(session.bench.device.next_group().unwrap());
    }
    taken
}

#[test]
#[ignore = "needs QEMU and the firmware: cargo xtask test firmware"]
fn an_emulator_that_is_stopped_for_ten_seconds_goes_on_with_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let firmware = own_firmware(folder.path());
    let mut bench = emulated(&firmware);
    let emulated = groups(&mut bench, 20, || {
        let emulator = emulator_of(&firmware).unwrap();
        kill(emulator, Signal::SIGSTOP).unwrap();
        thread::spawn(move || {
            thread::sleep(Duration::from_secs(10));
            kill(emulator, Signal::SIGCONT).unwrap();
        });
    });
    assert_eq!(emulated[19].samples[Axis::Y.index()].len(), 500);
    assert_eq!(emulated, groups(&mut native(), 20, || {}));
}

#[test]
#[ignore = "needs QEMU and the firmware: cargo xtask test firmware"]
fn an_emulator_that_is_killed_is_named_and_the_recording_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let firmware = own_firmware(folder.path());
    let out = folder.path().join("out");
    let stream = out.join(IN_PROGRESS).join("full-temperature.arrows");
    let mut bench = emulated(&firmware);
    let killer = thread::spawn({
        let stream = stream.clone();
        move || {
            let began = Instant::now();
            while std::fs::metadata(&stream).map_or(0, |file| file.len()) < 200_000 {
                assert!(began.elapsed() < Duration::from_secs(600), "nothing is recorded");
                thread::sleep(Duration::from_millis(5));
            }
            // A power cycle may be under way; it is none while the ramp is recorded.
            kill(emulator_of(&firmware).unwrap(), Signal::SIGKILL).unwrap();
        }
    });
    let unit = Unit::new("ZR-0001", Some((PlantKind::Paper, 1))).unwrap();
    let error = calibrate(&mut bench, &SetUp::paper(), unit, &out, &mut Silent, Keep::Nothing).unwrap_err().to_string();
    killer.join().unwrap();
    assert!(error.contains("QEMU") && error.contains("SIGKILL"), "{error}");
    let recording = Recording::read(&(&stream).into()).unwrap();
    assert!(recording.cut && recording.groups() > 50, "{} groups", recording.groups());
    assert_eq!(recording.rows.len(), 2 * recording.groups());
}

#[test]
#[ignore = "needs QEMU and the firmware: cargo xtask test firmware"]
fn a_program_that_is_no_firmware_is_said_to_be_none() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("firmware.elf");
    std::fs::write(&file, "no ELF").unwrap();
    let unit = UnitSerial::new();
    let error = emulated::bench(PlantKind::Paper.build(1), &SetUp::paper(), &unit, &file).err().unwrap().to_string();
    assert!(error.contains("firmware.elf") && error.contains("cargo xtask firmware"), "{error}");
}

fn run(bench: &mut Bench, out: &Path) -> Summary {
    let unit = Unit::new("ZR-0001", Some((PlantKind::Paper, 1))).unwrap();
    calibrate(bench, &SetUp::paper(), unit, out, &mut Silent, Keep::Nothing).unwrap()
}

/// Every column of every recording, and what is concluded from them.
#[test]
#[ignore = "needs QEMU and the firmware: cargo xtask test firmware"]
fn a_calibration_by_the_firmware_is_the_native_one_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let (by_host, by_board) = (folder.path().join("native"), folder.path().join("emulated"));
    let native = run(&mut native(), &by_host);
    let began = Instant::now();
    let emulated = run(&mut emulated(&firmware()), &by_board);
    println!("calibrate --device emulated took {} s", began.elapsed().as_secs());
    let parts = |summary: &Summary| {
        let summary = serde_json::to_value(summary).unwrap();
        ["axes", "tests"].map(|part| summary[part].clone())
    };
    assert_eq!(parts(&native), parts(&emulated));
    assert!(parts(&native)[1].as_array().is_some_and(|tests| tests.len() == 6));
    let mut compared = 0;
    for entry in std::fs::read_dir(&by_host).unwrap().flatten() {
        let path = entry.path();
        if path.extension().is_none_or(|extension| extension != "parquet") {
            continue;
        }
        let other = by_board.join(path.file_name().unwrap());
        let (native, emulated) =
            (Recording::read(&(&path).into()).unwrap(), Recording::read(&(&other).into()).unwrap());
        assert!(native.groups() > 100);
        for (native, emulated) in native.rows.iter().zip(&emulated.rows) {
            // Each number written so that no two are written alike: of floats the shortest text that reads back.
            assert_eq!(format!("{native:?}"), format!("{emulated:?}"), "{}", path.display());
        }
        assert_eq!(native.rows.len(), emulated.rows.len());
        compared += 1;
    }
    assert_eq!(compared, 5, "the ramp, the sweep, two tests and the soaks");
}

/// The first groups of a calibrated board after its power came, which nobody told to take any.
fn first_groups(mut bench: Bench) -> Vec<GroupReport> {
    let mut record = paper_record::record([8500.0, 11_900.0], None, 0.05);
    record.unit = UnitSerial::try_from("ZR-0001").unwrap();
    bench.device.identify().unwrap();
    bench.device.deploy(&record).unwrap();
    bench.power.cycle().unwrap();
    bench.device.restarted();
    assert!(bench.device.identify().unwrap().running);
    bench.device.order(Request::SetStream { groups: true, samples: SampleWindow::NONE }).unwrap();
    // A group that does not come is an error after its time.
    (0..8).filter_map(|_| Some(bench.device.next_group().ok()?.report)).collect()
}

#[test]
#[ignore = "needs QEMU and the firmware: cargo xtask test firmware"]
fn a_calibrated_board_goes_to_work_when_its_power_comes_as_the_native_one_does() {
    let emulated = first_groups(emulated(&firmware()));
    assert!(emulated.len() == 8 && emulated[0].axes[0].moved_to.is_some());
    assert_eq!(emulated, first_groups(native()));
}

#[test]
#[ignore = "needs QEMU and the firmware: cargo xtask test firmware"]
fn the_emulated_boards_tick_tries_a_port_again_that_did_not_answer_when_its_power_came() {
    let broken = || {
        let mut plant = PlantKind::Paper.build(1);
        plant.inject(Fault::PortSpi { transfers: 1 });
        plant
    };
    let emulated = first_groups(emulated_on(broken(), &firmware()));
    assert_eq!((emulated.len(), emulated[0].acquisition_errors), (7, 2), "not reached, then set up anew");
    assert_eq!(emulated, first_groups(native_on(broken())));
}
