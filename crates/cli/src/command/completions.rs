//! `zerorate completions`.

use anyhow::{Context, Result};
use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::{Cli, Outcome};
use crate::screen;

/// Print what a shell offers after `zerorate` when Tab is pressed
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Completions {
    /// The shell
    shell: Shell,
}

const EXAMPLES: &str = "\
Examples:
  zerorate completions bash > ~/.local/share/bash-completion/completions/zerorate
  zerorate completions zsh > \"${fpath[1]}/_zerorate\"
  zerorate completions fish > ~/.config/fish/completions/zerorate.fish";

impl Completions {
    pub fn run(&self) -> Result<Outcome> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "zerorate", &mut script);
        screen::print(&String::from_utf8(script).context("the completions are not text")?)?;
        Ok(Outcome::Done)
    }
}
