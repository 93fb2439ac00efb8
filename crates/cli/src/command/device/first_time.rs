//! `zerorate device first-time`.

use std::io::{BufRead, IsTerminal, stdin};
use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Result, bail};
use clap::Args;
use serde::Serialize;
use zerorate_bench::board::{self, MOST_STORES, Recalled};
use zerorate_bench::setup::SetUp;

use super::Device;
use crate::command::Outcome;
use crate::screen::{self, Page};

/// How long a person may take to switch a board off and on.
const POWER_CYCLE: Duration = Duration::from_secs(300);

/// Set up a new board once: make the middle tap that of power-up, and check it
///
/// The potentiometer keeps the tap in a non-volatile register that wears, so this is asked for, and no other command does
/// it. The part cannot be read back. So its wipers are moved eight taps away, and the part is told to bring them back from
/// that register: then the readings must be what they were. With --power-cycle that is done once more after the board was
/// switched off and on. A board that starts writes its wipers itself, so its readings alone would say nothing of the register.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct FirstTime {
    /// Do not ask whether to
    #[arg(long)]
    yes: bool,

    /// Wait until the board was switched off and on, and recall the tap once more
    #[arg(long)]
    power_cycle: bool,

    /// The set-up file of the board; without it the paper's (its middle tap is 511)
    #[arg(long, value_name = "FILE")]
    setup: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  zerorate device --port serial:/dev/ttyUSB0 first-time
  zerorate device --port serial:/dev/ttyUSB0 first-time --yes --power-cycle";

/// What was checked, as JSON has it.
#[derive(Serialize)]
struct Checked<'a> {
    #[serde(flatten)]
    found: &'a board::FirstTime,
    fault: Option<&'static str>,
}

impl FirstTime {
    pub fn run(&self, device: &Device) -> Result<Outcome> {
        let setup = self.setup.as_deref().map_or_else(|| Ok(SetUp::paper()), SetUp::read)?;
        let tap = setup.middle();
        let mut board = device.open()?;
        if !self.yes && !agreed(board.serial(), tap.get())? {
            screen::note("nothing was stored");
            return Ok(Outcome::Done);
        }
        let mut found = board.store_power_up_tap(tap, &setup)?;
        if self.power_cycle {
            screen::note("switch gyros and board off, and on again");
            let go_on = || Ok::<(), anyhow::Error>(());
            board.check_after_power_cycle(&mut found, &setup, POWER_CYCLE, go_on)?;
        }
        if device.json {
            super::print_json(&Checked { found: &found, fault: found.fault() })?;
        } else {
            self.page(&found).print()?;
        }
        Ok(if found.fault().is_none() { Outcome::Done } else { Outcome::Rejected })
    }

    fn page(&self, found: &board::FirstTime) -> Page {
        let mut page = Page::default();
        let is = if found.fault().is_none() {
            "is stored for power-up on both axes"
        } else {
            "was to be stored for power-up"
        };
        page.line(format!("Tap {} {is}", found.tap));
        let counts = |[x, y]: [f64; 2]| format!("X {x:.1}, Y {y:.1} counts");
        let recalled =
            |found: &Recalled| format!("{}; moved away {}", counts(found.recalled_counts), counts(found.away_counts));
        page.facts(&[
            ("readings", counts(found.before_counts)),
            ("recalled", recalled(&found.recalled)),
            (
                "after power-up",
                found.after_power_up.as_ref().map_or_else(|| "not checked: --power-cycle does".into(), recalled),
            ),
        ]);
        if let Some(fault) = found.fault() {
            page.sentence("  - ", fault);
        }
        page
    }
}

fn agreed(unit: &str, tap: u16) -> Result<bool> {
    let unit = if unit.is_empty() { "this board" } else { unit };
    if !stdin().is_terminal() {
        bail!(
            "this stores tap {tap} in a register of {unit} that wears ({MOST_STORES} stores): say --yes to do it without being asked"
        );
    }
    screen::note(&format!(
        "this stores tap {tap} in the potentiometer's non-volatile register of {unit}, which bears {MOST_STORES} stores. \
         Type yes to do it:"
    ));
    let mut answer = String::new();
    stdin().lock().read_line(&mut answer)?;
    Ok(matches!(answer.trim(), "yes" | "y"))
}
