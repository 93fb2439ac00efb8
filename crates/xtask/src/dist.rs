//! What people install who have no Rust: an archive for each system, a package for Debian, and the checksums of all.
//!
//! zig links for every system from one machine, against musl or Windows' own libraries, so that no old glibc is asked for.

mod trial;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use crate::cargo;
use crate::provide;
use crate::python;
use crate::steps::{Outcome, Step};
use crate::workspace::Workspace;

/// Versions of what makes the Debian package.
const CARGO_DEB: [&str; 2] = ["cargo-deb", "3.8.0"];

/// What stands beside the program in an archive.
const BESIDE: [&str; 4] = ["README.md", "CHANGELOG.md", "LICENSE-APACHE", "LICENSE-MIT"];

/// A system for which the command is built.
pub struct System {
    /// By the name that Rust has for it.
    target: &'static str,
    /// The program that runs it here, and the Debian packages that have it; none where this machine does.
    runner: Option<(&'static str, &'static [&'static str])>,
}

/// All of them: the first runs here, and is what the Debian package holds.
pub const SYSTEMS: [System; 3] = [
    System { target: "x86_64-unknown-linux-musl", runner: None },
    System { target: "aarch64-unknown-linux-musl", runner: Some(("qemu-aarch64", &["qemu-user"])) },
    System { target: "x86_64-pc-windows-gnu", runner: Some(("wine", &["wine", "wine64"])) },
];

impl System {
    fn is_windows(&self) -> bool {
        self.target.contains("windows")
    }

    /// The built program.
    fn program(&self, workspace: &Workspace) -> PathBuf {
        let program = if self.is_windows() { "zerorate.exe" } else { "zerorate" };
        built(workspace).join(self.target).join("release").join(program)
    }
}

/// A step for each system that is asked for, all if none is; last the Debian package and the checksums.
pub fn steps<'a>(workspace: &'a Workspace, asked: &[String]) -> Result<Vec<Step<'a>>> {
    if let Some(unknown) = asked.iter().find(|asked| SYSTEMS.iter().all(|system| system.target != **asked)) {
        let known: Vec<&str> = SYSTEMS.iter().map(|system| system.target).collect();
        bail!("`{unknown}` is none of the systems: {}", known.join(", "));
    }
    let wanted = |system: &&System| asked.is_empty() || asked.iter().any(|asked| asked == system.target);
    let mut steps = Vec::new();
    for system in SYSTEMS.iter().filter(wanted) {
        steps.push(Step::new(system.target, "mend the build for it", move || build(workspace, system)));
        steps.push(Step::new("trial", "its figures differ from this machine's", move || trial::run(workspace, system)));
        if system.runner.is_none() {
            steps.push(Step::new("debian", "see package.metadata.deb in crates/cli/Cargo.toml", move || {
                debian(workspace, system)
            }));
        }
    }
    steps.push(Step::new("checksums", "see target/dist/archives", || checksums(workspace)));
    Ok(steps)
}

/// Builds the command for a system and packs it.
fn build(workspace: &Workspace, system: &System) -> Result<Outcome> {
    let installed = Command::new("rustup").args(["target", "add", system.target]).status();
    ensure!(
        installed.is_ok_and(|status| status.success()),
        "std for {0} is missing: `rustup target add {0}` installs it",
        system.target
    );
    let tools = python::zig(workspace)?;
    let mut zigbuild = Command::new(tools.join("cargo-zigbuild"));
    zigbuild.current_dir(&workspace.root).env("CARGO_TARGET_DIR", built(workspace)).env("PATH", with(&tools)?);
    zigbuild.args(["zigbuild", "--release", "--locked", "--package", "zerorate", "--target", system.target]);
    provide::succeed(&mut zigbuild)?;
    pack(workspace, system)
}

/// Puts the program and what stands beside it into an archive: a zip for Windows.
fn pack(workspace: &Workspace, system: &System) -> Result<Outcome> {
    let name = format!("zerorate-{}-{}", env!("CARGO_PKG_VERSION"), system.target);
    let folder = archives(workspace)?.join(&name);
    if folder.is_dir() {
        fs::remove_dir_all(&folder)?;
    }
    fs::create_dir_all(&folder)?;
    let program = system.program(workspace);
    fs::copy(&program, folder.join(program.file_name().context("a program without a name")?))?;
    for file in BESIDE {
        fs::copy(workspace.root.join(file), folder.join(file)).context(file)?;
    }
    let (archive, mut command) = if system.is_windows() {
        let mut zip = Command::new("python3");
        zip.args(["-m", "zipfile", "-c"]);
        (format!("{name}.zip"), zip)
    } else {
        let mut tar = Command::new("tar");
        tar.arg("-czf");
        (format!("{name}.tar.gz"), tar)
    };
    provide::succeed(command.args([&archive, &name]).current_dir(archives(workspace)?))?;
    fs::remove_dir_all(&folder)?;
    println!("    {}", archives(workspace)?.join(archive).display());
    Ok(Outcome::Passed)
}

/// The package for Debian and its like, of the program that asks for no library.
fn debian(workspace: &Workspace, system: &System) -> Result<Outcome> {
    let tools = workspace.target.join("tools");
    let cargo_deb = tools.join("bin").join(CARGO_DEB[0]);
    if !cargo_deb.is_file() {
        println!("    installing {} {} to {}", CARGO_DEB[0], CARGO_DEB[1], tools.display());
        let install = ["install", CARGO_DEB[0], "--version", CARGO_DEB[1], "--locked", "--quiet", "--root"];
        provide::succeed(cargo::program().args(install).arg(&tools))?;
    }
    let mut deb = Command::new(cargo_deb);
    deb.current_dir(&workspace.root).env("CARGO_TARGET_DIR", built(workspace));
    deb.args(["--no-build", "--no-strip", "--package", "zerorate", "--target", system.target, "--output"]);
    provide::succeed(deb.arg(archives(workspace)?))?;
    Ok(Outcome::Passed)
}

/// `SHA256SUMS` of all that lies there, as `sha256sum --check` reads it.
fn checksums(workspace: &Workspace) -> Result<Outcome> {
    let folder = archives(workspace)?;
    let mut names = Vec::new();
    for entry in fs::read_dir(&folder)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        names.extend((name != "SHA256SUMS").then_some(name));
    }
    names.sort();
    let sums = Command::new("sha256sum").args(&names).current_dir(&folder).output()?;
    ensure!(sums.status.success(), "sha256sum ended with {}", sums.status);
    print!("{}", String::from_utf8_lossy(&sums.stdout));
    fs::write(folder.join("SHA256SUMS"), sums.stdout)?;
    Ok(Outcome::Passed)
}

/// Where it is built: for other systems, so that nothing of this one's is built anew.
fn built(workspace: &Workspace) -> PathBuf {
    workspace.target.join("dist")
}

fn archives(workspace: &Workspace) -> Result<PathBuf> {
    let folder = built(workspace).join("archives");
    fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    Ok(folder)
}

/// The PATH with a folder before it.
fn with(folder: &Path) -> Result<std::ffi::OsString> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    Ok(std::env::join_paths([folder.to_owned()].into_iter().chain(std::env::split_paths(&path)))?)
}
