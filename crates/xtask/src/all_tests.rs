//! All tests: built by one call of cargo, which lints meanwhile, then run two programs at once. One after the other they
//! would leave the machine idle for as long as some of them wait for a clock.

use std::fs::{self, File};
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::thread;

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

use crate::cargo::{self, Lots};
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// A program of tests, as cargo has built it.
struct Program {
    executable: PathBuf,
    /// Its package's folder, in which it runs.
    folder: PathBuf,
    /// Its source, from the folder.
    source: PathBuf,
}

/// The program whose tests wait for boards and chambers that have a clock: many of them do so at once, beside what computes.
const WAITING: &str = "cli, tests/device/main.rs";

/// Tests that a fast run leaves out: of many units, or of the power cut at every moment, half a minute to two minutes each.
const LONG: [&str; 8] = [
    "ten_times_better_by_the_potentiometer_and_the_floor_by_numbers_seeds_11_to_20",
    "a_history_survives_hysteresis_where_a_static_curve_does_not",
    "no_clean_unit_is_rejected_for_wild_groups",
    "a_wild_group_is_found_in_the_ramp_of_every_unit",
    "the_plants_own_output_at_another_switch_on_lies_within_u_as_often_as_is_said",
    "no_cut_loses_both_records_of_the_greatest_length",
    "no_cut_loses_both_records_with_longer_words_and_smaller_pages",
    "a_run_killed_at_any_moment_leaves_every_whole_group_and_earlier_results",
];

/// Something to run: what it is, and the call.
type Job = (String, Command);

/// All tests pass, those in the documentation too, and clippy and the compiler have nothing to say meanwhile: to lint first,
/// cargo would go through all that others wrote twice. A fast run leaves out what takes longest.
pub fn check(workspace: &Workspace, lots: Lots, fast: bool) -> Result<Outcome> {
    let programs = build(workspace, lots)?;
    ensure!(programs.iter().any(|program| program.name() == WAITING), "there is no program {WAITING}");
    let mut jobs = vec![("documentation".to_owned(), of_documentation(workspace, lots))];
    jobs.extend(programs.iter().map(|program| (program.name(), program.call(fast))));
    jobs.sort_by_key(|(name, _)| name != WAITING);
    println!("    {} programs of tests", jobs.len());
    run(jobs, &workspace.target.join("tests"))?;
    Ok(Outcome::Passed)
}

/// Builds every program of tests.
fn build(workspace: &Workspace, lots: Lots) -> Result<Vec<Program>> {
    let arguments = [&["test"], lots.crates(), &["--no-run", "--message-format", "json-render-diagnostics"]].concat();
    println!("    cargo {}", arguments.join(" "));
    let mut build = cargo::command(workspace);
    let output = cargo::lint_as_built(&mut build).args(arguments).stderr(Stdio::inherit()).output()?;
    ensure!(output.status.success(), "cargo ended with {}", output.status);
    programs(&String::from_utf8(output.stdout)?)
}

/// The programs of tests among what cargo has built: a line of JSON each.
fn programs(said: &str) -> Result<Vec<Program>> {
    let built = said.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let tests = built.filter(|built| built["profile"]["test"] == true && built["executable"].is_string());
    tests
        .map(|built| Program::of(&built).with_context(|| format!("not what cargo says of a program: {built}")))
        .collect()
}

impl Program {
    fn of(built: &Value) -> Option<Self> {
        let path = |value: &Value| value.as_str().map(PathBuf::from);
        let folder = path(&built["manifest_path"])?.parent()?.to_owned();
        let source = path(&built["target"]["src_path"])?.strip_prefix(&folder).ok()?.to_owned();
        Some(Self { executable: path(&built["executable"])?, folder, source })
    }

    fn name(&self) -> String {
        let package = self.folder.file_name().map(Path::new).unwrap_or(&self.folder);
        format!("{}, {}", package.display(), self.source.display())
    }

    fn call(&self, fast: bool) -> Command {
        let mut call = Command::new(&self.executable);
        call.current_dir(&self.folder);
        // A benchmark, which runs once here, knows no tests to skip.
        if fast && !self.source.starts_with("benches") {
            call.args(LONG.iter().flat_map(|test| ["--skip", test]));
        }
        call
    }
}

/// What stands in the documentation is built and run by cargo alone.
fn of_documentation(workspace: &Workspace, lots: Lots) -> Command {
    let mut test = cargo::command(workspace);
    cargo::lint_as_built(&mut test).args([&["test"], lots.crates(), &["--doc"]].concat());
    test
}

/// Runs all, two at once; what one says is kept in `logs` and printed when it ends. After a failure nothing more is begun.
fn run(jobs: Vec<Job>, logs: &Path) -> Result<()> {
    // Of programs that are no more none may be left.
    if logs.is_dir() {
        fs::remove_dir_all(logs)?;
    }
    fs::create_dir_all(logs).with_context(|| logs.display().to_string())?;
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let left = Mutex::new(jobs.into_iter().enumerate());
    let left = || left.lock().unwrap_or_else(PoisonError::into_inner);
    // Ends with what failed, if anything.
    let work = || {
        loop {
            let (number, (name, mut call)) = left().next()?;
            let threads = if name == WAITING { 2 * cores } else { cores };
            call.env("RUST_TEST_THREADS", threads.to_string()).stdin(Stdio::null());
            if !passes(&name, &mut call, &logs.join(format!("{number}.log"))) {
                left().by_ref().for_each(drop);
                return Some(name);
            }
        }
    };
    let failed: Vec<String> = thread::scope(|scope| {
        let workers: Vec<_> = (0..2).map(|_| scope.spawn(work)).collect();
        workers.into_iter().filter_map(|worker| worker.join().unwrap_or(Some("a panic".into()))).collect()
    });
    if !failed.is_empty() {
        bail!("tests failed in {}: see above", failed.join("; "));
    }
    Ok(())
}

/// Runs a program and prints what it said; whether it ended well.
fn passes(name: &str, call: &mut Command, log: &Path) -> bool {
    // Not through a pipe: what a test that failed has left running would hold it open.
    let ended = File::create(log).and_then(|said| call.stdout(said.try_clone()?).stderr(said).status());
    let said = fs::read(log).unwrap_or_default();
    println!("     Running {name}\n{}", String::from_utf8_lossy(&said));
    match ended {
        Ok(status) => status.success(),
        Err(error) => {
            println!("    {name} could not be run: {error}");
            false
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_of_tests_are_told_from_what_else_cargo_builds() {
        let line = |test: bool, executable: &str| {
            format!(
                r#"{{"reason":"compiler-artifact","manifest_path":"/p/crates/cli/Cargo.toml","target":{{"src_path":"/p/crates/cli/tests/device/main.rs"}},"profile":{{"test":{test}}},"executable":{executable}}}"#
            )
        };
        let said =
            [line(true, "\"/t/device-1\""), line(false, "\"/t/zerorate\""), line(true, "null"), "{}".into()].join("\n");
        let found = programs(&said).unwrap();
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].name(), "cli, tests/device/main.rs");
        assert_eq!(found[0].call(false).get_current_dir(), Some(Path::new("/p/crates/cli")));
        assert_eq!(found[0].call(true).get_args().len(), 2 * LONG.len());
        let benchmark = Program { source: "benches/kernel.rs".into(), ..found.into_iter().next().unwrap() };
        assert_eq!(benchmark.call(true).get_args().len(), 0);
    }

    #[cfg(unix)]
    #[test]
    fn every_program_runs_and_one_that_fails_is_named() {
        let logs = std::env::temp_dir().join(format!("zerorate-tests-{}", std::process::id()));
        let job = |name: &str, ends: &str| (name.to_owned(), Command::new(ends));
        assert!(run((0..9).map(|n| job(&n.to_string(), "true")).collect(), &logs).is_ok());
        assert_eq!(fs::read_dir(&logs).unwrap().count(), 9);
        let jobs = vec![job("well", "true"), job("badly", "false"), job("nowhere", "/no/program")];
        let error = run(jobs, &logs).unwrap_err();
        assert!(error.to_string().contains("badly"), "{error}");
        fs::remove_dir_all(logs).unwrap();
    }
}
