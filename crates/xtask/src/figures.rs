//! Runs two builds of `zerorate` side by side and compares their figures digit by digit: a change that only moves code must
//! move none of them.

pub mod difference;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::python;
use crate::steps::Outcome;
use crate::workspace::Workspace;
use difference::{Difference, between, between_bytes, between_lines};

/// Differences that are printed of one output, the largest first.
const MOST_TOLD: usize = 10;

/// The seeds of the calibrations.
const SEEDS: [&str; 3] = ["1", "2", "3"];

/// How much is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// Everything.
    All,
    /// One calibration, and one log by the model that is chosen: for a program that an emulator runs.
    Few,
}

/// What is compared.
pub struct Comparison<'a> {
    /// The workspace, for its folders and for Python.
    pub workspace: &'a Workspace,
    /// The build whose figures hold.
    pub before: PathBuf,
    /// The build that must have the same.
    pub after: PathBuf,
    /// How much of it.
    pub extent: Extent,
    /// By so much of itself a number may differ: 0, or what another order of the same sums makes.
    pub within: f64,
    /// Whether the protocol of held-out figures is run as well.
    pub held_out: bool,
}

/// One call of the command, made by both builds.
struct Job {
    name: String,
    /// Whether it is one of the few.
    is_among_few: bool,
    arguments: Vec<String>,
    /// Files and folders that it writes, whose figures count as well.
    written: Vec<String>,
}

/// What the builds differ in, of one output.
struct Output {
    name: String,
    differences: Vec<Difference>,
}

impl Comparison<'_> {
    /// Runs everything; an error if any figure differs.
    pub fn run(&self) -> Result<Outcome> {
        let folder = self.workspace.target.join("figures");
        if folder.is_dir() {
            fs::remove_dir_all(&folder).with_context(|| folder.display().to_string())?;
        }
        for build in ["before", "after"] {
            fs::create_dir_all(folder.join(build)).with_context(|| folder.display().to_string())?;
        }
        let mut jobs = simulations();
        let recording = self.workspace.recording();
        match &recording {
            Some(recording) => jobs.extend(fits(&self.logs(&folder, recording)?)),
            None => {
                println!("    without the real recording: no ../shared/data, and ZERORATE_DATA names no other folder")
            }
        }
        if self.extent == Extent::Few {
            jobs.retain(|job| job.is_among_few);
        }
        let mut outputs = Vec::new();
        for job in &jobs {
            println!("    {}", job.name);
            outputs.extend(self.compare(&folder, job)?);
        }
        if let Some(recording) = recording.filter(|_| self.held_out) {
            println!("    held out");
            outputs.push(self.compare_held_out(&recording)?);
        }
        told(outputs, self.within)
    }

    /// The chamber cycle as the formats have it.
    fn logs(&self, folder: &Path, recording: &Path) -> Result<Vec<PathBuf>> {
        let prefix = folder.join("chamber");
        let encoded = python::encoded(self.workspace, recording, &prefix, &[])?;
        Ok(encoded.into_iter().chain([recording.to_owned()]).collect())
    }

    fn compare(&self, folder: &Path, job: &Job) -> Result<Vec<Output>> {
        let run = |program: &Path, build: &str| {
            let mut command = Command::new(program);
            let output = command.args(&job.arguments).current_dir(folder.join(build)).output();
            let output = output.with_context(|| format!("{} could not be started", program.display()))?;
            // 1 is a unit or a log that was rejected: a result like any other.
            let code = output.status.code().filter(|code| [0, 1].contains(code));
            let code = code.with_context(|| {
                let told = String::from_utf8_lossy(&output.stderr).into_owned();
                format!("{} {} ended with {}: {told}", program.display(), job.arguments.join(" "), output.status)
            })?;
            let printed = serde_json::from_slice(&output.stdout)
                .with_context(|| format!("{} {}: no JSON on standard output", program.display(), job.name))?;
            anyhow::Ok((Value::from(code), printed))
        };
        let (before, after) = (run(&self.before, "before")?, run(&self.after, "after")?);
        let mut differences = between(&before.1, &after.1);
        differences.extend(between(&before.0, &after.0).into_iter().map(|found| found.under("exit code")));
        let mut outputs = vec![Output { name: job.name.clone(), differences }];
        for written in &job.written {
            for file in files(folder, written)? {
                let [before, after] = ["before", "after"].map(|build| fs::read(folder.join(build).join(&file)).ok());
                let name = file.display().to_string();
                outputs.push(Output { differences: of_file(&file, before, after), name });
            }
        }
        Ok(outputs)
    }

    fn compare_held_out(&self, recording: &Path) -> Result<Output> {
        let script = python::tool(self.workspace, "held_out.py")?;
        let figures =
            |program: &Path| python::printed(self.workspace, &[&script, recording, Path::new("--program"), program]);
        let differences = between_lines(&figures(&self.before)?, &figures(&self.after)?);
        Ok(Output { name: "held out".into(), differences })
    }
}

/// What needs no recording: calibrations and a study.
fn simulations() -> Vec<Job> {
    let owned = |arguments: &[&str]| arguments.iter().map(|&argument| argument.to_owned()).collect::<Vec<_>>();
    let calibrate = |seed: &str| {
        let out = format!("seed-{seed}");
        let arguments = owned(&["calibrate", "--seed", seed, "--out", &out, "--json"]);
        Job { name: format!("calibrate, seed {seed}"), is_among_few: seed == SEEDS[0], arguments, written: vec![out] }
    };
    let study = owned(&["study", "--units", "10", "--seed", "1", "--json"]);
    let study = Job { name: "study of 10 units".into(), is_among_few: false, arguments: study, written: Vec::new() };
    SEEDS.into_iter().map(calibrate).chain([study]).collect()
}

/// The model that is chosen and a plain cubic, of each log.
fn fits(logs: &[PathBuf]) -> Vec<Job> {
    let models: [(&str, &[&str]); 2] = [("auto", &["--model", "auto"]), ("cubic", &["--plain", "--model", "poly:3"])];
    let job = |log: &PathBuf, (name, model): (&str, &[&str])| {
        let form = log.extension().unwrap_or_default().to_string_lossy();
        let (out, report) = (format!("{form}-{name}.json"), format!("{form}-{name}.html"));
        let mut arguments = vec!["fit".to_owned(), log.display().to_string()];
        arguments.extend(["--json", "--out", &out, "--report", &report].map(str::to_owned));
        arguments.extend(model.iter().map(|&argument| argument.to_owned()));
        let is_among_few = form == "ulg" && name == "auto";
        Job { name: format!("fit of the chamber cycle as {form}, {name}"), is_among_few, arguments, written: vec![out] }
    };
    logs.iter().flat_map(|log| models.map(|model| job(log, model))).collect()
}

/// What either build wrote of a file or in a folder, by its path in the build's own; reports are pages and hold no figures
/// that are not in the files beside them.
fn files(folder: &Path, written: &str) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for build in ["before", "after"] {
        let path = folder.join(build).join(written);
        if path.is_dir() {
            for entry in fs::read_dir(&path).with_context(|| path.display().to_string())? {
                found.push(Path::new(written).join(entry?.file_name()));
            }
        } else if path.is_file() {
            found.push(written.into());
        }
    }
    found.sort();
    found.dedup();
    found.retain(|file| file.extension().is_none_or(|extension| extension != "html"));
    Ok(found)
}

fn of_file(file: &Path, before: Option<Vec<u8>>, after: Option<Vec<u8>>) -> Vec<Difference> {
    let (Some(before), Some(after)) = (&before, &after) else {
        let there = |found: bool| if found { "written" } else { "not written" };
        return vec![Difference::of_words("", there(before.is_some()), there(after.is_some()))];
    };
    let json = |bytes: &[u8]| serde_json::from_slice::<Value>(bytes).ok();
    match (json(before), json(after)) {
        (Some(before), Some(after)) if file.extension().is_some_and(|extension| extension == "json") => {
            between(&before, &after)
        }
        _ => between_bytes(before, after),
    }
}

/// Prints what differs by more than it may, and is an error if anything does.
fn told(mut outputs: Vec<Output>, within: f64) -> Result<Outcome> {
    let mut worst: Option<(f64, String)> = None;
    let (mut differ, mut near) = (0, 0);
    for Output { name, differences } in &mut outputs {
        let all = differences.len();
        differences.retain(|difference| within <= 0.0 || difference.relative() > within);
        near += all - differences.len();
        if differences.is_empty() {
            continue;
        }
        differ += differences.len();
        println!("    {name}: {} differ", differences.len());
        let mut sorted: Vec<&Difference> = differences.iter().collect();
        sorted.sort_by(|a, b| b.relative().total_cmp(&a.relative()));
        sorted.iter().take(MOST_TOLD).for_each(|difference| println!("        {difference}"));
        if sorted.len() > MOST_TOLD {
            println!("        and {} more", sorted.len() - MOST_TOLD);
        }
        let numbers = sorted.iter().filter(|difference| difference.relative().is_finite());
        if let Some(largest) = numbers.max_by(|a, b| a.relative().total_cmp(&b.relative()))
            && worst.as_ref().is_none_or(|(worst, _)| largest.relative() > *worst)
        {
            worst = Some((largest.relative(), format!("{name}: {largest}")));
        }
    }
    if let Some((relative, place)) = worst {
        println!("    the largest relative difference of a number is {relative:.1e}, in {place}");
    }
    if near > 0 {
        println!("    {near} numbers differ by no more than {within:e} of themselves");
    }
    ensure!(differ == 0, "{differ} figures differ");
    if near == 0 {
        println!("    {} outputs, every digit the same", outputs.len());
    }
    Ok(Outcome::Passed)
}
