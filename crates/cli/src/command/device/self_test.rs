//! `zerorate device self-test`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use zerorate_bench::board::{self, Check};
use zerorate_bench::setup::SetUp;

use super::Device;
use crate::command::Outcome;
use crate::screen::{Grid, Page};

/// Have a board test itself: port, wipers, their memory, flash, stack and interrupt
///
/// The acquisition is started anew, both axes are put off, and the wipers are moved eight taps to either side of the middle
/// one: what a tap does to the readings is held against the board's record, or the set-up where it has none. The potentiometer
/// then brings the wipers back from its own memory. It takes half a minute, wears nothing, and leaves modes, taps and
/// acquisition as they were met; group numbers begin anew. The gyros are to be plugged in and at rest.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct SelfTest {
    /// The set-up file of the board; without it the paper's
    #[arg(long, value_name = "FILE")]
    setup: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  zerorate device --port serial:/dev/ttyUSB0 self-test
  zerorate device --port serial:/dev/ttyUSB0 self-test --json > self-test.json

Exit codes: 0 nothing has failed; 1 something has, with what to do; 2 error.";

impl SelfTest {
    pub fn run(&self, device: &Device) -> Result<Outcome> {
        let setup = self.setup.as_deref().map_or_else(|| Ok(SetUp::paper()), SetUp::read)?;
        let found = device.open()?.self_test(&setup)?;
        if device.json {
            super::print_json(&found)?;
        } else {
            page(&found).print()?;
        }
        Ok(if found.passed { Outcome::Done } else { Outcome::Rejected })
    }
}

fn page(found: &board::SelfTest) -> Page {
    let mut page = Page::default();
    let unit = if found.unit_serial.is_empty() { "The board" } else { &found.unit_serial };
    page.heading(&format!("{unit} {}", if found.passed { "has passed its test" } else { "has failed its test" }));
    let mut grid = Grid::new("lrlll");
    grid.head(["", "found", "", "limits", ""]);
    for check in &found.checks {
        let number = |value: Option<f64>| value.map_or_else(String::new, told);
        let limits = match (check.least, check.most) {
            (Some(least), Some(most)) if least < most => format!("{} to {}", told(least), told(most)),
            (_, Some(most)) => told(most),
            _ => String::new(),
        };
        grid.row([&check.check, &number(check.value), check.unit, &limits, check.verdict.name()]);
    }
    page.grid(&grid);
    for Check { check, remark, .. } in &found.checks {
        if let Some(remark) = remark {
            page.sentence("  - ", &format!("{check}: {remark}"));
        }
    }
    page
}

/// A number in as many places as tell something.
fn told(value: f64) -> String {
    if value.fract().abs() < 5e-7 { format!("{value:.0}") } else { format!("{value:.2}") }
}
