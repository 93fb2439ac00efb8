//! `cargo xtask`: the project's chores.
//!
//! `cargo xtask test` is what a change must pass. It installs what it needs when it may, and otherwise names it.

mod arrows;
mod browser;
mod cargo;
mod devtools;
mod house;
mod no_std;
mod provide;
mod python;
mod report;
mod steps;
mod workspace;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

use steps::{Outcome, Step};
use workspace::Workspace;

#[derive(Parser)]
#[command(
    name = "cargo xtask",
    about = "The project's chores",
    disable_help_subcommand = false
)]
struct Arguments {
    #[command(subcommand)]
    chore: Chore,
}

#[derive(Subcommand)]
enum Chore {
    /// Run every check, in order, and stop at the first that fails
    ///
    /// Formatting, lints, documentation and tests by cargo; the rules of ARCHITECTURE.md by reading the sources; then
    /// the built command against numpy, against damaged recordings, and its report in a headless browser. Python's
    /// venv and Chromium are installed if this runs as root on Debian, and named if it does not.
    ///
    /// Recordings are looked for in ../shared/data, or in the folder that the variable ZERORATE_DATA names.
    Test {
        /// Leave out what needs Python or a browser
        #[arg(long)]
        fast: bool,
        /// Run these steps only: format, clippy, rustdoc, tests, no_std, arrows, house, build, numpy, damage, report
        #[arg(value_name = "STEP")]
        only: Vec<String>,
    },
}

fn main() -> Result<ExitCode> {
    let Chore::Test { fast, only } = Arguments::parse().chore;
    let workspace = Workspace::of_this_run()?;
    Ok(steps::run(&steps::chosen(checks(&workspace, fast), &only)?))
}

/// Every check, cheapest news first within each kind.
fn checks(workspace: &Workspace, fast: bool) -> Vec<Step<'_>> {
    let mut steps = vec![
        Step::new("format", "run `cargo fmt`", || {
            cargo::run(workspace, &["fmt", "--all", "--check"])
        }),
        Step::new(
            "clippy",
            "mend what it points at; `cargo clippy --fix` does the simple ones",
            || {
                cargo::run(
                    workspace,
                    &[
                        "clippy",
                        "--workspace",
                        "--all-targets",
                        "--",
                        "-D",
                        "warnings",
                    ],
                )
            },
        ),
        Step::new(
            "rustdoc",
            "mend the links and docstrings it points at",
            || cargo::document(workspace),
        ),
        Step::new(
            "tests",
            "run the failed test alone: `cargo test -p CRATE NAME`",
            || cargo::run(workspace, &["test", "--workspace"]),
        ),
        Step::new(
            "no_std",
            "keep std, files and clocks on the host side: see ARCHITECTURE.md",
            || no_std::check(workspace),
        ),
        Step::new(
            "arrows",
            "move the code to where the arrow allows it, or argue for an arrow",
            || arrows::check(workspace),
        ),
        Step::new(
            "house",
            "see CONTRIBUTING.md for the habit behind the rule",
            || house::check(workspace),
        ),
    ];
    let built = [
        Step::new("build", "mend the build", || {
            cargo::run(workspace, &["build", "--release", "--package", "zerorate"])
        }),
        Step::new(
            "numpy",
            "the plain fit must be ordinary least squares; see crates/xtask/python",
            || python::compare_fit(workspace),
        ),
        Step::new("damage", "see the checks of quality in crates/cal", || {
            python::damaged_recordings(workspace)
        }),
        Step::new("report", "look at target/report-screenshots", || {
            report::check(workspace)
        }),
    ];
    if fast {
        steps.extend(
            built
                .into_iter()
                .map(|step| step.replaced_by(|| Ok(Outcome::Skipped("--fast".into())))),
        );
    } else {
        steps.extend(built);
    }
    steps
}
