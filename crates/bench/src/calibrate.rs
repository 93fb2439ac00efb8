//! The main job: the paper's whole experiment on one unit, from the first ramp to the report.

use std::path::Path;
use std::time::Instant;

use zerorate_cal::calibration::Source;
use zerorate_cal::recording::RecordingInfo;
use zerorate_core::compensate::Mode;
use zerorate_core::units::Axis;

use crate::calibrated::{Calibrated, Unit};
use crate::characterise::{characterise, first_time};
use crate::client::LineCounts;
use crate::error::BenchError;
use crate::instruments::Bench;
use crate::output::OutputFolder;
use crate::procedure::compensation_test::Extent;
use crate::procedure::soaks;
use crate::results;
use crate::run::{Progress, Session};
use crate::setup::SetUp;
use crate::summary::Summary;
use crate::verify::{check, deploy, test};

const FULL_TEMPERATURE: &str = "full-temperature.parquet";
const TRIM_SWEEP: &str = "trim-sweep.parquet";
const SOAKS: &str = "soaks.parquet";

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
        labels: setup.labels.clone(),
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
        let LineCounts { lost_uploads, damaged_frames, .. } = line;
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
    results::write(&run, &summary, &mut output)?;
    output.publish()?;
    Ok((run, summary))
}
