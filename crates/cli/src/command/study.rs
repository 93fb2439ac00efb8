//! `zerorate study`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use zerorate_bench::board::Mode;
use zerorate_bench::setup::SetUp;
use zerorate_bench::study::{self, Quantiles, UnitRejected, UnitResult};
use zerorate_report::number::counted;

use super::Outcome;
use crate::plant::Plant;
use crate::screen;
use crate::screen::{Grid, Page};

/// Take many random units through the experiment: what a design achieves, before a board is built
///
/// Each unit is drawn from the seed, characterised on a ramp, trimmed, and tested on a second ramp: its X axis, heating,
/// by the potentiometer alone and with the rest subtracted in numbers. It says how many units meet the limits of the set-up.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Study {
    /// How many units
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..))]
    units: u32,

    /// The simulated board
    #[arg(long, value_enum, default_value_t = Plant::Typical)]
    plant: Plant,

    /// The seed that the units are drawn from
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// The set-up file of board and bench; without it the plant's own (see `zerorate setup`)
    #[arg(long, value_name = "FILE")]
    setup: Option<PathBuf>,

    /// Print JSON on standard output, and nothing else there
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  zerorate study --units 100
  zerorate study --units 100 --plant paper --json > study.json
  zerorate setup --plant typical > bench.toml; zerorate study --setup bench.toml
      what a wider dead band, shorter groups, another drift model would do";

/// A study as JSON has it.
#[derive(Serialize)]
struct Results<'a> {
    schema: u32,
    units: u32,
    plant: &'static str,
    seed: u64,
    results: Vec<&'a UnitResult>,
    rejected: Vec<&'a UnitRejected>,
    within_limits: usize,
    quantiles: Quantiles,
}

impl Study {
    pub fn run(&self) -> Result<Outcome> {
        let kind = self.plant.kind();
        let setup = match &self.setup {
            Some(file) => SetUp::read(file)?,
            None => kind.setup(),
        };
        let bar = ProgressBar::new(u64::from(self.units));
        if let Ok(style) = ProgressStyle::with_template("unit {pos} of {len} {bar:30} {elapsed} gone, {eta} left") {
            bar.set_style(style);
        }
        let units = study::run(self.units, kind, self.seed, &setup, &|| bar.inc(1));
        bar.finish_and_clear();
        let results: Vec<&UnitResult> = units.iter().filter_map(|unit| unit.as_ref().ok()).collect();
        let rejected: Vec<&UnitRejected> = units.iter().filter_map(|unit| unit.as_ref().err()).collect();
        let quantiles = Quantiles::of(&results);
        let within_limits = results.iter().filter(|unit| unit.failed_checks.is_empty()).count();
        if self.json {
            let (units, plant, seed) = (self.units, kind.name(), self.seed);
            screen::print_json(&Results {
                schema: 1,
                units,
                plant,
                seed,
                results,
                rejected,
                within_limits,
                quantiles,
            })?;
        } else {
            page(&results, &rejected, within_limits, &quantiles, kind.name()).print()?;
        }
        Ok(Outcome::Done)
    }
}

fn page(
    results: &[&UnitResult],
    rejected: &[&UnitRejected],
    within_limits: usize,
    quantiles: &Quantiles,
    plant: &str,
) -> Page {
    let mut page = Page::default();
    let units = results.len() + rejected.len();
    page.sentence(
        "",
        &format!(
            "{within_limits} of {} {} the limits of the set-up on the X axis, which alone is tested.",
            counted(units, "unit"),
            if within_limits == 1 { "meets" } else { "meet" }
        ),
    );
    page.gap();
    page.line(format!("{} {plant} units, X axis, heating; counts peak to peak over the ramp, held out", results.len()));
    page.gap();
    let mut grid = Grid::new("rrrrrr");
    grid.head(["part of units", "drift", "trim leaves", "hybrid leaves", "floor", "hybrid/floor"]);
    for (index, part) in quantiles.at.iter().enumerate() {
        let cell = |values: &[f64]| values.get(index).map_or_else(|| "-".into(), |value| format!("{value:.1}"));
        grid.row([
            format!("{:.0} %", part * 100.0),
            cell(&quantiles.drift_pp_counts),
            cell(&quantiles.trim_residual_pp_counts),
            cell(&quantiles.hybrid_residual_pp_counts),
            cell(&quantiles.floor_pp_counts),
            cell(&quantiles.hybrid_residual_floors),
        ]);
    }
    page.grid(&grid);
    let no_wiper = results.iter().filter(|result| result.mode == Mode::Digital);
    let left: Vec<f64> = no_wiper.map(|result| result.hybrid_residual_pp_counts).collect();
    if !left.is_empty() {
        let (least, most) = left.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), left| (a.min(*left), b.max(*left)));
        page.gap();
        page.sentence(
            "",
            &format!(
                "In {} the drift needs more taps than the law can hold, and numbers alone leave {least:.1} to {most:.1} counts: they are in no row of trim and hybrid.",
                left.len()
            ),
        );
    }
    let outside = || results.iter().filter(|unit| !unit.failed_checks.is_empty());
    if outside().next().is_some() {
        page.heading("Outside the limits");
        outside().for_each(|unit| {
            page.sentence("  - ", &format!("unit {}: {}", unit.unit, unit.failed_checks.join("; ")));
        });
    }
    let warned = || results.iter().filter(|unit| !unit.warnings.is_empty());
    if warned().next().is_some() {
        page.heading("To look at");
        warned().for_each(|unit| page.sentence("  - ", &format!("unit {}: {}", unit.unit, unit.warnings.join("; "))));
    }
    if !rejected.is_empty() {
        page.heading("Rejected, and in no row above");
        rejected.iter().for_each(|unit| page.sentence("  - ", &format!("unit {}: {}", unit.unit, unit.reason)));
    }
    page
}
