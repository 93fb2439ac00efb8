//! `cargo xtask gateware`: the acquisition block's lint, proofs, tests, synthesis and place-and-route.

mod proofs;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

use crate::cargo;
use crate::provide;
use crate::steps::{Outcome, Step};
use crate::workspace::Workspace;

/// Where everything is, from the root.
const BLOCK: &str = "gateware/acquisition";

/// Programs, and Debian's packages of them.
const PROGRAMS: [(&str, &str); 5] = [
    ("verilator", "verilator"),
    ("yosys", "yosys"),
    ("nextpnr-ice40", "nextpnr-ice40"),
    ("icepack", "fpga-icestorm"),
    ("g++", "g++"),
];

/// The block's clock on the board, and the fastest SCK that docs/acquisition-port.md allows.
const CLOCK_MHZ: f64 = 24.0;
const SCK_MHZ: f64 = 10.0;

/// What yosys may say, and why it may.
const EXPLAINED: [(&str, &str); 1] = [(
    "ABC: Warning: The network is combinational",
    "abc is given logic alone, the flip-flops stay with yosys; it says so of every network",
)];

/// Paths between the clocks: as nextpnr names them, at most, and why so long.
const CROSSINGS: [(&str, f64, &str); 3] = [
    // The toggle beside a word is seen no sooner than two clocks after the word has settled.
    ("posedge sck -> posedge clk", 2e3 / CLOCK_MHZ, "two clocks"),
    // At 10 MHz the first word is asked for 850 ns before it is taken, and there within 7 clocks (drawings/timing.svg).
    ("posedge clk -> negedge sck", 850.0 - 7.0 * 1e3 / CLOCK_MHZ, "what the first word has left"),
    // Half a period, less 25 ns for the pins, the board and the master's set-up time.
    ("negedge sck -> <async>", 0.5e3 / SCK_MHZ - 25.0, "half a period of SCK less 25 ns"),
];

/// A part of the chore: its name, what to do when it fails, and what it does.
type Part = (&'static str, &'static str, fn(&Workspace) -> Result<Outcome>);

const PARTS: [Part; 6] = [
    ("tools", "install what it names", tools),
    ("lint", "mend what Verilator points at", lint),
    ("proofs", "see gateware/acquisition/formal/README.md", proofs::check),
    ("simulation", "see gateware/acquisition/sim/README.md", simulation),
    ("bench", "see gateware/acquisition/bench/README.md", bench),
    ("synthesis", "see the logs in target/gateware", synthesis),
];

/// The chore's steps.
pub fn steps(workspace: &Workspace) -> Vec<Step<'_>> {
    PARTS.iter().map(|&(name, remedy, part)| Step::new(name, remedy, move || part(workspace))).collect()
}

/// All of them as one.
pub fn check(workspace: &Workspace) -> Result<Outcome> {
    for (name, remedy, part) in PARTS {
        println!("    {name}");
        part(workspace).with_context(|| format!("{name} ({remedy})"))?;
    }
    Ok(Outcome::Passed)
}

fn tools(_: &Workspace) -> Result<Outcome> {
    let missing: Vec<&str> =
        PROGRAMS.iter().filter(|(program, _)| provide::on_path(&[program]).is_none()).map(|(_, in_)| *in_).collect();
    if !missing.is_empty() {
        provide::install("the FPGA toolchain", &missing)?;
    }
    Ok(Outcome::Passed)
}

/// Verilator has nothing to say of the block nor of the board's top.
fn lint(workspace: &Workspace) -> Result<Outcome> {
    let board = ["board/primitives.sv", "board/output_register.sv", "board/icebreaker.sv"];
    for (top, files) in [("acquisition", &["rtl/acquisition.sv"][..]), ("icebreaker", &board)] {
        println!("    verilator --lint-only -Wall, {top}");
        let mut verilator = Command::new("verilator");
        verilator.current_dir(workspace.root.join(BLOCK)).args(["--lint-only", "-Wall", "--assert", "-Irtl"]);
        provide::succeed(verilator.arg("--top-module").arg(top).args(files))?;
    }
    Ok(Outcome::Passed)
}

/// The block in simulation, from Rust.
fn simulation(workspace: &Workspace) -> Result<Outcome> {
    run(workspace, &["fmt", "--all", "--check"])?;
    check_package(workspace, "zerorate-gateware")
}

/// A unit tested through the block: by groups against the simulated port, then the whole of a calibration, shortened.
fn bench(workspace: &Workspace) -> Result<Outcome> {
    check_package(workspace, "zerorate-gateware-bench")
}

fn check_package(workspace: &Workspace, package: &str) -> Result<Outcome> {
    run(workspace, &["test", "--locked", "--package", package, "--no-fail-fast"])?;
    Ok(Outcome::Passed)
}

/// A cargo command in the block's workspace.
fn run(workspace: &Workspace, arguments: &[&str]) -> Result<()> {
    cargo::run_in(workspace, BLOCK, &out(workspace)?, arguments)
}

/// The board's bitstream, what it takes and how fast it is.
fn synthesis(workspace: &Workspace) -> Result<Outcome> {
    let out = out(workspace)?;
    let in_out = |name: &str| out.join(name);
    let netlist = in_out("icebreaker.json");
    // The board has its own of what stands in front of a pin.
    let sources: Vec<String> =
        rtl(workspace)?.into_iter().filter(|file| !file.ends_with("output_register.sv")).collect();
    let script = format!(
        "read_verilog -sv {} board/output_register.sv board/icebreaker.sv; synth_ice40 -top icebreaker -json {}",
        sources.join(" "),
        netlist.display()
    );
    let log = yosys(&workspace.root.join(BLOCK), &script, &in_out("yosys.log"))?;
    ensure!(!log.contains("Latch inferred"), "latches: see target/gateware/yosys.log");
    unexplained(&log, "yosys.log")?;
    let luts =
        log.lines().rev().find_map(|line| line.trim().strip_prefix("SB_LUT4")).context("yosys counts no LUTs")?;
    println!("    LUT4: {}", luts.trim());

    println!("    nextpnr-ice40 --up5k --package sg48");
    let (report, bits) = (in_out("nextpnr.json"), in_out("icebreaker.asc"));
    let mut nextpnr = Command::new("nextpnr-ice40");
    nextpnr.args(["--up5k", "--package", "sg48", "--seed", "1", "--freq", "24"]);
    nextpnr.arg("--json").arg(&netlist).arg("--report").arg(&report).arg("--asc").arg(&bits);
    nextpnr.arg("--pcf").arg(workspace.root.join(BLOCK).join("board/icebreaker.pcf"));
    let log = logged(&mut nextpnr, &in_out("nextpnr.log"))?;
    unexplained(&log, "nextpnr.log")?;
    provide::succeed(Command::new("icepack").arg(&bits).arg(in_out("icebreaker.bin")))?;

    let report: Value = serde_json::from_str(&fs::read_to_string(&report)?)?;
    resources(&report)?;
    let slow = [clock(&report, "clk", CLOCK_MHZ)?, clock(&report, "sck", SCK_MHZ)?];
    ensure!(slow.iter().all(|slow| !slow), "a clock is too slow");
    crossings(&log)?;
    println!("    bitstream: {}", in_out("icebreaker.bin").display());
    Ok(Outcome::Passed)
}

/// What the block may take: as nextpnr names it, what it is, and how much.
const RESOURCES: [(&str, &str, u64); 2] = [
    // Two thirds of the chip: place-and-route finds its way without luck.
    ("ICESTORM_LC", "logic cells (a LUT4, a flip-flop or both)", 3500),
    // Two thirds as well: two banks of 512 scans of four samples are 16, two copies of the sums 2.
    ("ICESTORM_RAM", "block RAM (4 kbit each)", 20),
];

/// Prints what is used, of what may be and of what there is.
fn resources(report: &Value) -> Result<()> {
    for (name, what, most) in RESOURCES {
        let number = |of: &str| report["utilization"][name][of].as_u64().with_context(|| format!("no {of} of {name}"));
        let used = number("used")?;
        println!("    {what}: {used}, at most {most} of {}", number("available")?);
        ensure!(used <= most, "{used} {what}");
    }
    Ok(())
}

/// Prints a clock's Fmax; whether it is too slow.
fn clock(report: &Value, name: &str, wanted_mhz: f64) -> Result<bool> {
    let fmax_mhz = report["fmax"][name]["achieved"].as_f64().with_context(|| format!("no Fmax of {name}"))?;
    println!("    Fmax of {name}: {fmax_mhz:.1} MHz, {wanted_mhz:.0} needed");
    Ok(fmax_mhz < wanted_mhz)
}

/// Prints the paths between clocks, which no Fmax covers, and holds them to what they have.
fn crossings(log: &str) -> Result<()> {
    for (path, limit_ns, why) in CROSSINGS {
        // `Info: Max delay posedge sck -> posedge clk: 29.73 ns`, in columns.
        let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
        let line = log.lines().rev().map(words).find(|line| line.starts_with(&format!("Info: Max delay {path}")));
        let line = line.with_context(|| format!("nextpnr says nothing of {path}"))?;
        let delay_ns = line.rsplit(": ").next().and_then(|delay| delay.strip_suffix(" ns")).map(str::parse::<f64>);
        let delay_ns = delay_ns.with_context(|| line.clone())??;
        println!("    {path}: {delay_ns:.1} ns, at most {limit_ns:.0} ({why})");
        ensure!(delay_ns <= limit_ns, "{path} is too long");
    }
    Ok(())
}

/// The block's sources, from its folder.
fn rtl(workspace: &Workspace) -> Result<Vec<String>> {
    let files = workspace.files(Path::new(BLOCK).join("rtl"))?;
    files.iter().map(|file| Ok(file.strip_prefix(BLOCK)?.to_string_lossy().into_owned())).collect()
}

fn yosys(folder: &Path, script: &str, log: &Path) -> Result<String> {
    logged(Command::new("yosys").current_dir(folder).args(["-p", script]), log)
}

/// Runs a command into a log; its text.
fn logged(command: &mut Command, log: &Path) -> Result<String> {
    let file = fs::File::create(log).with_context(|| log.display().to_string())?;
    command.stdin(Stdio::null()).stdout(file.try_clone()?).stderr(file);
    provide::succeed(command).with_context(|| format!("see {}", log.display()))?;
    fs::read_to_string(log).with_context(|| log.display().to_string())
}

/// An error for each warning that has no reason in [`EXPLAINED`].
fn unexplained(log: &str, name: &str) -> Result<()> {
    let warnings: Vec<&str> = log
        .lines()
        .filter(|line| line.contains("Warning:"))
        .filter(|line| !EXPLAINED.iter().any(|(what, _)| line.contains(what)))
        .collect();
    if !warnings.is_empty() {
        bail!("{name} has {} warnings without a reason\n    {}", warnings.len(), warnings.join("\n    "));
    }
    Ok(())
}

/// Where it is built.
pub fn out(workspace: &Workspace) -> Result<PathBuf> {
    let out = workspace.target.join("gateware");
    fs::create_dir_all(&out).with_context(|| out.display().to_string())?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_needs_a_reason() {
        assert!(unexplained("ABC: Warning: The network is combinational (run \"fraig\")\nInfo: all well", "a").is_ok());
        assert!(unexplained("rtl/banks.sv:1: Warning: wire is implicitly declared", "a").is_err());
    }

    #[test]
    fn crossings_are_read_from_nextpnr_s_last_report_and_held_to_their_limits() {
        let log = |to_clk: f64| {
            format!(
                "Info: Max delay posedge sck -> posedge clk: 999.00 ns\n\
                 Info: Max delay <async>     -> posedge clk: 9.55 ns\n\
                 Info: Max delay posedge sck -> posedge clk: {to_clk:.2} ns\n\
                 Info: Max delay posedge clk -> negedge sck: 5.60 ns\n\
                 Info: Max delay negedge sck -> <async>    : 6.84 ns\n"
            )
        };
        assert!(crossings(&log(29.73)).is_ok());
        assert!(crossings(&log(84.0)).is_err());
        assert!(crossings("Info: nothing").is_err());
    }
}
