//! `cargo xtask chip`: the image for the STM32F405, as it would be flashed, run in an emulator against the simulated bench.

use std::path::PathBuf;

use anyhow::Result;

use crate::cargo;
use crate::firmware;
use crate::gateware;
use crate::provide;
use crate::steps::{Outcome, Step};
use crate::workspace::Workspace;

/// The emulator's workspace, from the root.
const FOLDER: &str = "chip";

/// The chore's steps.
pub fn steps(workspace: &Workspace) -> Vec<Step<'_>> {
    vec![
        Step::new("image", "mend the build", || image(workspace).map(|_| Outcome::Passed)),
        Step::new("cases", "see chip/README.md", || cases(workspace)),
    ]
}

/// All of it as one, with what else is asked of a crate.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    image(workspace)?;
    tools()?;
    run(workspace, &["fmt", "--check"])?;
    run(workspace, &["test", "--locked"])?;
    cases(workspace)
}

/// Builds the very image, by the route of `cargo xtask firmware`.
fn image(workspace: &Workspace) -> Result<PathBuf> {
    firmware::build_package(workspace, firmware::STM32F405)?;
    Ok(firmware::built(workspace, firmware::STM32F405))
}

/// What Unicorn is built with: cmake, and clang's library to read its header.
fn tools() -> Result<()> {
    if ["clang", "cmake"].iter().any(|program| provide::on_path(&[program]).is_none()) {
        provide::install("what Unicorn is built with", &["clang", "libclang-dev", "cmake", "g++", "make"])?;
    }
    Ok(())
}

/// Runs every case; each prints its line.
fn cases(workspace: &Workspace) -> Result<Outcome> {
    tools()?;
    let image = firmware::built(workspace, firmware::STM32F405).display().to_string();
    run(workspace, &["run", "--quiet", "--locked", "--", &image])?;
    Ok(Outcome::Passed)
}

/// A cargo command in the emulator's workspace. What it stands on is built where the gateware's bench is, which stands on the same.
fn run(workspace: &Workspace, arguments: &[&str]) -> Result<()> {
    cargo::run_in(workspace, FOLDER, &gateware::out(workspace)?, arguments)
}
