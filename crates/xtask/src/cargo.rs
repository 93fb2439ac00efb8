//! The checks that cargo does.

use std::env;
use std::path::Path;
use std::process::Command;

use anyhow::Result;

use crate::provide;
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// Every crate but zerorate-lot, whose query engine takes longer to build than all others together.
const BUT_LOTS: [&str; 3] = ["--workspace", "--exclude", "zerorate-lot"];

/// Every file stands as rustfmt would write it.
pub fn format(workspace: &Workspace) -> Result<Outcome> {
    run(workspace, &["fmt", "--all", "--check"])
}

/// The documentation of our own crates builds, and no link in it is broken. That of zerorate-lot is left out: cargo would go through
/// its query engine once more.
pub fn document(workspace: &Workspace) -> Result<Outcome> {
    println!("    with RUSTDOCFLAGS='-D warnings'");
    let mut document = command(workspace);
    run_with(document.env("RUSTDOCFLAGS", "-D warnings"), &[&["doc"], &BUT_LOTS[..], &["--no-deps"]].concat())
}

/// Whether zerorate-lot is among the crates that are tested.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Lots {
    /// It is.
    Tested,
    /// It is not.
    LeftOut,
}

impl Lots {
    /// The crates that are tested, as cargo is told.
    pub const fn crates(self) -> &'static [&'static str] {
        match self {
            Self::Tested => &["--workspace"],
            Self::LeftOut => &BUT_LOTS,
        }
    }
}

/// Some tests; `prepare` is given what they are run by. All tests are chosen from the same crates, by what they are called and not by
/// their packages: then cargo chooses the same features of every dependency, and builds it once.
pub fn test_some(workspace: &Workspace, lots: Lots, some: &[&str], prepare: impl Fn(&mut Command)) -> Result<Outcome> {
    let mut test = command(workspace);
    prepare(&mut test);
    run_with(lint_as_built(&mut test), &[&["test"], lots.crates(), some].concat())
}

/// Builds the command as its users do, for the steps that run it.
pub fn build_command(workspace: &Workspace) -> Result<Outcome> {
    run(workspace, &["build", "--release", "--package", "zerorate"])
}

/// Runs a cargo command, its output left as it is.
pub fn run(workspace: &Workspace, arguments: &[&str]) -> Result<Outcome> {
    run_with(&mut command(workspace), arguments)
}

/// Runs a cargo command in a workspace of its own, from the root, and lints its crates; what it builds goes to `target`.
pub fn run_in(workspace: &Workspace, folder: &str, target: &Path, arguments: &[&str]) -> Result<()> {
    println!("    cargo {}, in {folder}", arguments.join(" "));
    let mut command = program();
    command.current_dir(workspace.root.join(folder)).env("CARGO_TARGET_DIR", target);
    if arguments.first() != Some(&"fmt") {
        lint_as_built(&mut command);
    }
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
