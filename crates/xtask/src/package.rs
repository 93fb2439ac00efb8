//! The Python package: its wheel is built, installed where nothing else of ours is, and held against the built command.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::cargo;
use crate::provide;
use crate::python;
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// The package's workspace, from the root.
const FOLDER: &str = "crates/python";

/// What is asked of every crate, then the package's own tests on its wheel. Those compare with the built command.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    let Some(tests) = python::package_venv(workspace)? else {
        return Ok(Outcome::Skipped("python3 on the PATH is older than 3.11, which the package needs".into()));
    };
    let command = workspace.zerorate()?;
    run(workspace, &["fmt", "--check"])?;
    let wheel = wheel(workspace)?;
    let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--force-reinstall", "--no-deps"];
    provide::succeed(Command::new(&tests).args(pip).arg(wheel))?;
    provide::succeed(Command::new(&tests).args(["-m", "pip", "check", "--disable-pip-version-check"]))?;
    let mut pytest = Command::new(&tests);
    pytest.current_dir(workspace.root.join(FOLDER).join("tests")).env("ZERORATE_COMMAND", command.canonicalize()?);
    if let Some(data) = workspace.data() {
        pytest.env("ZERORATE_DATA", data.canonicalize()?);
    }
    provide::succeed(pytest.args(["-m", "pytest", "--quiet", "-p", "no:cacheprovider", "."]))?;
    Ok(Outcome::Passed)
}

/// Builds the wheel, as `pip install .` does, and lints the package meanwhile: a check of its own would go through all that it
/// stands on once more.
fn wheel(workspace: &Workspace) -> Result<PathBuf> {
    let wheels = target(workspace).join("wheels");
    // Of an older version none may be left.
    if wheels.is_dir() {
        fs::remove_dir_all(&wheels).with_context(|| wheels.display().to_string())?;
    }
    let mut maturin = Command::new(python::maturin(workspace)?);
    cargo::share(workspace, &mut maturin, &target(workspace)).current_dir(workspace.root.join(FOLDER));
    cargo::lint_as_built(&mut maturin);
    provide::succeed(maturin.args(["build", "--quiet", "--release", "--locked", "--out"]).arg(&wheels))?;
    let built: Vec<_> = fs::read_dir(&wheels)?.collect::<std::io::Result<_>>()?;
    ensure!(built.len() == 1, "{}: {} wheels, not one", wheels.display(), built.len());
    Ok(built[0].path())
}

/// A cargo command in the package's workspace.
fn run(workspace: &Workspace, arguments: &[&str]) -> Result<()> {
    println!("    cargo {}, in {FOLDER}", arguments.join(" "));
    let mut command = cargo::program();
    cargo::share(workspace, &mut command, &target(workspace)).current_dir(workspace.root.join(FOLDER));
    provide::succeed(command.args(arguments))
}

/// Where the library and the wheels are put. What they stand on is built where the command's is, and once where it is the same.
fn target(workspace: &Workspace) -> PathBuf {
    workspace.target.join("python")
}
