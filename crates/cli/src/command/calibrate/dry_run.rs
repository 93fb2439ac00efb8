//! `zerorate calibrate --dry-run`: the plan and the instruments, and nothing is moved.

use anyhow::Result;
use serde::Serialize;
use zerorate_bench::plan::Plan;
use zerorate_bench::setup::SetUp;

use super::schedule;
use crate::clock;
use crate::screen::{self, Grid, Page};

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

/// Prints the plan and what was found of the instruments.
pub fn print(setup: &SetUp, instruments: &[String], json: bool) -> Result<()> {
    let plan = Plan::of(setup);
    let duration_s = plan.time_from(0).0;
    if json {
        let steps = plan.parts.iter().map(|(part, time)| PlannedStep {
            step: part.to_string(),
            chamber: part.chamber(setup),
            duration_s: time.0,
        });
        return screen::print_json(&Planned {
            schema: 1,
            steps: steps.collect(),
            duration_s,
            ends: clock::stamp(duration_s),
            ramp_k_per_min: setup.ramp_rate(),
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
        grid.row([&step, &clock::time(time.0), &clock::from_now(ends), &part.chamber(setup)]);
    }
    page.grid(&grid);
    if !instruments.is_empty() {
        page.heading("Instruments");
        instruments.iter().for_each(|found| page.sentence("  - ", found));
    }
    page.gap();
    page.sentence("", "Nothing was moved, fed or recorded.");
    page.print()
}
