//! `zerorate units`.

mod found;
mod report;

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Args;
use serde::Serialize;
use zerorate_cal::quality::Verdict;
use zerorate_report::UnitsReport;
use zerorate_report::number::counted;

use self::found::{AxisOfRun, Run, Unit, units};
use super::Outcome;
use crate::output;
use crate::progress::Busy;
use crate::screen::{self, Grid, Page};

/// List the units whose results lie in a folder: their last calibration, what it left, what has changed since the one before
///
/// Every folder beneath it that a run of `calibrate` has left is one calibration; those of one serial number are one unit's, in
/// the order in which they were made; of a simulated one, every plant and seed is a unit. What has changed is the largest
/// distance between the fitted curves of a calibration and of the one before, over the temperatures of both. Nothing is written but the page of `--report`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Units {
    /// Where the results lie, at whatever depth
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,

    /// Only units whose serial number has this in it, with all of their calibrations
    #[arg(long, value_name = "PART")]
    serial: Option<String>,

    /// Write a page with all calibrations here, and a figure of what has changed of the units that have more than one
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,

    #[command(flatten)]
    force: output::Force,

    /// Print JSON on standard output, and nothing else there
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  zerorate calibrate --device serial:/dev/ttyUSB0 --setup bench.toml --out units/ZR-0042/2026-11-27
  zerorate units units
  zerorate units units --serial ZR-0042
  zerorate units units --report units.html

Exit codes: 0 done; 2 something could not be read, or there is nothing.";

/// All of them, as JSON has them.
#[derive(Debug, Serialize)]
struct Report {
    schema: u32,
    units: Vec<Unit>,
    unreadable: Vec<String>,
}

impl Units {
    pub fn run(&self) -> Result<Outcome> {
        if let Some(path) = &self.report {
            output::check("--report", path, &[])?;
        }
        let busy = Busy::reading(&self.folder);
        let found = units(&self.folder);
        drop(busy);
        let (mut units, unreadable) = found?;
        if let Some(part) = &self.serial {
            units.retain(|unit| unit.serial.contains(part));
        }
        if units.is_empty() && unreadable.is_empty() {
            let whose = self.serial.as_ref().map(|part| format!(" of a unit with {part} in its serial number"));
            bail!("{}: no results of a calibration lie here{}", self.folder.display(), whose.unwrap_or_default());
        }
        let outcome = if unreadable.is_empty() { Outcome::Done } else { Outcome::Failed };
        unreadable.iter().for_each(|sentence| screen::note(sentence));
        if let Some(path) = &self.report {
            let folder = self.folder.display().to_string();
            let is_one = |page: &str| UnitsReport::is_page_of(page, &folder);
            self.force.page("--report", path, "the page of these units", is_one)?;
            output::write(path, &report::of(&folder, &units, &unreadable).to_html())?;
        }
        if self.json {
            screen::print_json(&Report { schema: 1, units, unreadable })?;
        } else {
            self.page(&units).print()?;
        }
        Ok(outcome)
    }

    fn page(&self, units: &[Unit]) -> Page {
        let mut page = Page::default();
        let runs: usize = units.iter().map(|unit| unit.runs.len()).sum();
        let last = || units.iter().filter_map(|unit| unit.runs.last());
        let rejected = last().filter(|run| run.verdict == Verdict::Rejected).count();
        page.sentence(
            "",
            &format!(
                "{}: {}, {}; {rejected} rejected by the last",
                self.folder.display(),
                counted(units.len(), "unit"),
                counted(runs, "calibration")
            ),
        );
        page.gap();
        let mut grid = Grid::new("lrllrrrr");
        grid.head(["", "", "", "", "drift", "trim left", "hybrid left", "changed"]);
        let of_a_unit = if self.serial.is_some() { "calibration" } else { "of" };
        grid.head(["serial", of_a_unit, "made, UTC", "verdict", "X / Y", "X / Y", "X / Y", "X / Y"]);
        for unit in units {
            let shown = if self.serial.is_some() { 0 } else { unit.runs.len() - 1 };
            for (place, run) in unit.runs.iter().enumerate().skip(shown) {
                grid.row(cells(unit, place, run));
            }
        }
        page.grid(&grid);
        page.gap();
        page.sentence("", "Counts peak to peak over a heating ramp; changed: the curve's largest distance from the calibration before, counts.");
        if let Some(path) = &self.report {
            page.sentence("", &format!("Wrote {}.", path.display()));
        }
        page
    }
}

fn cells(unit: &Unit, place: usize, run: &Run) -> [String; 8] {
    let pair = |of: fn(&AxisOfRun) -> Option<f64>| {
        let told = run.axes.values().map(|axis| of(axis).map_or_else(|| "-".to_owned(), |value| format!("{value:.1}")));
        told.collect::<Vec<_>>().join(" / ")
    };
    [
        unit.name(),
        (place + 1).to_string(),
        run.made(),
        run.verdict.name().to_owned(),
        pair(|axis| Some(axis.drift_pp_counts)),
        pair(|axis| axis.trim_residual_pp_counts),
        pair(|axis| axis.hybrid_residual_pp_counts),
        pair(|axis| axis.change_counts),
    ]
}
