//! Programs from outside: found, installed where that is allowed, or named so that a person can.

use std::env;
use std::fmt;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail, ensure};

/// Runs a command with its output left as it is; an error unless it succeeds.
pub fn succeed(command: &mut Command) -> Result<()> {
    let program = command.get_program().to_string_lossy().into_owned();
    let status = command.status().with_context(|| format!("{program} could not be started"))?;
    ensure!(status.success(), "{} ended with {status}", name_of(&program));
    Ok(())
}

/// Whether a command runs and succeeds; its output is dropped.
pub fn works(command: &mut Command) -> bool {
    command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

/// The first of several program names that is on the PATH.
pub fn on_path(names: &[&str]) -> Option<PathBuf> {
    let folders = env::var_os("PATH")?;
    let folders: Vec<PathBuf> = env::split_paths(&folders).collect();
    names.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name))).find(|path| path.is_file())
}

/// Whether we run as the superuser, who may install and for whom browsers refuse their sandbox.
pub fn is_root() -> bool {
    Command::new("id").arg("-u").output().is_ok_and(|output| output.stdout.trim_ascii() == b"0")
}

/// A program that is not there and that we may not install. Its message says what to do.
#[derive(Debug)]
pub struct Missing(String);

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Missing {}

/// Installs Debian packages as root, or says which are missing.
pub fn install(what_for: &str, packages: &[&str]) -> Result<()> {
    let listed = packages.join(" ");
    if on_path(&["apt-get"]).is_none() {
        bail!(Missing(format!("{what_for} is missing; on Debian it is in: {listed}")));
    }
    if !is_root() {
        bail!(Missing(format!("{what_for} is missing; install it with: sudo apt-get install {listed}")));
    }
    // Steps may run beside each other, and apt-get does not wait for another.
    let lock = File::create(env::temp_dir().join("xtask-install.lock"))?;
    lock.lock()?;
    println!("    installing {what_for}: {listed}");
    let apt = || {
        let mut apt = Command::new("apt-get");
        apt.arg("-qq").env("DEBIAN_FRONTEND", "noninteractive").stdin(Stdio::null()).stdout(Stdio::null());
        apt
    };
    succeed(apt().arg("update"))?;
    succeed(apt().args(["install", "-y", "--no-install-recommends"]).args(packages))
}

fn name_of(program: &str) -> String {
    Path::new(program).file_name().map_or_else(|| program.to_owned(), |name| name.to_string_lossy().into_owned())
}
