//! `cargo xtask`: the project's chores.
//!
//! `cargo xtask test` is what a change must pass. It installs what it needs when it may, and otherwise names it.

mod all_tests;
mod arrows;
mod beside;
mod book;
mod browser;
mod cargo;
mod chip;
mod circles;
mod circuit;
mod devtools;
mod dist;
mod faults;
mod figures;
mod firmware;
mod fuzz;
mod gateware;
mod house;
mod instruments;
mod lines;
mod live;
mod lot;
mod package;
mod provide;
mod publish;
mod python;
mod report;
mod steps;
mod syntax;
mod targets;
mod toolchain;
mod unused;
mod web;
mod wiring;
mod workspace;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::{Parser, Subcommand};

use beside::Beside;
use cargo::Lots;
use figures::{Comparison, Extent};
use steps::{Outcome, Step};
use workspace::Workspace;

#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", about = "The project's chores")]
struct Arguments {
    #[command(subcommand)]
    chore: Chore,
}

#[derive(Subcommand)]
enum Chore {
    /// Run every check and stop at the first that fails
    ///
    /// In order, with wasm, circuit, gateware, firmware and chip beside the others: what those say follows at the end.
    ///
    /// Formatting, documentation and tests by cargo, with clippy as the tests' compiler; the rules of ARCHITECTURE.md by reading the sources; then
    /// the built command against numpy and against damaged recordings; what would be published, installed, and the Python
    /// package against the command; the circuit in ngspice and the gateware by the FPGA tools, the firmware in QEMU and the image for the chip in Unicorn, as the chores `circuit`, `gateware`, `firmware` and
    /// `chip` do; the report in a headless browser, and the
    /// page that fits a log held against the command; last the book, whose commands are run. What that needs is
    /// installed if this runs as root on Debian, and named if it does not.
    ///
    /// Recordings are looked for in ../shared/data, or in the folder that the variable ZERORATE_DATA names.
    Test {
        /// Leave out what needs Python, ngspice, the FPGA tools or a browser, whole lots, and eight long tests
        #[arg(long)]
        fast: bool,
        /// Leave out the tests of whole lots, and so the query engine, which is long to build: `cargo test -p zerorate-lot` makes good for it
        #[arg(long)]
        no_lots: bool,
        /// Every step, as without options
        #[arg(long, conflicts_with_all = ["fast", "no_lots", "without", "only"])]
        all: bool,
        /// Leave out this step
        #[arg(long, value_name = "STEP")]
        without: Vec<String>,
        /// For steps that this command runs beside the others: they end when the standard input does
        #[arg(long, hide = true)]
        beside: bool,
        /// Run these steps only: format, rustdoc, tests, publish, no_std, wasm, arrows, circles, unused, house,
        /// wiring, build, numpy, numbers, damage, instruments, install, python,
        /// circuit, gateware, firmware, chip, report, web, book
        #[arg(value_name = "STEP")]
        only: Vec<String>,
    },
    /// Set `zerorate fit` beside ArduPilot's script, on the same logs, and print both
    ///
    /// Wall time, peak memory, in-sample and held-out rms on the chamber cycle at 2, 25 and 100 Hz, with the release build
    /// (`cargo build --release`). The script comes from PyPI into target/venv-compare. It takes minutes at 25 Hz, for held
    /// out means nine runs of it, and does not finish at 100 Hz: it is stopped then.
    Compare {
        /// Seconds after which ArduPilot's script is stopped
        #[arg(long, value_name = "SECONDS", default_value = "400")]
        deadline: u32,
        /// These rates only: 2 (as recorded), 25, 100, or others
        #[arg(value_name = "HZ")]
        rates: Vec<f64>,
    },
    /// Compare the figures of two builds of `zerorate`, digit by digit
    ///
    /// `calibrate` with three seeds (what is printed, and every file but the report), a `study`, and `fit` of the chamber
    /// cycle as ULog, DataFlash, CSV and TSV, by the model that it chooses and by a plain cubic. Wall times and
    /// versions are left out. A change that only moves code must move no figure: keep a build from before it.
    Figures {
        /// The build whose figures hold
        #[arg(long, value_name = "PROGRAM")]
        before: PathBuf,
        /// The build that must have the same; without it this tree's release build
        #[arg(long, value_name = "PROGRAM")]
        after: Option<PathBuf>,
        /// Let a number differ by so much of itself: 1e-9 lets the order of a sum change
        #[arg(long, value_name = "RELATIVE", default_value = "0")]
        within: f64,
        /// The protocol of held-out figures as well, by ../tools/held_out.py beside the recordings
        #[arg(long)]
        held_out: bool,
    },
    /// Run every fuzz target for a while; a crash, 64 MiB or a second is a failure
    ///
    /// libFuzzer on the parsers of logs, calibrations and device records, from the seeds in fuzz/seeds. Needs a C++ compiler
    /// and no nightly Rust. Inputs found and crashes are kept in target/fuzz.
    Fuzz {
        /// Seconds a target
        #[arg(long, default_value = "60")]
        seconds: u32,
        /// These targets only: ulog, dataflash, csv, calibration, record, request
        #[arg(value_name = "TARGET")]
        only: Vec<String>,
    },
    /// Run the zero-adjust circuit in ngspice and compare it with what the simulated bench assumes
    ///
    /// Counts a tap, centre, corner and rails as drawn, then with every part off its value: the tables of
    /// hardware/README.md; last the netlist for a layout, held to the simulated one. ngspice is installed if this runs as root on
    /// Debian, and named if it does not; SKiDL comes from PyPI into target/venv-circuit.
    Circuit,
    /// Hold the raw stage of zerorate-lot against DuckDB and a plain loop, at a hundred million rows
    ///
    /// Writes the rows once (half a gigabyte in target/compare-lot), then measures. DuckDB comes from PyPI.
    CompareLot {
        /// Raw samples, if not a hundred million
        #[arg(long)]
        rows: Option<u64>,
    },
    /// Print how many lines of Rust every package has, tests left out
    Lines,
    /// Check the acquisition gateware and build it for the iCEBreaker
    ///
    /// Verilator's lint, proofs by yosys, the tests of the verilated block, a shortened test of a unit through it, synthesis
    /// and place-and-route: the table of gateware/acquisition/README.md. What that needs is installed if this runs as
    /// root on Debian, and named if not.
    Gateware,
    /// Build the firmware for every board and say how large it is
    ///
    /// With the ordinary toolchain where `rustup target add thumbv7em-none-eabihf` was done; else with Debian's Rust, which
    /// builds core from its own source and is installed if this runs as root on Debian.
    Firmware {
        /// Count in QEMU what runs in the interrupt: the table of firmware/README.md
        #[arg(long)]
        cost: bool,
    },
    /// Build what people install who have no Rust: target/dist/archives
    ///
    /// The command for Linux on x86-64 and ARM (with musl, so for any), and for Windows; a package for Debian; SHA-256 of each.
    /// Every program must give the figures of this machine's own build (`cargo build --release`) to the last bit, by
    /// qemu-user and Wine, which are installed if this runs as root on Debian, and named if not. cargo-zigbuild and zig
    /// come from PyPI into target/venv-dist, std for the systems by rustup, cargo-deb into target/tools. It takes about
    /// ten minutes a system.
    Dist {
        /// These systems only: x86_64-unknown-linux-musl, aarch64-unknown-linux-musl, x86_64-pc-windows-gnu
        #[arg(value_name = "SYSTEM")]
        systems: Vec<String>,
    },
    /// Make a site of the book: target/book/site
    ///
    /// Its reference is made from the built command (`cargo build --release`). mdBook is installed into target/tools.
    Book,
    /// Build the page that fits a log in a browser: target/web/zerorate.html, one file
    ///
    /// With the toolchain that builds the firmware, which is installed if this runs as root on Debian, and named if not.
    Web,
    /// Run the image for the STM32F405 in an emulator of the chip, against the simulated bench
    ///
    /// Builds the image as `firmware` does, and runs every case of chip/README.md on it, a line each: power-up, the fault
    /// table, restarts, chip select, the native board's bits. Unicorn is built from source; clang and cmake are
    /// installed if this runs as root on Debian, and named if not.
    Chip,
}

fn main() -> Result<ExitCode> {
    let chore = Arguments::parse().chore;
    let workspace = Workspace::of_this_run()?;
    Ok(match chore {
        Chore::Test { fast, no_lots, all: _, without, beside, only } => {
            if beside {
                beside::end_with_the_input();
            }
            let lots = if fast || no_lots { Lots::LeftOut } else { Lots::Tested };
            let chosen = steps::chosen(checks(&workspace, fast, lots), &only, &without)?;
            run_in_two_lanes(&workspace, chosen, fast || beside, lots)?
        }
        Chore::CompareLot { rows } => {
            steps::run(&[Step::new("compare-lot", "see crates/xtask/python/compare_lot.py", || {
                lot::compare(&workspace, rows)
            })])
        }
        Chore::Compare { deadline, rates } => {
            steps::run(&[Step::new("compare", "see crates/xtask/python/compare_tools.py", || {
                python::compare_tools(&workspace, deadline, &rates)
            })])
        }
        Chore::Figures { before, after, within, held_out } => {
            let after = after.map_or_else(|| workspace.zerorate(), Ok)?;
            let [before, after] =
                [before, after].map(|program| program.canonicalize().with_context(|| program.display().to_string()));
            let (before, after) = (before?, after?);
            let comparison = Comparison { workspace: &workspace, before, after, extent: Extent::All, within, held_out };
            let step =
                Step::new("figures", "mend it, or say in the commit which figures moved and why", || comparison.run());
            steps::run(&[step])
        }
        Chore::Fuzz { seconds, only } => steps::run(&fuzz::steps(&workspace, seconds, &only)?),
        Chore::Lines => steps::run(&[Step::new("lines", "mend what it points at", || lines::print(&workspace))]),
        Chore::Circuit => steps::run(&[circuit(&workspace)]),
        Chore::Gateware => steps::run(&gateware::steps(&workspace)),
        Chore::Firmware { cost } => steps::run(&firmware::steps(&workspace, cost)),
        Chore::Dist { systems } => steps::run(&dist::steps(&workspace, &systems)?),
        Chore::Book => steps::run(&[Step::new("book", "see docs/book", || book::build(&workspace))]),
        Chore::Web => steps::run(&[Step::new("web", "mend the build", || web::build_page(&workspace))]),
        Chore::Chip => steps::run(&chip::steps(&workspace)),
    })
}

fn circuit(workspace: &Workspace) -> Step<'_> {
    Step::new("circuit", "see hardware/README.md", || circuit::check(workspace))
}

/// Runs steps in order, and beside them those that can be run so; all `in_order` where that is asked, and where there are no
/// others.
fn run_in_two_lanes(workspace: &Workspace, steps: Vec<Step>, in_order: bool, lots: Lots) -> Result<ExitCode> {
    let is_aside = |step: &Step| beside::STEPS.contains(&step.name());
    if in_order || steps.iter().all(is_aside) || !steps.iter().any(is_aside) {
        return Ok(steps::run(&steps));
    }
    let (aside, mut here): (Vec<_>, Vec<_>) = steps.into_iter().partition(is_aside);
    let names: Vec<&str> = aside.iter().map(Step::name).collect();
    let beside = Beside::start(workspace, &names, lots)?;
    here.push(Step::new("beside", "run the step alone that failed", move || beside.finish()));
    Ok(steps::run(&here))
}

/// Every check: cargo's, which say the most, then those that read, then those that need the built command.
fn checks(workspace: &Workspace, fast: bool, lots: Lots) -> Vec<Step<'_>> {
    let within = |check: fn(&Workspace) -> Result<Outcome>| move || check(workspace);
    vec![
        Step::new("format", "run `cargo fmt`", within(cargo::format)),
        Step::new("rustdoc", "mend what it points at", within(cargo::document)),
        Step::new("tests", "`cargo test -p CRATE NAME` runs one, `cargo clippy` lints alone", move || {
            all_tests::check(workspace, lots, fast)
        }),
        Step::new("publish", "mend what cannot be published", within(publish::check)),
        Step::new("no_std", "see ARCHITECTURE.md, Arrows", within(targets::no_std)).skipped_if(fast, "--fast"),
        Step::new("wasm", "see ARCHITECTURE.md, Where things happen", within(targets::wasm)).skipped_if(fast, "--fast"),
        Step::new("arrows", "see ARCHITECTURE.md, Arrows", within(arrows::check)),
        Step::new("circles", "see CONTRIBUTING.md, Arrows", within(circles::check)),
        Step::new("unused", "take it out, or say in crates/xtask/src/unused/kept.rs why not", within(unused::check)),
        Step::new("house", "see CONTRIBUTING.md, Habits", within(house::check)),
        Step::new(
            "wiring",
            "hardware/wiring.md, the pins of firmware and gateware, and the board's connectors are one",
            within(wiring::check),
        ),
        Step::new("build", "mend the build", within(cargo::build_command)).skipped_if(fast, "--fast"),
        Step::new("numpy", "see crates/xtask/python/compare_fit.py", within(python::compare_fit))
            .skipped_if(fast, "--fast"),
        Step::new("numbers", "see crates/xtask/python/printed_numbers.py", within(python::printed_numbers))
            .skipped_if(fast, "--fast"),
        Step::new("damage", "see crates/xtask/python/damaged_recordings.py", within(python::damaged_recordings))
            .skipped_if(fast, "--fast"),
        Step::new("instruments", "see docs/instruments.md, What was tried", move || {
            instruments::check(workspace, lots)
        })
        .skipped_if(fast, "--fast"),
        Step::new(
            "install",
            "mend what cannot be published, or what differs where it is installed",
            within(publish::install),
        )
        .skipped_if(fast, "--fast"),
        Step::new("python", "see crates/python/README.md", within(package::check)).skipped_if(fast, "--fast"),
        circuit(workspace).skipped_if(fast, "--fast"),
        Step::new("gateware", "`cargo xtask gateware` runs it alone", within(gateware::check))
            .skipped_if(fast, "--fast"),
        Step::new(
            "firmware",
            "`cargo xtask firmware --cost` builds it and counts; see firmware/README.md",
            move || firmware::check(workspace, lots),
        )
        .skipped_if(fast, "--fast"),
        Step::new("chip", "`cargo xtask chip` runs its cases alone; see chip/README.md", within(chip::check))
            .skipped_if(fast, "--fast"),
        Step::new("report", "look at target/report-screenshots", within(report::check)).skipped_if(fast, "--fast"),
        Step::new("web", "see crates/web/README.md; look at target/web-screenshots", within(web::check))
            .skipped_if(fast, "--fast"),
        Step::new("book", "mend the page, or what the command prints", within(book::check)).skipped_if(fast, "--fast"),
    ]
}
