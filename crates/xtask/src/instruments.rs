//! Remote instruments against servers that nobody here wrote.

use anyhow::Result;

use crate::cargo;
use crate::provide;
use crate::python;
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// Runs the tests of `zerorate-instruments` that need pymodbus and sinstruments.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    if !cfg!(unix) {
        return Ok(Outcome::Skipped("its lines are pseudo-terminals, which this system has not".into()));
    }
    let python = python::instruments_venv(workspace)?;
    let mut tests = cargo::program();
    tests.current_dir(&workspace.root).args(["test", "--quiet", "--package", "zerorate-instruments"]);
    tests.args(["--test", "servers", "--", "--ignored"]).env("ZERORATE_INSTRUMENTS_PYTHON", python);
    provide::succeed(&mut tests)?;
    Ok(Outcome::Passed)
}
