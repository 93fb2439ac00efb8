//! `cargo xtask firmware`: the firmware built for its target, its size, its costs, and its run in QEMU.

use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::cargo::{self, Lots};
use crate::provide;
use crate::steps::{Outcome, Step};
use crate::toolchain::Toolchain;
use crate::workspace::Workspace;

/// The firmware's workspace, from the root.
const FOLDER: &str = "firmware";
const TARGET: &str = "thumbv7em-none-eabihf";

/// The board of which `cargo xtask chip` runs the image.
pub const STM32F405: &str = "zerorate-stm32f405";
/// A board's package; the first is the emulated one.
const BOARDS: [&str; 2] = ["zerorate-mps2-an386", STM32F405];
/// What is counted in QEMU.
const COST: &str = "zerorate-cost";

/// The machine that it runs on, and a clock that counts instructions: 1024 ns each.
const EMULATOR: &str = "qemu-system-arm";
const COUNTING: [&str; 13] = [
    "-machine",
    "mps2-an386",
    "-nodefaults",
    "-display",
    "none",
    "-monitor",
    "none",
    "-icount",
    "shift=10,sleep=off",
    "-semihosting-config",
    "enable=on,target=native",
    "-nic",
    "none",
];

/// At most so many bytes of a board's flash and static RAM: firmware/README.md says what is in them.
const FLASH: u64 = 64 * 1024;
const RAM: u64 = 32 * 1024;

/// What is counted: the name in the output of firmware/cost, what it is, and the most instructions allowed.
const COSTS: [(&str, &str, Option<u32>); 12] = [
    ("sample", "a sample of one axis into a group", None),
    ("group", "a group of one axis closed: mean, drift, correction, tap", None),
    ("update", "an update of one axis, no edge crossed", Some(8)),
    ("update-edge", "an update of one axis, an edge crossed", Some(60)),
    ("written", "the new tap taken over after the wiper was written", None),
    ("correction-2", "the digital correction, drift of order 2", Some(30)),
    ("correction-5", "the digital correction, drift of order 5", Some(30)),
    ("correction-table", "the digital correction, drift as a table of 33 knots", Some(30)),
    ("sample-corrected", "a sample corrected, the wiper's settling followed", None),
    ("both", "an update and a correction of order 2 or 5", None),
    ("cubic", "beside: a float cubic with clamp and subtraction, as PX4 does it", None),
    ("yardstick", "ten instructions, to check the counting", Some(11)),
];

/// Builds every board and says how large it is.
pub fn steps(workspace: &Workspace, cost: bool) -> Vec<Step<'_>> {
    let mut steps = vec![Step::new("build", "mend the build", || build(workspace))];
    if cost {
        steps.push(Step::new("cost", "see firmware/cost", || costs(workspace)));
    }
    steps
}

/// Builds it, counts its costs, and holds the run in QEMU against the native one.
pub fn check(workspace: &Workspace, lots: Lots) -> Result<Outcome> {
    build(workspace)?;
    costs(workspace)?;
    cargo::test_some(workspace, lots, &["--test", "emulated", "--", "--ignored"], |_| ())
}

fn build(workspace: &Workspace) -> Result<Outcome> {
    let manifest = workspace.root.join(FOLDER).join("Cargo.toml").display().to_string();
    cargo::run(workspace, &["fmt", "--all", "--check", "--manifest-path", &manifest])?;
    for board in BOARDS {
        build_package(workspace, board)?;
    }
    println!("    {:22} {:>12} {:>12}", "board", "flash, bytes", "static RAM");
    for board in BOARDS {
        let (flash, ram) = size(workspace, board)?;
        println!("    {board:22} {flash:>12} {ram:>12}");
        ensure!(flash <= FLASH && ram <= RAM, "{board} is larger than {FLASH} bytes of flash and {RAM} of RAM");
    }
    Ok(Outcome::Passed)
}

/// Counts the instructions of what runs in the interrupt, and holds them against what they may be.
fn costs(workspace: &Workspace) -> Result<Outcome> {
    build_package(workspace, COST)?;
    if provide::on_path(&[EMULATOR]).is_none() {
        provide::install("the emulator", &["qemu-system-arm"])?;
    }
    let mut emulator = Command::new(EMULATOR);
    emulator.args(COUNTING).arg("-kernel").arg(built(workspace, COST));
    let output = emulator.output().context("qemu-system-arm could not be started")?;
    // Semihosting prints on the emulator's error output.
    let text = String::from_utf8_lossy(&output.stderr);
    let counted = |name: &str| -> Result<u32> {
        let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
        line.and_then(|count| count.parse().ok()).with_context(|| format!("no count of {name} in:\n{text}"))
    };
    println!("    instructions, from call to return");
    let mut over = Vec::new();
    for (name, what, most) in COSTS {
        let count = if name == "both" { counted("update")? + counted("correction-2")? } else { counted(name)? };
        let limit = most.map(|most| format!("at most {most}")).unwrap_or_default();
        println!("    {count:>5}  {what:66} {limit}");
        if most.is_some_and(|most| count > most) {
            over.push(what);
        }
    }
    ensure!(counted("yardstick")? == 11, "the counting is not exact: ten instructions and their call are not 11");
    ensure!(over.is_empty(), "more than allowed: {}", over.join("; "));
    Ok(Outcome::Passed)
}

/// Builds a package for its target.
pub fn build_package(workspace: &Workspace, package: &str) -> Result<()> {
    let folder = workspace.root.join(FOLDER);
    let arguments = ["build", "--release", "--locked", "--package", package];
    Toolchain::of_board()?.run(&folder, &folder.join("target"), &arguments)
}

/// Where a package's program is when it has been built.
pub fn built(workspace: &Workspace, package: &str) -> PathBuf {
    workspace.root.join(FOLDER).join("target").join(TARGET).join("release").join(package)
}

/// Bytes of flash and of static RAM, by section.
fn size(workspace: &Workspace, package: &str) -> Result<(u64, u64)> {
    const PROGRAM: &str = "arm-none-eabi-size";
    if provide::on_path(&[PROGRAM]).is_none() {
        provide::install("the target's binutils", &["binutils-arm-none-eabi"])?;
    }
    let output = Command::new(PROGRAM).arg("-A").arg(built(workspace, package)).output().context(PROGRAM)?;
    ensure!(output.status.success(), "{PROGRAM}: {}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout);
    sizes(&text).with_context(|| format!("{package} by {PROGRAM}:\n{text}"))
}

/// The same from what the program says. A section that is not there is no empty one: what it held is somewhere else, and would
/// not be counted.
fn sizes(text: &str) -> Result<(u64, u64)> {
    let section = |name: &str| -> Result<u64> {
        let mut fields = text.lines().map(str::split_whitespace).filter(|line| line.clone().next() == Some(name));
        let size = fields.find_map(|mut line| line.nth(1)?.parse().ok());
        size.with_context(|| format!("the image has no section {name}"))
    };
    let sum = |names: &[&str]| names.iter().copied().map(section).sum::<Result<u64>>();
    Ok((sum(&[".vector_table", ".text", ".rodata", ".data"])?, sum(&[".data", ".bss", ".uninit"])?))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As `arm-none-eabi-size -A` says it.
    const SAID: &str = "zerorate-stm32f405  :
section              size        addr
.vector_table         392   134217728
.text               45000   134266880
.rodata              8000   134312000
.data                   8   536870912
.bss                25600   536870920
.uninit                72   536896520
.debug_str            999           0
Total               80071
";

    #[test]
    fn what_lies_in_flash_and_in_ram_is_summed() {
        assert_eq!(sizes(SAID).unwrap(), (392 + 45_000 + 8000 + 8, 8 + 25_600 + 72));
    }

    #[test]
    fn an_image_without_a_section_that_is_summed_is_refused() {
        for name in [".vector_table", ".text", ".rodata", ".data", ".bss", ".uninit"] {
            let without: String =
                SAID.lines().filter(|line| !line.starts_with(name)).map(|line| format!("{line}\n")).collect();
            assert!(sizes(&without).unwrap_err().to_string().contains(name), "{name}");
        }
    }
}
