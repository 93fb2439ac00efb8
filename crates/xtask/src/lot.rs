//! What zerorate-lot is compared with.

use std::env;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::cargo;
use crate::provide;
use crate::python;
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// Rows of raw samples that are compared.
const ROWS: &str = "100000000";

/// The speed of the raw stage beside DuckDB's and a plain loop's, on the same hundred million rows.
pub fn compare(workspace: &Workspace, rows: Option<u64>) -> Result<Outcome> {
    let rows = rows.map_or_else(|| ROWS.to_owned(), |rows| rows.to_string());
    // With the examples, which have the tests' dependencies: then cargo chooses the same features.
    cargo::run(workspace, &["build", "--release", "--package", "zerorate-lot", "--bins", "--examples"])?;
    let release = workspace.target.join("release");
    let name = |program: &str| format!("{program}{}", env::consts::EXE_SUFFIX);
    let (lot, samples) = (release.join(name("zerorate-lot")), release.join("examples").join(name("raw_samples")));
    let folder = workspace.target.join("compare-lot");
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let (raw, sums) = (folder.join(format!("raw-{rows}.parquet")), folder.join("sums.parquet"));
    if !raw.is_file() {
        println!("    writing {rows} rows");
        let partial = folder.join("raw.partial");
        provide::succeed(Command::new(&samples).arg("generate").arg(&partial).arg(&rows))?;
        fs::rename(&partial, &raw)?;
    }
    let plain: Value = serde_json::from_str(&output(Command::new(&samples).args(["loop", &rows]))?)?;
    let python = python::lot_venv(workspace)?;
    let script = Path::new(python::SCRIPTS).join("compare_lot.py");
    let mut comparison = Command::new(python);
    comparison.current_dir(&workspace.root).arg(script).args([&lot, &raw, &sums]).arg(&rows).arg(plain.to_string());
    provide::succeed(&mut comparison)?;
    Ok(Outcome::Passed)
}

fn output(command: &mut Command) -> Result<String> {
    let output = command.output()?;
    ensure!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Ok(String::from_utf8(output.stdout)?)
}
