//! Remote instruments against servers that nobody here wrote.

use anyhow::Result;

use crate::cargo::{self, Lots};
use crate::python;
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// Runs the tests that need pymodbus and sinstruments: of the client, and of a whole run.
pub fn check(workspace: &Workspace, lots: Lots) -> Result<Outcome> {
    if !cfg!(unix) {
        return Ok(Outcome::Skipped("its lines are pseudo-terminals, which this system has not".into()));
    }
    let python = python::instruments_venv(workspace)?;
    for (test, filter) in [("servers", ""), ("device", "night")] {
        cargo::test_some(workspace, lots, &["--test", test, "--", "--ignored", filter], |tests| {
            tests.env("ZERORATE_INSTRUMENTS_PYTHON", &python);
        })?;
    }
    Ok(Outcome::Passed)
}
