//! The command `zerorate`.

mod command;
mod interrupt;
mod log_arguments;
mod output;
mod plant;
mod progress;
mod screen;

use std::process::ExitCode;

fn main() -> ExitCode {
    command::run()
}
