//! A command of the user's at the end of a run: a message to a telephone, say.

use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use crate::screen;

/// A command that takes longer is left to itself: the run has ended.
const PATIENCE: Duration = Duration::from_secs(30);
/// How often it is looked after.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Runs the command by the shell. `ZERORATE_RESULT` is a word, `ZERORATE_MESSAGE` a sentence, `ZERORATE_OUT` what was written.
/// A command that fails is told, and fails nothing else.
pub fn tell(command: &str, result: &str, message: &str, out: &Path) {
    if let Err(error) = run(command, result, message, out) {
        screen::note(&format!("`notify`: {error:#}: {command}"));
    }
}

fn run(command: &str, result: &str, message: &str, out: &Path) -> Result<()> {
    let (shell, flag) = if cfg!(windows) { ("cmd", "/C") } else { ("sh", "-c") };
    let mut child = Command::new(shell)
        .args([flag, command])
        .env("ZERORATE_RESULT", result)
        .env("ZERORATE_MESSAGE", message)
        .env("ZERORATE_OUT", out)
        .stdin(Stdio::null())
        // Standard output is for the run's own result.
        .stdout(Stdio::null())
        .spawn()
        .context("no shell could be started")?;
    let began = Instant::now();
    while began.elapsed() < PATIENCE {
        match child.try_wait()? {
            Some(status) if status.success() => return Ok(()),
            Some(status) => bail!("it ended with {status}"),
            None => thread::sleep(LOOK_EVERY),
        }
    }
    bail!("it has not ended within {} s", PATIENCE.as_secs())
}
