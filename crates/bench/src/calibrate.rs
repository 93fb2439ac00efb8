//! The main job: the paper's whole experiment on one unit, from the first ramp to the report.

use std::path::Path;
use std::time::Instant;

use zerorate_cal::calibration::{AxisCalibration, Calibration, Kind, Source, TrimCalibration};
use zerorate_cal::quality::TemperatureUnit;
use zerorate_cal::recording::RecordingInfo;
use zerorate_core::compensate::Mode;
use zerorate_core::record::{MAX_RECORD_BYTES, UnitSerial};
use zerorate_core::units::{Axis, TemperatureScale};

use crate::characterise::{Character, characterise, first_time};
use crate::client::LineCounts;
use crate::error::BenchError;
use crate::evaluate::TestResult;
use crate::instruments::Bench;
use crate::output::OutputFolder;
use crate::plants::PlantKind;
use crate::procedure::compensation_test::Extent;
use crate::procedure::soaks::{self, Soaks};
use crate::run::{Progress, Session};
use crate::setup::SetUp;
use crate::story;
use crate::summary::Summary;
use crate::verify::{Check, Verification, check, deploy, test};

const FULL_TEMPERATURE: &str = "full-temperature.parquet";
const TRIM_SWEEP: &str = "trim-sweep.parquet";
const SOAKS: &str = "soaks.parquet";

/// The unit on the bench.
#[derive(Debug, Clone)]
pub struct Unit {
    /// Its serial.
    pub serial: UnitSerial,
    /// The simulated plant and its seed; `None` on a real bench.
    pub plant: Option<(PlantKind, u64)>,
}

impl Unit {
    /// A unit by its serial.
    ///
    /// # Errors
    /// [`BenchError::SerialTooLong`].
    pub fn new(serial: &str, plant: Option<(PlantKind, u64)>) -> Result<Self, BenchError> {
        let serial = UnitSerial::try_from(serial).map_err(|_| BenchError::SerialTooLong(serial.into()))?;
        Ok(Self { serial, plant })
    }
}

/// A unit that went through everything.
#[derive(Debug, Clone)]
pub struct Calibrated {
    /// The unit.
    pub unit: Unit,
    /// The set-up.
    pub setup: SetUp,
    /// What was found out about it.
    pub character: Character,
    /// The compensation tests: X trim and hybrid, heating and cooling; Y the same, heating.
    pub verifications: Vec<Verification>,
    /// The traditional test, to compare with.
    pub soaks: Soaks,
    /// What was checked.
    pub checks: Vec<Check>,
    /// Name and SHA-256 of the recordings that the calibration rests on.
    pub sources: Vec<Source>,
}

impl Calibrated {
    /// The results of all tests, in the order of `summary.json`: heating, cooling, the swapped pair.
    pub fn results(&self) -> impl Iterator<Item = &TestResult> {
        let of = |axis: &'static str, direction: &'static str| {
            let all = self.verifications.iter().flat_map(|verification| &verification.results);
            all.filter(move |result| result.axis == axis && result.direction == direction)
        };
        of("x", "heating").chain(of("x", "cooling")).chain(of("y", "heating")).chain(of("y", "cooling"))
    }

    /// Whether every check is within its limit.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.checks.iter().all(|check| check.pass)
    }

    /// What was outside its limit, a sentence each.
    pub fn failed_checks(&self) -> impl Iterator<Item = String> {
        let failed = self.checks.iter().filter(|check| !check.pass);
        failed.map(|check| format!("{}: {}, limit {}", check.what, check.measured, check.limit))
    }
}

/// Runs everything on one unit and writes the results into `out`; returns them with the summary.
///
/// # Errors
/// [`BenchError`]; earlier results in `out` are then untouched.
pub fn calibrate(
    bench: &mut Bench,
    setup: &SetUp,
    unit: Unit,
    out: &Path,
    progress: &mut dyn Progress,
) -> Result<(Calibrated, Summary), BenchError> {
    let began = Instant::now();
    let mut output = OutputFolder::open(out)?;
    let identity = bench.device.identify()?;
    let [major, minor, patch] = identity.firmware;
    let info = |procedure: &str| RecordingInfo {
        unit_serial: unit.serial.to_string(),
        procedure: procedure.into(),
        set_up: setup.to_toml(),
        firmware: format!("{major}.{minor}.{patch}"),
        seed: unit.plant.map(|(_, seed)| seed),
    };
    let mut session = Session::new(bench, setup, progress);
    first_time(&mut session)?;

    let full = output.record(FULL_TEMPERATURE, &info("full-temperature"))?;
    let sweep = output.record(TRIM_SWEEP, &info("trim-sweep"))?;
    let mut character = characterise(&mut session, &unit.serial, full, sweep)?;

    deploy(&mut session, &character)?;
    let mut verifications = Vec::new();
    for (mode, file) in
        [(Mode::Trim, "compensation-test-trim.parquet"), (Mode::Hybrid, "compensation-test-hybrid.parquet")]
    {
        let mut recorder = output.record(file, &info("compensation-test"))?;
        for (axis, cooling) in [(Axis::X, true), (Axis::Y, false)] {
            let follows = character.axes[axis.index()].composed.digital_only.is_none();
            // What the wiper cannot follow is corrected in numbers alone; there is nothing to trim.
            let runnable = match mode {
                mode if follows => mode,
                Mode::Hybrid => Mode::Digital,
                _ => continue,
            };
            let extent = Extent { cooling, samples: true };
            verifications.push(test(&mut session, &character, runnable, axis, extent, &mut recorder)?);
        }
        recorder.finish()?;
    }

    let mut recorder = output.record(SOAKS, &info("soaks"))?;
    let soaks = soaks::run(&mut session, &mut recorder)?;
    recorder.finish()?;

    let line = session.bench.device.counts();
    if line != LineCounts::default() {
        let LineCounts { lost_uploads, damaged_frames } = line;
        character.warnings.push(format!(
            "the line to the device lost {lost_uploads} uploads and damaged {damaged_frames} frames: groups may be missing"
        ));
    }
    let checks = check(&verifications, &setup.limits, setup.board.centre_counts);
    let sources = [("full-temperature", FULL_TEMPERATURE), ("trim-sweep", TRIM_SWEEP)]
        .map(|(content, file)| Source::of_file(content, &output.path(file)));
    let sources =
        sources.into_iter().collect::<Result<Vec<_>, _>>().map_err(|error| BenchError::Compose(error.to_string()))?;
    let run = Calibrated { unit, setup: setup.clone(), character, verifications, soaks, checks, sources };
    let summary = Summary::of(&run, began.elapsed().as_secs_f64());
    write_results(&run, &summary, &mut output)?;
    output.publish()?;
    Ok((run, summary))
}

fn write_results(run: &Calibrated, summary: &Summary, output: &mut OutputFolder) -> Result<(), BenchError> {
    let composed = |error: &dyn std::fmt::Display| BenchError::Compose(error.to_string());
    let calibration = calibration(run).to_json().map_err(|error| composed(&error))?;
    output.write("calibration.json", calibration.as_bytes())?;
    let mut buffer = [0; MAX_RECORD_BYTES];
    let record = run.character.record.encode(&mut buffer).map_err(|error| composed(&error))?;
    output.write("device-record.bin", record)?;
    output.write("report.html", story::report(run).to_html().as_bytes())?;
    let mut summary = serde_json::to_string_pretty(summary).map_err(|error| composed(&error))?;
    summary.push('\n');
    output.write("summary.json", summary.as_bytes())
}

/// The calibration file of a run.
fn calibration(run: &Calibrated) -> Calibration {
    let axes = Axis::BOTH.map(|axis| {
        let character = &run.character.axes[axis.index()];
        let record = &character.composed.record;
        let trim = TrimCalibration {
            trim: record.trim.clone(),
            better: Some(character.trim.better),
            paper: Some(character.trim.paper),
            dead_band_taps: record.dead_band,
            low_pass: record.low_pass,
            start_up_mode: record.start_up_mode,
        };
        let samples = character.drift.groups * u64::from(run.setup.acquisition.group_length);
        (axis.name().to_owned(), AxisCalibration::of_board_axis(&character.drift, samples, Some(trim)))
    });
    Calibration {
        kind: Kind::AnalogueBoard,
        unit_serial: Some(run.unit.serial.to_string()),
        created_by: zerorate_cal::calibration::CREATED_BY.to_owned(),
        sources: run.sources.clone(),
        temperature_unit: TemperatureUnit::Counts,
        temperature_scale: Some(TemperatureScale::QUARTER_COUNTS),
        axes: axes.into_iter().collect(),
        warnings: run.character.warnings.clone(),
        setup: serde_json::to_value(&run.setup).ok(),
    }
}
