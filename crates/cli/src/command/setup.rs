//! `zerorate setup`.

mod fields;

use std::path::PathBuf;

use anyhow::{Error, Result};
use clap::Args;
use serde::Serialize;
use zerorate_bench::setup::{ControllerTable, SetUp, SupplyTable};

use super::Outcome;
use crate::labels;
use crate::plant::Plant;
use crate::screen::{self, Page};

/// Print a set-up file, or check one
///
/// A set-up is one TOML file that describes a board and its bench: the A/D, the trim part, how groups are taken, the
/// chamber's profile, what a unit must pass. The paper's is the default; a file needs only what differs from it.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Setup {
    /// Whose set-up to print: the paper's board, or the same bench for units whose drift is not known beforehand
    #[arg(long, value_enum, default_value_t = Plant::Paper, conflicts_with = "check")]
    plant: Plant,

    /// Print it with the tables of a chamber's controller and a supply for remote control: eurotherm, watlow-f4t, binder, espec or
    /// own
    #[arg(long, value_name = "PRESET", conflicts_with = "check")]
    controller: Option<String>,

    /// Check a set-up file and say in what it differs from the paper's
    #[arg(long, value_name = "FILE")]
    check: Option<PathBuf>,

    /// Print JSON on standard output, and nothing else there
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  zerorate setup > bench.toml           then edit it
  zerorate setup --controller watlow-f4t > night.toml
                                        the same for a chamber and a supply by remote control
  zerorate setup --check bench.toml";

/// What a set-up file was found to be, as JSON has it.
#[derive(Serialize)]
struct Checked<'a> {
    schema: u32,
    file: &'a std::path::Path,
    sound: bool,
    unreachable: Vec<String>,
    doubtful_labels: Vec<String>,
    differences: Vec<fields::Difference>,
}

impl Setup {
    pub fn run(&self) -> Result<Outcome> {
        match &self.check {
            Some(file) => self.check(file)?,
            None if self.json => screen::print_json(&self.setup()?)?,
            None => screen::print(&fields::commented(&self.setup()?)?)?,
        }
        Ok(Outcome::Done)
    }

    fn setup(&self) -> Result<SetUp> {
        let mut setup = self.plant.kind().setup();
        if let Some(preset) = &self.controller {
            setup.chamber.controller = Some(ControllerTable::whole(preset).map_err(Error::msg)?);
            setup.supply = Some(SupplyTable::default());
        }
        Ok(setup)
    }

    fn check(&self, file: &std::path::Path) -> Result<()> {
        let setup = SetUp::read(file)?;
        let (differences, unreachable) = (fields::differences(&setup)?, setup.unreachable());
        let doubtful_labels = labels::doubts(&setup.labels);
        if self.json {
            let checked = Checked { schema: 1, file, sound: true, unreachable, doubtful_labels, differences };
            return screen::print_json(&checked);
        }
        let mut page = Page::default();
        let found = if unreachable.is_empty() {
            "sound"
        } else {
            "nothing in it contradicts itself, but few units or chambers can do what it asks, if any"
        };
        if differences.is_empty() {
            page.sentence("", &format!("{}: {found}, and the same as the paper's.", file.display()));
        } else {
            page.sentence("", &format!("{}: {found}. It differs from the paper's in", file.display()));
            let mut grid = screen::Grid::new("lll");
            grid.head(["field", "here", "paper"]);
            for difference in &differences {
                grid.row([&difference.field, &difference.here, &difference.paper]);
            }
            page.grid(&grid);
        }
        if !unreachable.is_empty() {
            page.heading("Few can do, if any");
            unreachable.iter().for_each(|sentence| page.sentence("  - ", sentence));
        }
        if !doubtful_labels.is_empty() {
            page.heading("To look at");
            doubtful_labels.iter().for_each(|sentence| page.sentence("  - ", sentence));
        }
        page.print()
    }
}
