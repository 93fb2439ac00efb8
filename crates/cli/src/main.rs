//! The command `zerorate`.

mod command;
mod interrupt;
mod log_arguments;
mod output;
mod plant;
mod progress;
mod screen;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    command::Cli::parse().run()
}
