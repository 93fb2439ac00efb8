//! The fuzz targets, built with libFuzzer's instrumentation by the stable compiler, and run.
//!
//! cargo-fuzz does the same with nightly Rust and the address sanitizer. What these parsers could do wrong without `unsafe`
//! is to panic, to take too much memory or too long: the targets watch for that themselves (fuzz/limits.rs).

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::cargo;
use crate::provide;
use crate::steps::{Outcome, Step, chosen};
use crate::workspace::Workspace;

/// The targets, with the longest input of each in bytes: logs of a kilobyte reach every message; a calibration and a record
/// must have room for all their fields.
const TARGETS: [(&str, u32); 6] =
    [("ulog", 1024), ("dataflash", 1024), ("csv", 1024), ("calibration", 16_384), ("record", 4096), ("request", 1024)];

/// What clang's `-fsanitize=fuzzer` asks of LLVM: counters for edges, and comparisons told to the fuzzer.
const INSTRUMENTATION: [&str; 6] = [
    "--cfg=fuzzing",
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-sanitizer-coverage-trace-compares",
];

/// The build, then a step a target.
pub fn steps<'a>(workspace: &'a Workspace, seconds: u32, only: &[String]) -> Result<Vec<Step<'a>>> {
    let run = |(name, longest): (&'static str, u32)| {
        let remedy = "`zerorate` must survive the input named above: mend it, and put the input into fuzz/seeds";
        Step::new(name, remedy, move || fuzz(workspace, name, longest, seconds))
    };
    let mut steps = vec![Step::new("build", "mend the build", || build(workspace))];
    steps.extend(chosen(TARGETS.map(run).into(), only, &[])?);
    Ok(steps)
}

fn folder(workspace: &Workspace) -> PathBuf {
    workspace.target.join("fuzz")
}

/// The compiler's own platform; with it named, build scripts and macros are built without the instrumentation.
fn platform() -> Result<String> {
    let told = Command::new("rustc").arg("-vV").output().context("rustc could not be started")?;
    let told = String::from_utf8_lossy(&told.stdout).into_owned();
    let host = told.lines().find_map(|line| line.strip_prefix("host: ")).context("rustc -vV names no host")?;
    Ok(host.to_owned())
}

fn build(workspace: &Workspace) -> Result<Outcome> {
    if provide::on_path(&["c++", "g++", "clang++"]).is_none() {
        provide::install("a C++ compiler", &["g++"])?;
    }
    let mut command = cargo::program();
    command.args(["build", "--release", "--locked", "--manifest-path", "fuzz/Cargo.toml", "--target", &platform()?]);
    command.current_dir(&workspace.root).env("CARGO_TARGET_DIR", folder(workspace));
    command.env("CARGO_ENCODED_RUSTFLAGS", INSTRUMENTATION.join("\x1f"));
    provide::succeed(&mut command)?;
    Ok(Outcome::Passed)
}

fn fuzz(workspace: &Workspace, name: &str, longest: u32, seconds: u32) -> Result<Outcome> {
    let program = folder(workspace).join(platform()?).join("release").join(name);
    let seeds = workspace.root.join("fuzz/seeds").join(name);
    let (found, crashes) = (folder(workspace).join("found").join(name), folder(workspace).join("artifacts"));
    for folder in [&found, &crashes] {
        fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    ensure!(seeds.is_dir(), "{} is missing: a target needs an input to begin with", seeds.display());
    let mut fuzzer = Command::new(program);
    fuzzer.arg(&found).arg(seeds);
    fuzzer.args([format!("-max_total_time={seconds}"), format!("-max_len={longest}")]);
    // The target counts its own processor time; this ends what hangs, however busy the machine is.
    fuzzer.args(["-timeout=20", "-rss_limit_mb=1024", "-print_final_stats=1", "-verbosity=0"]);
    fuzzer.arg(format!("-artifact_prefix={}/{name}-", crashes.display()));
    provide::succeed(&mut fuzzer)?;
    Ok(Outcome::Passed)
}
