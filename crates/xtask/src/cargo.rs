//! The checks that cargo does.

use std::env;
use std::process::Command;

use anyhow::Result;

use crate::provide;
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// Runs a cargo command, its output left as it is.
pub fn run(workspace: &Workspace, arguments: &[&str]) -> Result<Outcome> {
    println!("    cargo {}", arguments.join(" "));
    provide::succeed(command(workspace).args(arguments))?;
    Ok(Outcome::Passed)
}

/// Builds the documentation of our own crates; a broken link is an error.
pub fn document(workspace: &Workspace) -> Result<Outcome> {
    println!("    RUSTDOCFLAGS='-D warnings' cargo doc --workspace --no-deps");
    provide::succeed(
        command(workspace)
            .args(["doc", "--workspace", "--no-deps"])
            .env("RUSTDOCFLAGS", "-D warnings"),
    )?;
    Ok(Outcome::Passed)
}

/// The cargo that started us, so that its toolchain is the one that checks.
fn command(workspace: &Workspace) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(&workspace.root);
    command
}
