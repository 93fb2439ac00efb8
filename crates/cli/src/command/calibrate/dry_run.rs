//! `zerorate calibrate --dry-run`: the plan and the instruments, and nothing is moved.

use std::path::Path;

use anyhow::Result;
use serde::Serialize;
use zerorate_bench::calibrated::Unit;
use zerorate_bench::output::IN_PROGRESS;
use zerorate_bench::plan::Plan;
use zerorate_bench::plants::PlantKind;
use zerorate_bench::setup::SetUp;

use super::schedule;
use crate::clock;
use crate::screen::{self, Grid, Page};

/// Whose ramps they are.
#[derive(Debug, Clone, Copy)]
pub enum RampsOf {
    /// Of the chamber of a simulated plant, which goes as fast as it goes.
    Simulated(PlantKind),
    /// Of a real one, which somebody sets to the set-up's rate.
    Real,
}

impl RampsOf {
    /// Whose the ramps of a unit are.
    pub fn unit(unit: &Unit) -> Self {
        unit.plant.map_or(Self::Real, |(kind, _)| Self::Simulated(kind))
    }

    /// How fast they are, kelvins a minute.
    pub fn k_per_min(self, setup: &SetUp) -> f64 {
        match self {
            Self::Simulated(kind) => kind.chamber_k_per_min(),
            Self::Real => setup.ramp_rate(),
        }
    }

    fn told(self, setup: &SetUp) -> String {
        let (rate, own) = (self.k_per_min(setup), setup.ramp_rate());
        match self {
            Self::Simulated(_) => format!(
                "The simulated chamber goes at {rate:.1} K/min, whatever the set-up's ramps take, and stays at their end for what is left of them."
            ),
            Self::Real => format!(
                "The chamber is sent to the end of a ramp at once: set its controller's own ramp rate to {own:.1} K/min, the way in the time of chamber.ramp_groups."
            ),
        }
    }
}

/// The plan as JSON has it.
#[derive(Serialize)]
struct Planned<'a> {
    schema: u32,
    steps: Vec<PlannedStep>,
    duration_s: f64,
    ends: String,
    ramp_k_per_min: f64,
    instruments: &'a [String],
}

#[derive(Serialize)]
struct PlannedStep {
    step: String,
    chamber: String,
    duration_s: f64,
}

/// What is to be known of a run in a folder that was stopped.
pub fn stopped(out: &Path, resume: bool) -> Option<String> {
    let is_there = out.join(IN_PROGRESS).is_dir();
    let words = match resume {
        true => "this is the plan of a whole run: what the one that was stopped has done is left out when it goes on",
        false => {
            "a run was stopped here, and none begins over it: go on with that one (--resume), or give another --out"
        }
    };
    is_there.then(|| format!("{}: {words}.", out.display()))
}

/// Prints the plan of a whole run, what was found of the instruments, and what there is of a run that was stopped.
pub fn print(setup: &SetUp, chamber: RampsOf, instruments: &[String], stopped: Option<&str>, json: bool) -> Result<()> {
    let plan = Plan::of(setup);
    let rate = chamber.k_per_min(setup);
    let duration_s = plan.time_from(0).0;
    if json {
        let steps = plan.parts.iter().map(|(part, time)| PlannedStep {
            step: part.to_string(),
            chamber: part.chamber(setup, rate),
            duration_s: time.0,
        });
        return screen::print_json(&Planned {
            schema: 1,
            steps: steps.collect(),
            duration_s,
            ends: clock::stamp(duration_s),
            ramp_k_per_min: rate,
            instruments,
        });
    }
    let mut page = Page::default();
    page.sentence("", &schedule::head(&plan));
    page.gap();
    let mut grid = Grid::new("lrll");
    grid.head(["step", "about", "ends about", "chamber"]);
    for (place, (part, time)) in plan.parts.iter().enumerate() {
        let step = format!("{}. {part}", place + 1);
        let ends = duration_s - plan.time_from(place + 1).0;
        grid.row([&step, &clock::time(time.0), &clock::from_now(ends), &part.chamber(setup, rate)]);
    }
    page.grid(&grid);
    if !instruments.is_empty() {
        page.heading("Instruments");
        instruments.iter().for_each(|found| page.sentence("  - ", found));
    }
    page.gap();
    if let Some(stopped) = stopped {
        page.sentence("", stopped);
    }
    page.sentence("", &chamber.told(setup));
    page.sentence("", "Nothing was moved, fed or recorded.");
    page.print()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_that_was_stopped_is_told_with_its_plan() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(stopped(folder.path(), true), None);
        std::fs::create_dir(folder.path().join(IN_PROGRESS)).unwrap();
        assert!(stopped(folder.path(), true).unwrap().contains("the plan of a whole run"));
        assert!(stopped(folder.path(), false).unwrap().contains("go on with that one (--resume)"));
    }
}
