//! The subcommands, one file each, and how they end.

mod apply;
mod calibrate;
mod chamber;
mod characterise;
mod completions;
mod device;
mod export;
mod fit;
mod info;
mod live;
mod lot;
mod report;
mod setup;
mod study;
mod typed;
mod units;
mod verify;
mod virtual_board;

use std::ffi::OsString;
use std::io;

use anyhow::Result;
use clap::{Parser, Subcommand};
use zerorate_words::sentence;

use crate::notify::Notice;
use crate::screen;
use typed::Typed;

/// Takes the temperature drift out of the zero-rate output of MEMS gyroscopes: tests on the bench, fits the drift,
/// compensates, and proves it with a second run.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100, arg_required_else_help = true, after_help = EXAMPLES)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  zerorate calibrate                 the whole experiment on the simulated bench
  zerorate fit log.csv --out calibration.json --report report.html
  zerorate apply calibration.json log.csv --out corrected.csv
  zerorate export calibration.json --format px4 --out vehicle.params
  zerorate verify second.csv --with calibration.json --max-rms 1mrad/s
  zerorate help fit                  what fit does, its options, more examples

Exit codes: 0 done; 1 the unit or the log was rejected, with reasons; 2 error.";

/// The order is the help's: what most people come for stands first.
#[derive(Debug, Subcommand)]
enum Command {
    Calibrate(calibrate::Calibrate),
    Fit(fit::Fit),
    Apply(apply::Apply),
    Export(export::Export),
    Verify(verify::Verify),
    Characterise(characterise::Characterise),
    Report(report::Report),
    Info(info::Info),
    Live(live::LookOn),
    Units(units::Units),
    Study(study::Study),
    Lot(lot::Lot),
    Device(device::Device),
    Chamber(chamber::Chamber),
    Setup(setup::Setup),
    VirtualBoard(virtual_board::Serve),
    Completions(completions::Completions),
}

/// How a command ended that did what it was asked to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Exit code 0.
    Done,
    /// The unit or the log was rejected, and the reasons were given: exit code 1.
    Rejected,
    /// Something failed, and it was told: exit code 2.
    Failed,
}

/// The exit code of an error; clap's own for wrong usage is the same.
const ERROR: u8 = 2;

/// Runs the command that was typed, the program's name first, and gives its exit code.
#[must_use]
pub fn run(typed: Vec<OsString>) -> u8 {
    let typed = Typed(typed);
    match Cli::try_parse_from(&typed.0) {
        Ok(cli) => cli.run(&typed),
        Err(usage) => {
            if usage.use_stderr() && typed.wants_json() {
                screen::json_error(&usage_sentence(&usage));
            }
            // Whoever cannot be told reads the exit code.
            let _ = usage.print();
            if usage.use_stderr() { ERROR } else { 0 }
        }
    }
}

/// What is wrong with the arguments, in a line; how they are to be given is for people.
fn usage_sentence(usage: &clap::Error) -> String {
    let text = usage.render().to_string();
    let told =
        text.split("\n\n").take_while(|part| !["Usage:", "For more"].iter().any(|start| part.starts_with(start)));
    let words = told.flat_map(str::split_whitespace).collect::<Vec<_>>().join(" ");
    words.trim_start_matches("error: ").to_owned()
}

impl Cli {
    /// Runs the command and gives the exit code.
    fn run(&self, typed: &Typed) -> u8 {
        let result = match &self.command {
            Command::Calibrate(calibrate) => return end(calibrate.run(), typed),
            Command::Chamber(chamber) => return end(chamber.run(), typed),
            Command::Fit(fit) => fit.run(typed),
            Command::Apply(apply) => apply.run(),
            Command::Export(export) => export.run(),
            Command::Verify(verify) => verify.run(),
            Command::Characterise(characterise) => characterise.run(),
            Command::Report(report) => report.run(),
            Command::Info(info) => info.run(),
            Command::Live(live) => live.run(),
            Command::Units(units) => units.run(),
            Command::Study(study) => study.run(),
            Command::Lot(lot) => lot.run(),
            Command::Setup(setup) => setup.run(),
            Command::Device(device) => device.run(),
            Command::VirtualBoard(board) => board.run(),
            Command::Completions(completions) => completions.run(),
        };
        exit_code(&result, typed)
    }
}

/// The exit code of a command that tells others of its end: whoever stands here hears of it first, for a notification may hang.
fn end((result, notice): (Result<Outcome>, Option<Notice>), typed: &Typed) -> u8 {
    let code = exit_code(&result, typed);
    if let Some(notice) = notice {
        notice.tell();
    }
    code
}

fn exit_code(result: &Result<Outcome>, typed: &Typed) -> u8 {
    match result {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::Rejected) => 1,
        Ok(Outcome::Failed) => ERROR,
        // Whoever closed the pipe, as `| head` does, has all that they wanted.
        Err(error) if is_closed_pipe(error) => 0,
        Err(error) => {
            screen::error(error);
            if typed.wants_json() {
                screen::json_error(&sentence(error.as_ref()));
            }
            ERROR
        }
    }
}

/// What was said to somebody who has gone: whoever closed the pipe wants no more of it.
pub(crate) fn unless_gone(said: Result<()>) -> Result<()> {
    said.or_else(|error| if is_closed_pipe(&error) { Ok(()) } else { Err(error) })
}

fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}
