//! The crates that are built for other targets than this machine: the board's side without an operating system, and what
//! a browser's page will use.

use std::path::PathBuf;

use anyhow::Result;

use crate::steps::Outcome;
use crate::toolchain::Toolchain;
use crate::workspace::Workspace;

/// The board's side.
const BOARD_SIDE: [&str; 4] = ["zerorate-core", "max5494", "zerorate-device", "zerorate-lockstep"];

/// What needs no files: all that lies between a log's bytes and a report, and the page that rests on it.
const BROWSER_SIDE: [&str; 12] = [
    "zerorate-core",
    "imu-logs",
    "zerorate-fit",
    "zerorate-source",
    "zerorate-recording",
    "zerorate-cal",
    "zerorate-apply",
    "zerorate-board-run",
    "zerorate-characterise",
    "zerorate-export",
    "zerorate-report",
    "zerorate-web",
];

/// The board's side builds with core alone.
pub fn no_std(workspace: &Workspace) -> Result<Outcome> {
    let packages = BOARD_SIDE.iter().flat_map(|package| ["--package", package]);
    let arguments: Vec<&str> = ["check", "--locked"].into_iter().chain(packages).collect();
    Toolchain::of_board()?.run(&workspace.root, &workspace.target.join("targets"), &arguments)?;
    Ok(Outcome::Passed)
}

/// The browser's side builds for WebAssembly.
pub fn wasm(workspace: &Workspace) -> Result<Outcome> {
    page_program(workspace).map(|_| Outcome::Passed)
}

/// Builds the browser's side, as the page carries it; says where the page's program is.
pub fn page_program(workspace: &Workspace) -> Result<PathBuf> {
    let built = workspace.target.join("targets");
    let packages = BROWSER_SIDE.iter().flat_map(|package| ["--package", package]);
    let arguments: Vec<&str> =
        ["build", "--locked", "--profile", "page", "--lib"].into_iter().chain(packages).collect();
    Toolchain::of_browser()?.run(&workspace.root, &built, &arguments)?;
    Ok(built.join("wasm32-unknown-unknown/page/zerorate_web.wasm"))
}
