//! `zerorate lot`: the command `zerorate-lot`, which is built apart.

use std::env;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, bail};
use clap::Args;

use super::Outcome;

/// Fit whole lots: thousands of units, on one machine or on a cluster (the command zerorate-lot, built apart)
#[derive(Debug, Args)]
#[command(disable_help_flag = true)]
pub struct Lot {
    /// What zerorate-lot takes; `zerorate lot --help` lists it
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENTS")]
    arguments: Vec<OsString>,
}

const NAME: &str = "zerorate-lot";

impl Lot {
    pub fn run(&self) -> Result<Outcome> {
        let Some(program) = find() else {
            bail!(
                "{NAME} is neither beside this program nor on the PATH: it is built apart, for its query engine takes some minutes: \
                 run `cargo build --release -p {NAME}` in the project's folder, or `cargo install --path crates/lot`"
            );
        };
        let status = Command::new(&program)
            .args(&self.arguments)
            .status()
            .with_context(|| format!("{}: cannot be started", program.display()))?;
        Ok(match status.code() {
            Some(0) => Outcome::Done,
            Some(1) => Outcome::Rejected,
            // What it was is told already.
            _ => Outcome::Failed,
        })
    }
}

/// The program beside this one, or else on the PATH.
fn find() -> Option<PathBuf> {
    let name = format!("{NAME}{}", env::consts::EXE_SUFFIX);
    let beside = env::current_exe().ok().and_then(|own| Some(own.parent()?.to_owned()));
    let path = env::var_os("PATH").unwrap_or_default();
    beside.into_iter().chain(env::split_paths(&path)).map(|folder| folder.join(&name)).find(|program| program.is_file())
}
