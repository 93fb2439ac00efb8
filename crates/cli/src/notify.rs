//! A command of the user's at the end of a run: a message to a telephone, say.

use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};

use crate::screen;

/// A command that takes longer is left to itself: the run has ended.
const PATIENCE: Duration = Duration::from_secs(30);
/// One that takes longer than this is told of: somebody may wait for the run's end.
const SOON: Duration = Duration::from_secs(2);
/// How often it is looked after.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// What is told of an end, and by which command.
#[derive(Debug)]
pub struct Notice {
    /// The command.
    pub command: String,
    /// `ZERORATE_RESULT`: a word.
    pub result: &'static str,
    /// `ZERORATE_MESSAGE`: a sentence.
    pub message: String,
    /// `ZERORATE_OUT`: what was written.
    pub out: PathBuf,
}

impl Notice {
    /// Runs the command by the shell. One that fails is told, and fails nothing else.
    pub fn tell(&self) {
        if let Err(error) = self.run() {
            screen::note(&format!("`notify`: {error:#}: {}", self.command));
        }
    }

    fn run(&self) -> Result<()> {
        let (shell, flag) = if cfg!(windows) { ("cmd", "/C") } else { ("sh", "-c") };
        let mut child = Command::new(shell)
            .args([flag, &self.command])
            .env("ZERORATE_RESULT", self.result)
            .env("ZERORATE_MESSAGE", &self.message)
            .env("ZERORATE_OUT", &self.out)
            .stdin(Stdio::null())
            // Standard output is for the run's own result.
            .stdout(Stdio::null())
            .spawn()
            .context("no shell could be started")?;
        let (began, mut was_told) = (Instant::now(), false);
        while began.elapsed() < PATIENCE {
            match child.try_wait()? {
                Some(status) if status.success() => return Ok(()),
                Some(status) => bail!("it ended with {status}"),
                None => thread::sleep(LOOK_EVERY),
            }
            if began.elapsed() > SOON && !std::mem::replace(&mut was_told, true) {
                screen::note(&format!(
                    "all else is over, and the command of `notify` is waited for, {} s at most: {}",
                    PATIENCE.as_secs(),
                    self.command
                ));
            }
        }
        bail!("it has not ended within {} s, and is left to itself", PATIENCE.as_secs())
    }
}
