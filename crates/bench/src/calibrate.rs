//! The main job: the paper's whole experiment on one unit, from the first ramp to the report.

use std::path::Path;
use std::time::{Instant, SystemTime};

use zerorate_board_run::folder::{FULL_TEMPERATURE, HYBRID_TEST, POWER, POWER_UNKNOWN, TRIM_TEST};
use zerorate_board_run::summary::Summary;
use zerorate_cal::calibration::Origin;
use zerorate_cal::recording::{Recording, RecordingInfo};
use zerorate_core::compensate::Mode;
use zerorate_core::units::Axis;
use zerorate_core::wire::{CalibrationState, Request};

use crate::calibrated::{Calibrated, Unit};
use crate::checkpoint::{Checkpoints, Keep};
use crate::client::LineCounts;
use crate::error::BenchError;
use crate::instruments::{Bench, rest_for};
use crate::measure::{self, first_time, measure_on};
use crate::output::{self, OutputFolder};
use crate::plan::Part;
use crate::procedure::compensation_test::{self, Extent};
use crate::procedure::soaks;
use crate::results::{self, SOAKS, TRIM_SWEEP};
use crate::run::{Progress, Recorder, Session};
use crate::setup::SetUp;
use crate::soak_comparison;
use crate::summary::{cut_short, summary};
use crate::verify::{Verification, check, deploy, evaluated};
use crate::way_back;

/// Runs everything on one unit and writes the results into `out`; returns the summary. On a bench that takes
/// days `keep` has each procedure kept that was carried through, so that a run that was stopped goes on after it.
///
/// # Errors
/// [`BenchError`]; earlier results in `out` are then untouched, and what was to be kept is.
pub fn calibrate(
    bench: &mut Bench,
    setup: &SetUp,
    unit: Unit,
    out: &Path,
    progress: &mut dyn Progress,
    keep: Keep,
) -> Result<Summary, BenchError> {
    let was_there = out.exists();
    let result = run(bench, setup, unit, out, progress, keep);
    if progress.is_interrupted() && bench.clock.is_none() {
        progress.note(
            "stopping: what obeys a program is brought to rest, for half a minute; a second Ctrl-C leaves it as it is",
        );
    }
    // Somebody has to go there: that is what is told, on the screen and by a message.
    let rested = bench.rest(&|waited| waited < rest_for(progress.is_interrupted()));
    let result = match (result, rested) {
        (result, Ok(())) => result,
        (Ok(_), Err(left_on)) => Err(BenchError::DoneLeftOn(left_on)),
        (Err(first), Err(left_on)) => Err(BenchError::LeftOn { first: Box::new(first), left_on }),
    };
    // A run that has refused to begin leaves what there is for the one that goes on with it.
    if !result.as_ref().is_err_and(BenchError::is_refused) {
        output::tidy(out);
    }
    if !was_there {
        // Only a folder with nothing in it goes.
        let _ = std::fs::remove_dir(out);
    }
    if result.as_ref().is_err_and(BenchError::is_interrupted) {
        // The board is left as it was found, if it still answers.
        let _ = bench.device.order(Request::SetAcquisition { run: false });
    }
    result
}

fn run(
    bench: &mut Bench,
    setup: &SetUp,
    unit: Unit,
    out: &Path,
    progress: &mut dyn Progress,
    keep: Keep,
) -> Result<Summary, BenchError> {
    let (began, started) = (Instant::now(), SystemTime::now());
    let mut output = OutputFolder::open(out)?;
    let identity = bench.device.identify()?;
    let checkpoints = Checkpoints::open(output.in_progress(), keep, &format!("{}\n{}", unit.serial, setup.to_toml()))?;
    let timing = (identity.samples_per_group, identity.sample_period_us);
    if timing != (setup.acquisition.group_length, setup.acquisition.sample_period_us) {
        return Err(BenchError::OtherTiming { samples: timing.0, period_us: timing.1 });
    }
    let [major, minor, patch] = identity.firmware;
    let info = |procedure: &str| RecordingInfo {
        unit_serial: unit.serial.to_string(),
        procedure: procedure.into(),
        set_up: setup.to_toml(),
        firmware: format!("{major}.{minor}.{patch}"),
        seed: unit.plant.map(|(_, seed)| seed),
        started: unit.plant.is_none().then(|| SystemTime::now().into()),
        labels: setup.labels.clone(),
    };
    let mut session = Session::new(bench, setup, progress);
    session.plan(|part| left_of(part, &checkpoints, setup));
    if identity.calibration.is_in_use() {
        session.progress.note("the board holds a calibration: its compensation is off while the unit is measured");
    } else if identity.calibration == CalibrationState::Blank && session.bench.clock.is_none() {
        session.progress.note("a new board? `zerorate device first-time` makes the middle tap that of power-up, once");
    }
    if let Some(left_out) = setup.soaks_left_out() {
        let told = session.warnings.add(left_out);
        session.progress.note(&told);
    }
    first_time(&mut session)?;

    let full =
        output.go_on(FULL_TEMPERATURE, &info("full-temperature"), checkpoints.extent(measure::FULL_TEMPERATURE))?;
    let sweep = output.go_on(TRIM_SWEEP, &info("trim-sweep"), checkpoints.extent(measure::TRIM_SWEEP))?;
    let mut measured = measure_on(&mut session, &unit.serial, full, sweep, &checkpoints)?;
    measured.calibration.simulated = unit.plant.map(|(kind, seed)| format!("plant {}, seed {seed}", kind.name()));
    // While it was stopped the board may have lost its power, and nobody was there to see it.
    if let Some(power) = measured.calibration.labels.get_mut(POWER).filter(|_| checkpoints.is_resumed()) {
        POWER_UNKNOWN.clone_into(power);
    }

    let mut deployed = false;
    let mut verifications = Vec::new();
    for (mode, file) in [(Mode::Trim, TRIM_TEST), (Mode::Hybrid, HYBRID_TEST)] {
        let [of_x, of_y] = Axis::BOTH.map(|axis| checkpoints.extent(&test_name(mode, axis)));
        let mut recorder = output.go_on(file, &info("compensation-test"), of_y.or(of_x))?;
        for (axis, cooling) in [(Axis::X, true), (Axis::Y, false)] {
            let follows = measured.axes[axis.index()].digital_only.is_none();
            // What the wiper cannot follow is corrected in numbers alone; there is nothing to trim.
            let runnable = match mode {
                mode if follows => mode,
                Mode::Hybrid => Mode::Digital,
                _ => continue,
            };
            let extent = Extent { cooling, samples: true };
            let run = checkpoints.once(&test_name(mode, axis), &mut recorder, |recorder| {
                session.part(Part::Test(mode, axis));
                if !std::mem::replace(&mut deployed, true) {
                    deploy(&mut session, &measured)?;
                }
                compensation_test::run(&mut session, &measured.ramp, runnable, axis, extent, recorder)
            })?;
            verifications.push(evaluated(run, &measured, setup));
        }
        recorder.finish()?;
    }

    let has_soaks = !setup.soaks().is_empty();
    let mut recorder = match has_soaks {
        true => output.go_on(SOAKS, &info("soaks"), soaks::extent(&checkpoints, setup.soaks().len()))?,
        false => Recorder::discarding(),
    };
    let soaks = soaks::run_once(&mut session, &mut recorder, &checkpoints)?;
    let soaks = soak_comparison::compared(&soaks, setup, &measured);
    recorder.finish()?;

    let results: Vec<_> = verifications.iter().flat_map(|test| &test.results).collect();
    let warnings = &mut measured.calibration.warnings;
    warnings.extend(results.iter().flat_map(|result| result.warnings()));
    warnings.extend(way_back::untested(&verifications.iter().map(Verification::left).collect::<Vec<_>>()));
    warnings.extend(session.warnings.sentences());
    let line = session.bench.device.counts();
    if line != LineCounts::default() {
        let LineCounts { lost_uploads, damaged_frames, sent_again } = line;
        warnings.push(format!(
            "the line to the device lost {lost_uploads} uploads and damaged {damaged_frames} frames; {sent_again} commands were sent again"
        ));
    }
    let mut checks = check(&results, &setup.limits, setup.board.centre_counts);
    checks.extend(soaks.iter().flat_map(|soaks| soak_comparison::check(soaks, &setup.limits)));
    let origin = |(content, file): (&str, &str)| {
        Origin::of(content, &(&output.path(file)).into()).map_err(|error| BenchError::Compose(error.to_string()))
    };
    let fitted = [("full-temperature", FULL_TEMPERATURE), ("trim-sweep", TRIM_SWEEP)];
    let tested = [("compensation-test", TRIM_TEST), ("compensation-test", HYBRID_TEST), ("soaks", SOAKS)];
    measured.calibration.sources = fitted.into_iter().map(origin).collect::<Result<_, _>>()?;
    let mut recordings = measured.calibration.sources.clone();
    for recording in tested.into_iter().filter(|(_, file)| has_soaks || *file != SOAKS) {
        recordings.push(origin(recording)?);
    }
    let cut_short: Vec<String> = cut_short(&measured, setup).collect();
    measured.calibration.warnings.extend(cut_short.iter().cloned());
    let run = Calibrated { unit, setup: setup.clone(), measured, verifications, soaks, checks, cut_short };
    let summary = summary(&run, recordings, started, began.elapsed().as_secs_f64());
    results::write(&run.measured.calibration, &run.measured.record, &summary, &mut output)?;
    let published = output.publish()?;
    if !has_soaks && Recording::is_one(&(&out.join(SOAKS)).into()) {
        // Of the run whose results these took the place of; a folder has files of one run.
        let _ = std::fs::remove_file(out.join(SOAKS));
    }
    if let Some(aside) = published {
        progress.note(&format!(
            "the results are in {}; something else that was there could not be moved back and is in {}: move it by hand",
            out.display(),
            aside.display()
        ));
    }
    Ok(summary)
}

/// How much of a part is still to do, 0 to 1.
fn left_of(part: Part, kept: &Checkpoints, setup: &SetUp) -> f64 {
    let of = |procedure: &str| if kept.extent(procedure).is_some() { 0.0 } else { 1.0 };
    match part {
        Part::FullTemperature => of(measure::FULL_TEMPERATURE),
        Part::TrimExperiment => of(measure::TRIM_SWEEP),
        Part::Test(mode, axis) => of(&test_name(mode, axis)),
        Part::Soaks => soaks::left(kept, setup.soaks().len()),
    }
}

/// A compensation test, as it is kept.
fn test_name(mode: Mode, axis: Axis) -> String {
    format!("test-{}-{}", mode.name(), axis.name())
}
