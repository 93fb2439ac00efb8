//! The checks that cargo does.

use std::env;
use std::process::Command;

use anyhow::Result;

use crate::provide;
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// Every file stands as rustfmt would write it.
pub fn format(workspace: &Workspace) -> Result<Outcome> {
    run(workspace, &["fmt", "--all", "--check"])
}

/// Clippy and the compiler have nothing to say, tests, benchmarks and examples included.
pub fn lint(workspace: &Workspace) -> Result<Outcome> {
    run(workspace, &["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"])
}

/// The documentation of our own crates builds, and no link in it is broken.
pub fn document(workspace: &Workspace) -> Result<Outcome> {
    println!("    with RUSTDOCFLAGS='-D warnings'");
    let arguments = ["doc", "--workspace", "--no-deps"];
    run_with(command(workspace).env("RUSTDOCFLAGS", "-D warnings"), &arguments)
}

/// All tests pass.
pub fn test(workspace: &Workspace) -> Result<Outcome> {
    run(workspace, &["test", "--workspace"])
}

/// Builds the command as its users do, for the steps that run it.
pub fn build_command(workspace: &Workspace) -> Result<Outcome> {
    run(workspace, &["build", "--release", "--package", "zerorate"])
}

/// Runs a cargo command, its output left as it is.
pub fn run(workspace: &Workspace, arguments: &[&str]) -> Result<Outcome> {
    run_with(&mut command(workspace), arguments)
}

fn run_with(command: &mut Command, arguments: &[&str]) -> Result<Outcome> {
    println!("    cargo {}", arguments.join(" "));
    provide::succeed(command.args(arguments))?;
    Ok(Outcome::Passed)
}

/// The cargo that started us, so that its toolchain is the one that checks.
fn command(workspace: &Workspace) -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(&workspace.root);
    command
}
