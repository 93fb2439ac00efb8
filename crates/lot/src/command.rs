//! The subcommands, one file each, and how they end.

/// Prints a line in which parameters are options. Who closes the pipe, as `head` does, has read enough.
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        _ = writeln!(std::io::stdout(), "{}", zerorate_words::as_options(&format!($($text)*)));
    }};
}

mod export;
mod fit;
mod group;
mod report;
mod simulate;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use zerorate_words::{as_options, sentence};

/// Whole lots: one fit a unit for thousands of units, on one machine or on a cluster
#[derive(Debug, Parser)]
#[command(name = "zerorate-lot", version, max_term_width = 100, arg_required_else_help = true, after_help = EXAMPLES)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  zerorate lot simulate --units 1000 --seed 1 --out lot1      a lot to try
  zerorate lot fit lot1 --out models.parquet                  one row a fit
  zerorate lot report models.parquet --limits limits.toml --out lot.html
  zerorate lot export ZR-000007 --out ZR-000007
  zerorate lot fit s3://factory/lot7 --out models.parquet --cluster df://scheduler:50050

Exit codes: 0 done; 1 done, and some units were rejected or outside limits, or files skipped; 2 error.";

#[derive(Debug, Subcommand)]
enum Command {
    Fit(fit::Fit),
    Report(report::Report),
    Export(export::Export),
    Group(group::Group),
    Simulate(simulate::Simulate),
}

/// How a command ended that did what it was asked to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Exit code 0.
    Done,
    /// Exit code 1: some units were rejected, or files skipped.
    Rejected,
}

impl Cli {
    /// Runs the command and gives the exit code.
    pub fn run(&self) -> ExitCode {
        let result = match &self.command {
            Command::Fit(fit) => fit.run(),
            Command::Report(report) => report.run(),
            Command::Export(export) => export.run(),
            Command::Group(group) => group.run(),
            Command::Simulate(simulate) => simulate.run(),
        };
        match result {
            Ok(Outcome::Done) => ExitCode::SUCCESS,
            Ok(Outcome::Rejected) => ExitCode::from(1),
            Err(error) => {
                tell(&format!("error: {}", sentence(error.as_ref())));
                ExitCode::from(2)
            }
        }
    }
}

/// Tells something on standard error, where it does not mix with results.
fn tell(text: &str) {
    eprintln!("{}", as_options(text));
}

/// A bar on a terminal, nothing elsewhere.
fn bar(units: u64) -> ProgressBar {
    let bar = ProgressBar::new(units);
    if let Ok(style) = ProgressStyle::with_template("unit {pos} of {len} {bar:30} {elapsed} gone, {eta} left") {
        bar.set_style(style);
    }
    bar
}

/// Runs something that waits for files, stores and clusters.
fn wait<T>(task: impl Future<Output = T>) -> Result<T> {
    let mut builder = tokio::runtime::Builder::new_multi_thread();
    // Plans with many expressions recurse deeply.
    Ok(builder.enable_all().thread_stack_size(16 << 20).build()?.block_on(task))
}
