//! What lies beneath a folder: the runs of `calibrate`, each under its unit.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use anyhow::{Context, Result};
use serde::Serialize;
use zerorate_bench::board::Mode;
use zerorate_bench::output::IN_PROGRESS;
use zerorate_board_run::summary::{Summary, TestResult};
use zerorate_cal::calibration::Calibration;
use zerorate_cal::quality::Verdict;
use zerorate_cal::recording::Phase;
use zerorate_words::sentence;

/// A unit and its calibrations, the first first. A simulated one is another than the real one of its serial number, and
/// than one of another plant or seed.
#[derive(Debug, Serialize)]
pub struct Unit {
    pub serial: String,
    pub simulated: bool,
    /// What was simulated: the plant and its seed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plant: Option<String>,
    pub runs: Vec<Run>,
}

/// A calibration in the numbers that are listed.
#[derive(Debug, Serialize)]
pub struct Run {
    pub folder: PathBuf,
    pub started: Option<String>,
    pub simulated: bool,
    pub verdict: Verdict,
    pub axes: BTreeMap<String, AxisOfRun>,
    /// When its summary was written: the order of runs that do not say when they were made.
    #[serde(skip)]
    written: SystemTime,
}

impl Unit {
    /// As people are told which it is.
    pub fn name(&self) -> String {
        match &self.plant {
            Some(plant) => format!("{}, simulated: {plant}", self.serial),
            None => self.serial.clone(),
        }
    }
}

impl Run {
    /// When it was made, as people read it.
    pub fn made(&self) -> String {
        match &self.started {
            // Whole minutes of a time as RFC 3339 has it.
            Some(started) => started.get(..16).unwrap_or(started).replace('T', " "),
            None if self.simulated => "-".to_owned(),
            None => "not known".to_owned(),
        }
    }
}

/// One axis of it.
#[derive(Debug, Serialize)]
pub struct AxisOfRun {
    pub model: String,
    pub drift_pp_counts: f64,
    pub trim_residual_pp_counts: Option<f64>,
    pub hybrid_residual_pp_counts: Option<f64>,
    pub change_counts: Option<f64>,
}

/// The units beneath a folder by their serial numbers, a real one before the simulated ones of the same, and a sentence for each result that cannot be read.
pub fn units(folder: &Path) -> Result<(Vec<Unit>, Vec<String>)> {
    let mut units: BTreeMap<(String, Option<String>), Vec<Run>> = BTreeMap::new();
    let mut unreadable = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).with_context(|| folder.display().to_string())? {
            let entry = entry.with_context(|| folder.display().to_string())?;
            // A link is not followed: it may lead back.
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                if entry.file_name() != IN_PROGRESS {
                    folders.push(entry.path());
                }
            } else if entry.file_name() == "summary.json" {
                match run(&folder, &entry.path()) {
                    Ok((unit, run)) => units.entry(unit).or_default().push(run),
                    Err(error) => unreadable.push(sentence(error.as_ref())),
                }
            }
        }
    }
    let units = units.into_iter().map(|((serial, plant), runs)| Unit {
        serial,
        simulated: plant.is_some(),
        plant,
        runs: in_order(runs, &mut unreadable),
    });
    let units = units.collect();
    unreadable.sort();
    Ok((units, unreadable))
}

/// A run, and of which unit it is: the serial, and the plant of a simulated one.
fn run(folder: &Path, file: &Path) -> Result<((String, Option<String>), Run)> {
    let summary = Summary::read(&file.into())?;
    let written = fs::metadata(file).and_then(|metadata| metadata.modified()).unwrap_or(SystemTime::UNIX_EPOCH);
    let axes = summary.axes.iter().map(|(name, axis)| {
        let left = |modes: &[Mode]| {
            let is_asked = |test: &&TestResult| {
                test.axis.name() == name && test.direction == Phase::Heating && modes.contains(&test.mode)
            };
            summary.tests.iter().find(is_asked).map(|test| test.residual_pp_counts)
        };
        let axis = AxisOfRun {
            model: axis.model.clone(),
            drift_pp_counts: axis.drift_pp_counts,
            trim_residual_pp_counts: left(&[Mode::Trim]),
            hybrid_residual_pp_counts: left(&[Mode::Hybrid, Mode::Digital]),
            change_counts: None,
        };
        (name.clone(), axis)
    });
    let run = Run {
        folder: folder.to_owned(),
        started: summary.started.clone(),
        simulated: summary.plant.is_some(),
        verdict: summary.verdict,
        axes: axes.collect(),
        written,
    };
    let seed = summary.seed.map(|seed| format!(", seed {seed}")).unwrap_or_default();
    let plant = summary.plant.map(|plant| plant + &seed);
    Ok(((summary.serial, plant), run))
}

/// A unit's runs in the order in which they were made, each with what has changed since the one before. Calibrations are read
/// only where there are two.
fn in_order(mut runs: Vec<Run>, unreadable: &mut Vec<String>) -> Vec<Run> {
    runs.sort_by(|a, b| (&a.started, a.written, &a.folder).cmp(&(&b.started, b.written, &b.folder)));
    if runs.len() < 2 {
        return runs;
    }
    let mut before: Option<Calibration> = None;
    for run in &mut runs {
        let read = Calibration::read(&run.folder.join("calibration.json").as_path().into());
        let now = read.inspect_err(|error| unreadable.push(sentence(error))).ok();
        for (name, axis) in &mut run.axes {
            let of = |calibration: &'_ Option<Calibration>| calibration.as_ref()?.axes.get(name).cloned();
            axis.change_counts = of(&before).zip(of(&now)).and_then(|(before, now)| now.distance_from(&before));
        }
        before = now;
    }
    runs
}
