//! The board's capture: SKiDL makes the netlist that a layout starts from, after its electrical rules check, and a script
//! holds that against the netlist that ngspice simulates.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use anyhow::{Context, Result, bail, ensure};

use super::spice::CIRCUIT;
use crate::python;
use crate::workspace::Workspace;

/// Two parts that a spoilt netlist has in each other's place: the one value in which the axes differ.
const EXCHANGED: [&str; 2] = ["\"R104\"", "\"R204\""];

/// Makes it, compares it, and sees that the comparison notices an exchange.
pub fn check(workspace: &Workspace) -> Result<()> {
    let python = python::circuit_venv(workspace)?;
    // SKiDL leaves its logs where it runs.
    let folder = workspace.target.join("circuit");
    let scripts = workspace.root.join(CIRCUIT);
    let run = |script: &str, argument: &Path| -> Result<Output> {
        let mut command = Command::new(&python);
        // It looks for a KiCad that is not needed, and says so.
        command.current_dir(&folder).args(["-W", "ignore"]).arg(scripts.join(script)).arg(argument);
        command.output().with_context(|| format!("{script} could not be started"))
    };
    let said = |script: &str, output: &Output| -> Result<()> {
        let last = |text: &[u8]| String::from_utf8_lossy(text).lines().last().unwrap_or_default().to_owned();
        if !output.status.success() {
            bail!("{script}: {}", String::from_utf8_lossy(&output.stderr).trim());
        }
        println!("    {script}: {}", last(&output.stdout));
        Ok(())
    };
    println!();
    said("capture.py", &run("capture.py", &folder)?)?;
    let netlist = folder.join("zero-adjust.net");
    said("compare_capture.py", &run("compare_capture.py", &netlist)?)?;

    let text = fs::read_to_string(&netlist).with_context(|| netlist.display().to_string())?;
    let [first, second] = EXCHANGED;
    let exchanged = text.replace(first, "\"\"").replace(second, first).replace("\"\"", second);
    ensure!(exchanged != text, "the capture has no {first}");
    let spoilt = folder.join("exchanged.net");
    fs::write(&spoilt, exchanged)?;
    ensure!(!run("compare_capture.py", &spoilt)?.status.success(), "{first} and {second} exchanged are not noticed");
    Ok(())
}
