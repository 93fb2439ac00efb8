//! The command `zerorate`.

use std::process::ExitCode;

fn main() -> ExitCode {
    zerorate::run(std::env::args_os().collect()).into()
}
