//! Comparisons with Python's numerical tools, run in a venv of our own under target/.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};

use crate::provide;
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// Where the scripts and the versions they need are kept.
pub const SCRIPTS: &str = "crates/xtask/python";

/// Holds `zerorate fit --plain` against numpy.polyfit, on made data and on a real recording where there is one.
pub fn compare_fit(workspace: &Workspace) -> Result<Outcome> {
    let mut script = script(workspace, "compare_fit.py")?;
    match workspace.recording() {
        Some(recording) => {
            script.arg(recording);
        }
        None => println!("    without the real recording: no ../shared/data, and ZERORATE_DATA names no other folder"),
    }
    provide::succeed(&mut script)?;
    Ok(Outcome::Passed)
}

/// Recomputes what `calibrate`, `fit` and `verify` print, from the recordings beside it.
pub fn printed_numbers(workspace: &Workspace) -> Result<Outcome> {
    provide::succeed(&mut script(workspace, "printed_numbers.py")?)?;
    Ok(Outcome::Passed)
}

/// Damages a real recording in six ways and checks what `zerorate fit` says of each.
pub fn damaged_recordings(workspace: &Workspace) -> Result<Outcome> {
    let Some(data) = workspace.data() else {
        return Ok(Outcome::Skipped("no ../shared/data, and ZERORATE_DATA names no other folder".into()));
    };
    let recording = data.join("imu-chamber-cycle/imu_raw_data.tsv");
    let encoder = data.join("../tools/encode_flight_logs.py");
    if let Some(missing) = [&recording, &encoder].into_iter().find(|path| !path.is_file()) {
        return Ok(Outcome::Skipped(format!("{} is missing", missing.display())));
    }
    provide::succeed(script(workspace, "damaged_recordings.py")?.args([encoder, recording]))?;
    Ok(Outcome::Passed)
}

/// The package that carries ArduPilot's script.
const CONFIGURATOR: &str = "ardupilot_methodic_configurator==5.0.1";

/// Sets `zerorate fit` beside ArduPilot's script, on the same files, in one run; the script is stopped after the deadline.
pub fn compare_tools(workspace: &Workspace, deadline_s: u32, rates_hz: &[f64]) -> Result<Outcome> {
    let Some(data) = workspace.data() else {
        return Ok(Outcome::Skipped("no ../shared/data, and ZERORATE_DATA names no other folder".into()));
    };
    let recording = data.join("imu-chamber-cycle/imu_raw_data.tsv");
    let encoder = data.join("../tools/encode_flight_logs.py");
    let zerorate = workspace.zerorate()?;
    let python = venv_of(workspace, "venv-compare", "requirements-compare.txt", Some(CONFIGURATOR))?;
    let mut script = Command::new(python);
    script.current_dir(&workspace.root).arg(Path::new(SCRIPTS).join("compare_tools.py"));
    script.args([zerorate, encoder, recording, workspace.target.join("compare")]).arg(deadline_s.to_string());
    script.args(rates_hz.iter().map(ToString::to_string));
    provide::succeed(&mut script)?;
    Ok(Outcome::Passed)
}

/// A tool that stands beside the recordings and is no part of the project.
pub fn tool(workspace: &Workspace, name: &str) -> Result<PathBuf> {
    let tool = workspace.data().map(|data| data.join("../tools").join(name));
    tool.filter(|tool| tool.is_file())
        .with_context(|| format!("{name} is missing: it is looked for in ../tools from the folder of the recordings"))
}

/// A recording as logs of ULog, DataFlash and CSV, named by a prefix, by the tool that stands beside the recordings.
pub fn encoded(workspace: &Workspace, recording: &Path, prefix: &Path, options: &[&str]) -> Result<[PathBuf; 3]> {
    let encoder = tool(workspace, "encode_flight_logs.py")?;
    let options: Vec<&Path> = options.iter().map(Path::new).collect();
    run(workspace, &[&[encoder.as_path(), recording, prefix], &options[..]].concat())?;
    Ok(["ulg", "bin", "csv"].map(|form| prefix.with_extension(form)))
}

/// Runs a script with the pinned packages.
pub fn run(workspace: &Workspace, arguments: &[&Path]) -> Result<()> {
    // What it prints is for whoever calls it by hand.
    provide::succeed(Command::new(venv(workspace)?).args(arguments).stdout(Stdio::null()))
}

/// What a script with the pinned packages prints.
pub fn printed(workspace: &Workspace, arguments: &[&Path]) -> Result<String> {
    let output = Command::new(venv(workspace)?).args(arguments).stderr(Stdio::inherit()).output()?;
    ensure!(output.status.success(), "{} ended with {}", arguments[0].display(), output.status);
    Ok(String::from_utf8(output.stdout)?)
}

/// The call of a script with the built command as its first argument.
fn script(workspace: &Workspace, name: &str) -> Result<Command> {
    let zerorate = workspace.zerorate()?;
    let mut command = Command::new(venv(workspace)?);
    command.current_dir(&workspace.root).arg(Path::new(SCRIPTS).join(name)).arg(zerorate);
    Ok(command)
}

/// The Python of the venv with the pinned packages, made on the first call.
fn venv(workspace: &Workspace) -> Result<PathBuf> {
    venv_of(workspace, "venv", "requirements.txt", None)
}

/// The Python of the venv in which the package is tested; `None` where it is too old for it.
pub fn package_venv(workspace: &Workspace) -> Result<Option<PathBuf>> {
    has_python()?;
    if !provide::works(Command::new("python3").args(["-c", "import sys; sys.exit(sys.version_info < (3, 11))"])) {
        return Ok(None);
    }
    venv_of(workspace, "venv-package", "requirements-package.txt", None).map(Some)
}

/// The program that builds wheels, in a venv of its own: what is tested is to rest on nothing that builds it.
pub fn maturin(workspace: &Workspace) -> Result<PathBuf> {
    Ok(venv_of(workspace, "venv-maturin", "requirements-maturin.txt", None)?.with_file_name("maturin"))
}

/// The folder of the programs that build for other systems: cargo-zigbuild, and a Python that has zig.
pub fn zig(workspace: &Workspace) -> Result<PathBuf> {
    let python = venv_of(workspace, "venv-dist", "requirements-dist.txt", None)?;
    Ok(python.parent().context("a Python without a folder")?.canonicalize()?)
}

/// The Python of the venv for lots.
pub fn lot_venv(workspace: &Workspace) -> Result<PathBuf> {
    venv_of(workspace, "venv-lot", "requirements-lot.txt", None)
}

/// The Python of the venv with SKiDL, alone: what else it asks for draws schematics, which nobody here does.
pub fn circuit_venv(workspace: &Workspace) -> Result<PathBuf> {
    venv_of(workspace, "venv-circuit", "requirements-circuit.txt", Some("skidl==3.0.0"))
}

/// The Python of the venv with servers of chambers' controllers and supplies.
pub fn instruments_venv(workspace: &Workspace) -> Result<PathBuf> {
    venv_of(workspace, "venv-instruments", "requirements-instruments.txt", None)
}

/// Makes sure that there is a Python that can make a venv.
fn has_python() -> Result<()> {
    // Debian ships venv without the pip it installs: the module is there, ensurepip is not.
    let has_venv = || provide::works(Command::new("python3").args(["-c", "import venv, ensurepip"]));
    if !has_venv() {
        provide::install("Python 3 with venv", &["python3", "python3-venv"])?;
        ensure!(has_venv(), "python3 on the PATH has no venv, though python3-venv is installed");
    }
    Ok(())
}

/// The Python of a venv under target/ with the packages that a file pins and, without what it asks for, one more.
fn venv_of(workspace: &Workspace, name: &str, requirements: &str, alone: Option<&str>) -> Result<PathBuf> {
    let folder = workspace.target.join(name);
    let python = folder.join("bin/python");
    let wanted = workspace.read(Path::new(SCRIPTS).join(requirements))? + alone.unwrap_or_default();
    // Written last, so that a venv that was interrupted is made again.
    let stamp = folder.join("requirements.txt");
    if fs::read_to_string(&stamp).is_ok_and(|made| made == wanted) {
        return Ok(python);
    }
    has_python()?;
    println!("    making target/{name}");
    provide::succeed(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&folder))?;
    let pip = || {
        let mut pip = Command::new(&python);
        pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]);
        pip
    };
    provide::succeed(pip().arg("--requirement").arg(workspace.root.join(SCRIPTS).join(requirements)))?;
    if let Some(package) = alone {
        provide::succeed(pip().args(["--no-deps", package]))?;
    }
    fs::write(stamp, wanted)?;
    Ok(python)
}
