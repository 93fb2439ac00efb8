//! Remote instruments against servers that nobody here wrote.

use anyhow::Result;

use crate::cargo;
use crate::provide;
use crate::python;
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// Runs the tests that need pymodbus and sinstruments: of the client, and of a whole run.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    if !cfg!(unix) {
        return Ok(Outcome::Skipped("its lines are pseudo-terminals, which this system has not".into()));
    }
    let python = python::instruments_venv(workspace)?;
    for (package, test, filter) in [("zerorate-instruments", "servers", ""), ("zerorate", "device", "night")] {
        let mut tests = cargo::program();
        tests.current_dir(&workspace.root).args(["test", "--quiet", "--package", package, "--test", test]);
        tests.args(["--", "--ignored", filter]).env("ZERORATE_INSTRUMENTS_PYTHON", &python);
        provide::succeed(&mut tests)?;
    }
    Ok(Outcome::Passed)
}
