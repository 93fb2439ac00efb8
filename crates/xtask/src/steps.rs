//! Runs steps in order, says what each is and how long it took, and stops at the first failure.

use std::process::ExitCode;
use std::time::Instant;

use anyhow::{Result, bail};

use crate::provide::Missing;

/// How a step ended when it did not fail.
pub enum Outcome {
    /// It ran, and found nothing wrong.
    Passed,
    /// It did not run; the text says why.
    Skipped(String),
}

/// One thing to check.
pub struct Step<'a> {
    name: &'static str,
    remedy: &'static str,
    action: Box<dyn Fn() -> Result<Outcome> + 'a>,
}

impl<'a> Step<'a> {
    /// A step called `name` that does `action`; `remedy` is said when it fails.
    pub fn new(name: &'static str, remedy: &'static str, action: impl Fn() -> Result<Outcome> + 'a) -> Self {
        Self { name, remedy, action: Box::new(action) }
    }

    /// What it is called.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// The same step, which only says `why` it does not run if `condition` holds.
    pub fn skipped_if(self, condition: bool, why: &'static str) -> Self {
        if !condition {
            return self;
        }
        Self { action: Box::new(move || Ok(Outcome::Skipped(why.to_owned()))), ..self }
    }
}

/// The steps of the given names, in their own order, all of them if no name is given; less those `without`.
pub fn chosen<'a>(steps: Vec<Step<'a>>, names: &[String], without: &[String]) -> Result<Vec<Step<'a>>> {
    if let Some(unknown) = names.iter().chain(without).find(|name| steps.iter().all(|step| step.name != **name)) {
        bail!("there is no step `{unknown}`: `cargo xtask help test` lists them");
    }
    let named = |step: &Step, names: &[String]| names.iter().any(|name| name == step.name);
    let is_chosen = |step: &Step| (names.is_empty() || named(step, names)) && !named(step, without);
    Ok(steps.into_iter().filter(is_chosen).collect())
}

/// Runs all steps up to the first failure and closes with one line of counts.
pub fn run(steps: &[Step]) -> ExitCode {
    let started = Instant::now();
    let (mut passed, mut failed) = (0, 0);
    let mut skipped = Vec::new();
    for (index, step) in steps.iter().enumerate() {
        println!("\n==> {}/{} {}", index + 1, steps.len(), step.name);
        let step_started = Instant::now();
        let outcome = (step.action)();
        let took_s = step_started.elapsed().as_secs_f64();
        match outcome {
            Ok(Outcome::Passed) => {
                passed += 1;
                println!("    {}: passed in {took_s:.1} s", step.name);
            }
            Ok(Outcome::Skipped(why)) => {
                println!("    {}: skipped, {why}", step.name);
                skipped.push(step.name);
            }
            Err(error) => {
                failed += 1;
                println!("    {}: FAILED after {took_s:.1} s: {error:#}", step.name);
                // What is missing is no fault of the project's, and its message has its own remedy.
                if !error.is::<Missing>() {
                    println!("    what to do: {}", step.remedy);
                }
                break;
            }
        }
    }
    println!("\n{:.0} s in all", started.elapsed().as_secs_f64());
    if !skipped.is_empty() {
        println!("not run: {}", skipped.join(", "));
    }
    println!("steps: {passed} passed, {failed} failed, {} skipped", skipped.len());
    if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn steps_are_chosen_by_name_and_keep_their_order() {
        let steps = || ["format", "clippy", "tests"].map(|name| Step::new(name, "", || Ok(Outcome::Passed))).into();
        let owned = |names: &[&str]| -> Vec<String> { names.iter().map(|&name| name.to_owned()).collect() };
        let names = |only: &[&str], without: &[&str]| -> Result<Vec<&str>> {
            Ok(chosen(steps(), &owned(only), &owned(without))?.iter().map(|step| step.name).collect())
        };
        assert_eq!(names(&[], &[]).unwrap(), ["format", "clippy", "tests"]);
        assert_eq!(names(&["tests", "format"], &[]).unwrap(), ["format", "tests"]);
        assert_eq!(names(&[], &["clippy"]).unwrap(), ["format", "tests"]);
        for (only, without) in [(["lint"].as_slice(), [].as_slice()), (&[], &["lint"])] {
            assert!(names(only, without).unwrap_err().to_string().contains("`lint`"));
        }
    }

    #[test]
    fn nothing_runs_after_a_failure() {
        let ran = Cell::new(0);
        let count = |outcome: fn() -> Result<Outcome>| {
            let ran = &ran;
            move || {
                ran.set(ran.get() + 1);
                outcome()
            }
        };
        let code = run(&[
            Step::new("first", "", count(|| Ok(Outcome::Passed))),
            Step::new("second", "", count(|| Ok(Outcome::Skipped("no reason".into())))),
            Step::new("third", "", count(|| anyhow::bail!("broken"))),
            Step::new("fourth", "", count(|| Ok(Outcome::Passed))),
        ]);
        assert_eq!(code, ExitCode::FAILURE);
        assert_eq!(ran.get(), 3);
    }
}
