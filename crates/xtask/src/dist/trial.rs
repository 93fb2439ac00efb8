//! The built programs on this machine: each must give the figures of the ordinary build, to the last bit.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use super::{System, built};
use crate::figures::{Comparison, Extent};
use crate::provide;
use crate::python;
use crate::steps::Outcome;
use crate::workspace::Workspace;

/// Of Windows' `bcryptprimitives.dll` the one function that Rust's std asks for: Debian 12's Wine has none.
const CHANCE: &str = "\
#include <windows.h>
#include <ntsecapi.h>
__declspec(dllexport) BOOL WINAPI ProcessPrng(BYTE *into, SIZE_T bytes) { return RtlGenRandom(into, (ULONG)bytes); }
";

/// Calibrations, a study and fits of logs, beside those of this machine's own build.
pub fn run(workspace: &Workspace, system: &System) -> Result<Outcome> {
    let before = workspace.zerorate()?.canonicalize()?;
    let program = system.program(workspace).canonicalize()?;
    let after = match system.runner {
        None => program,
        Some((runner, packages)) => {
            if provide::on_path(&[runner]).is_none() {
                provide::install(runner, packages)?;
            }
            if system.is_windows() {
                give_chance(workspace, &program)?;
            }
            started_by(workspace, system, runner, &program)?
        }
    };
    Comparison { workspace, before, after, extent: Extent::All, within: 0.0, held_out: false }.run()
}

/// A script that starts a program by its runner, and is a program like another.
fn started_by(workspace: &Workspace, system: &System, runner: &str, program: &Path) -> Result<PathBuf> {
    let script = built(workspace).join(format!("run-{}", system.target));
    // Wine tells of windows that nobody opens, and keeps what it is asked to keep in a folder of its own.
    let prefix = built(workspace).join("wine");
    let text = format!(
        "#!/bin/sh\nexport WINEDEBUG=-all WINEPREFIX='{}'\nexec {runner} '{}' \"$@\"\n",
        prefix.display(),
        program.display()
    );
    fs::write(&script, text).with_context(|| script.display().to_string())?;
    fs::set_permissions(&script, fs::Permissions::from_mode(0o755))?;
    Ok(script.canonicalize()?)
}

/// Puts the library that Wine lacks beside the program, where Windows looks first.
fn give_chance(workspace: &Workspace, program: &Path) -> Result<()> {
    let library = program.with_file_name("bcryptprimitives.dll");
    if library.is_file() {
        return Ok(());
    }
    let source = built(workspace).join("bcryptprimitives.c");
    fs::write(&source, CHANCE)?;
    let mut zig = Command::new(python::zig(workspace)?.join("python"));
    zig.args(["-m", "ziglang", "cc", "-target", "x86_64-windows-gnu", "-shared", "-O2", "-o"]).arg(&library);
    provide::succeed(zig.arg(&source).arg("-ladvapi32"))
}
