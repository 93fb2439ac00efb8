//! The crates that are built for other targets than this machine: the board's side without an operating system, and what
//! a browser's page will use.

use anyhow::Result;

use crate::steps::Outcome;
use crate::toolchain::Toolchain;
use crate::workspace::Workspace;

/// The board's side.
const BOARD_SIDE: [&str; 4] = ["zerorate-core", "max5494", "zerorate-device", "zerorate-lockstep"];

/// What needs no files: all that lies between a log's bytes and a report.
const BROWSER_SIDE: [&str; 9] = [
    "zerorate-core",
    "imu-logs",
    "zerorate-fit",
    "zerorate-source",
    "zerorate-cal",
    "zerorate-apply",
    "zerorate-characterise",
    "zerorate-export",
    "zerorate-report",
];

/// The board's side builds with core alone.
pub fn no_std(workspace: &Workspace) -> Result<Outcome> {
    check(workspace, &Toolchain::of_board()?, &BOARD_SIDE)
}

/// The browser's side builds for WebAssembly.
pub fn wasm(workspace: &Workspace) -> Result<Outcome> {
    check(workspace, &Toolchain::of_browser()?, &BROWSER_SIDE)
}

fn check(workspace: &Workspace, toolchain: &Toolchain, packages: &[&str]) -> Result<Outcome> {
    let mut arguments = vec!["check", "--locked"];
    arguments.extend(packages.iter().flat_map(|package| ["--package", package]));
    toolchain.run(&workspace.root, &workspace.target.join("targets"), &arguments)?;
    Ok(Outcome::Passed)
}
