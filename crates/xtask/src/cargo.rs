//! The checks that cargo does.

use std::env;
use std::path::Path;
use std::process::Command;

use anyhow::Result;

use crate::provide;
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// Every crate of an ordinary check. What builds some of them says so with `--workspace` too, and a feature instead of a
/// package: then cargo chooses the same features of every dependency, and builds it once.
/// zerorate-lot is none: its query engine is built by the step `lot`.
pub const EVERY_CRATE: [&str; 3] = ["--workspace", "--exclude", "zerorate-lot"];

/// Every file stands as rustfmt would write it.
pub fn format(workspace: &Workspace) -> Result<Outcome> {
    run(workspace, &["fmt", "--all", "--check"])
}

/// Clippy and the compiler have nothing to say, tests, benchmarks and examples included.
pub fn lint(workspace: &Workspace) -> Result<Outcome> {
    run(workspace, &[&["clippy"], &EVERY_CRATE[..], &["--all-targets", "--", "-D", "warnings"]].concat())
}

/// The documentation of our own crates builds, and no link in it is broken.
pub fn document(workspace: &Workspace) -> Result<Outcome> {
    println!("    with RUSTDOCFLAGS='-D warnings'");
    let mut document = command(workspace);
    run_with(document.env("RUSTDOCFLAGS", "-D warnings"), &[&["doc"], &EVERY_CRATE[..], &["--no-deps"]].concat())
}

/// All tests pass.
pub fn test(workspace: &Workspace) -> Result<Outcome> {
    run(workspace, &[&["test"], &EVERY_CRATE[..]].concat())
}

/// Builds the command as its users do, for the steps that run it.
pub fn build_command(workspace: &Workspace) -> Result<Outcome> {
    run(workspace, &["build", "--release", "--package", "zerorate"])
}

/// Runs a cargo command, its output left as it is.
pub fn run(workspace: &Workspace, arguments: &[&str]) -> Result<Outcome> {
    run_with(&mut command(workspace), arguments)
}

/// Runs a cargo command in a workspace of its own, from the root; what it builds goes to `target`.
pub fn run_in(workspace: &Workspace, folder: &str, target: &Path, arguments: &[&str]) -> Result<()> {
    println!("    cargo {}, in {folder}", arguments.join(" "));
    let mut command = program();
    command.current_dir(workspace.root.join(folder)).env("CARGO_TARGET_DIR", target);
    provide::succeed(command.args(arguments))
}

/// Has what calls cargo in another workspace take what was built in this one; what it makes goes to `target`.
pub fn share<'a>(workspace: &Workspace, command: &'a mut Command, target: &Path) -> &'a mut Command {
    command.env("CARGO_BUILD_BUILD_DIR", &workspace.target).env("CARGO_TARGET_DIR", target)
}

/// Has a workspace's own crates linted as they are built: clippy is their compiler, as `cargo clippy` has it by the same variables.
pub fn lint_as_built(command: &mut Command) -> &mut Command {
    println!("    with clippy as the compiler of our crates");
    command.env("RUSTC_WORKSPACE_WRAPPER", "clippy-driver").env("CLIPPY_ARGS", "-D__CLIPPY_HACKERY__warnings")
}

/// Runs a cargo command by a call that was prepared.
pub fn run_with(command: &mut Command, arguments: &[&str]) -> Result<Outcome> {
    println!("    cargo {}", arguments.join(" "));
    provide::succeed(command.args(arguments))?;
    Ok(Outcome::Passed)
}

/// Cargo, called in the root.
pub fn command(workspace: &Workspace) -> Command {
    let mut command = program();
    command.current_dir(&workspace.root);
    command
}

/// The cargo that started us, so that its toolchain is the one that checks; without what it told us of this package: the
/// build scripts of some dependencies look at it, and all that rests on them would be built anew for whoever calls cargo
/// himself.
pub fn program() -> Command {
    let mut program = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    let of_package = |name: &str| name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_");
    for (name, _) in env::vars_os().filter(|(name, _)| name.to_str().is_some_and(of_package)) {
        program.env_remove(name);
    }
    program
}
