//! `zerorate device`.

mod deploy;
mod faults;
mod first_time;
mod info;
mod mode;
mod monitor;
mod read;
mod self_test;
mod stream;
mod tap;

use anyhow::{Context, Result};
use clap::{Args, Subcommand, ValueEnum};
use serde::Serialize;
use zerorate_bench::board::{Axis, Board};
use zerorate_bench::choice::DeviceChoice;
use zerorate_bench::client::ClientError;
use zerorate_words::sentence;

use super::Outcome;
use crate::screen;

/// Talk to a board: who it is, its groups as they come, its modes and taps, its calibration, its faults
///
/// A line that goes dead is an error within five seconds. What is not answered is sent again; what was lost is named.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, subcommand_required = true, arg_required_else_help = true)]
pub struct Device {
    /// The board: serial:PATH (115200 baud; serial:PATH@BAUD for another rate), tcp:HOST:PORT, emulated, or native (a
    /// simulated one, new each time). Of `stream` its second line: serial:PATH (460800 baud) or tcp:HOST:PORT
    #[arg(long, value_name = "DEVICE", global = true)]
    port: Option<DeviceChoice>,

    /// Print JSON on standard output, and nothing else there
    #[arg(long, global = true)]
    json: bool,

    #[command(subcommand)]
    verb: Verb,
}

const EXAMPLES: &str = "\
Examples:
  zerorate device --port serial:/dev/ttyUSB0 info
  zerorate device --port serial:/dev/ttyUSB0 monitor
  zerorate device --port serial:/dev/ttyUSB0 deploy calibration/calibration.json
  zerorate device --port tcp:bench-3:5494 mode both hybrid
  zerorate device --port tcp:bench-3:5494 self-test
  zerorate virtual-board --on tcp:127.0.0.1:5494     a board to try these on

Exit codes: 0 done; 1 the board refused, with its reason; 2 error.";

#[derive(Debug, Subcommand)]
enum Verb {
    Info(info::Info),
    Monitor(monitor::Monitor),
    Stream(stream::Stream),
    Mode(mode::Mode),
    Tap(tap::Tap),
    Deploy(deploy::Deploy),
    Read(read::Read),
    Faults(faults::Faults),
    FirstTime(first_time::FirstTime),
    SelfTest(self_test::SelfTest),
}

impl Device {
    pub fn run(&self) -> Result<Outcome> {
        let result = match &self.verb {
            Verb::Info(info) => info.run(self),
            Verb::Monitor(monitor) => monitor.run(self),
            Verb::Stream(stream) => stream.run(self),
            Verb::Mode(mode) => mode.run(self),
            Verb::Tap(tap) => tap.run(self),
            Verb::Deploy(deploy) => deploy.run(self),
            Verb::Read(read) => read.run(self),
            Verb::Faults(faults) => faults.run(self),
            Verb::FirstTime(first_time) => first_time.run(self),
            Verb::SelfTest(self_test) => self_test.run(self),
        };
        match result {
            Err(error) => match error.downcast_ref::<ClientError>() {
                Some(ClientError::Refused(_)) => self.refused(&error),
                _ => Err(error),
            },
            done => done,
        }
    }

    /// Opens the line and shakes hands.
    fn open(&self) -> Result<Board> {
        let port =
            self.port.as_ref().context("say which board: --port serial:PATH, tcp:HOST:PORT, emulated or native")?;
        Ok(Board::open(port)?)
    }

    /// Says that something was done.
    fn done(&self, told: &impl Serialize, text: &str) -> Result<Outcome> {
        if self.json {
            print_json(told)?;
        } else {
            screen::print(&format!("{text}\n"))?;
        }
        Ok(Outcome::Done)
    }

    /// The board will not: its reason is told, on standard output where a program reads it.
    fn refused(&self, why: &anyhow::Error) -> Result<Outcome> {
        #[derive(Serialize)]
        struct Refused {
            refused: String,
        }
        if self.json {
            print_json(&Refused { refused: sentence(why.as_ref()) })?;
        } else {
            screen::error(why);
        }
        Ok(Outcome::Rejected)
    }
}

/// Prints one of these commands' forms, with its version.
fn print_json(told: &impl Serialize) -> Result<()> {
    #[derive(Serialize)]
    struct Versioned<'a, T> {
        schema: u32,
        #[serde(flatten)]
        told: &'a T,
    }
    screen::print_json(&Versioned { schema: 1, told })
}

/// Which axes a command is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Axes {
    X,
    Y,
    Both,
}

impl Axes {
    const fn all(self) -> &'static [Axis] {
        match self {
            Self::X => &[Axis::X],
            Self::Y => &[Axis::Y],
            Self::Both => &Axis::BOTH,
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::X => "axis X",
            Self::Y => "axis Y",
            Self::Both => "both axes",
        }
    }
}
