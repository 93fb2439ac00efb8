//! `zerorate device monitor`.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::Result;
use clap::Args;
use console::Term;
use serde_json::{Value, json};
use zerorate_bench::board::{Board, LiveAxis, LiveGroup};
use zerorate_bench::client::ClientError;
use zerorate_bench::setup::SetUp;
use zerorate_live::Listen;
use zerorate_report::{LiveRun, RunGroup};

use super::Device;
use crate::command::Outcome;
use crate::interrupt;
use crate::looking_on::{self, LookingOn};
use crate::screen::{self, Grid};

/// How often Ctrl-C is looked for while no group comes.
const LOOK_EVERY: Duration = Duration::from_millis(200);
/// Groups between two looks at the fault counters.
const FAULTS_EVERY: u32 = 10;

/// Show the groups of the board as they come: means, temperature, rate, taps, modes, faults
///
/// On a terminal a table that renews itself; otherwise a line for each group and axis, or with --json an object for each
/// group, which has the temperature in counts as well. Degrees C are by the set-up's scale, and a part's own is some degrees
/// off. The acquisition is started if it stands still, and stopped again at the end. Ctrl-C ends it.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Monitor {
    /// End after so many groups
    #[arg(long, value_name = "N")]
    groups: Option<u32>,

    /// The set-up file of the board, for the scales of temperature and rate and for the centre; without it the paper's
    #[arg(long, value_name = "FILE")]
    setup: Option<PathBuf>,

    /// Serve a page that shows the groups as they come: at 127.0.0.1:5495, or ADDRESS:PORT of this machine (port 0: any free
    /// one). Beyond this machine its address has a token in it, which it prints
    #[arg(long, value_name = "ADDRESS:PORT", num_args = 0..=1, default_missing_value = looking_on::HERE)]
    live: Option<Listen>,
}

const EXAMPLES: &str = "\
Examples:
  zerorate device --port serial:/dev/ttyUSB0 monitor
  zerorate device --port tcp:bench-3:5494 monitor --groups 40 --json > groups.jsonl
  zerorate device --port serial:/dev/ttyUSB0 monitor --live";

impl Monitor {
    pub fn run(&self, device: &Device) -> Result<Outcome> {
        let setup = self.setup.as_deref().map_or_else(|| Ok(SetUp::paper()), SetUp::read)?;
        let mut board = device.open()?;
        interrupt::watch()?;
        let live =
            self.live.as_ref().map(|listen| LookingOn::open(listen, "Groups as they come", &setup)).transpose()?;
        if let Some(live) = &live {
            screen::note(&live.told());
        }
        if board.watch()? {
            screen::note("the acquisition stood still: started, and stopped again at the end");
        }
        let mut view = View::new(device.json);
        let shown = self.show(&mut board, &setup, &mut view, live.as_ref());
        if let Some(live) = live {
            live.end("The monitor has ended.".into());
        }
        // A board that does not answer any more cannot be taken leave of.
        if !shown.as_ref().is_err_and(|error| error.is::<ClientError>()) {
            board.leave()?;
        }
        let shown = shown?;
        let line = board.line();
        if line.damaged_frames > 0 {
            screen::note(&format!("{} damaged frames, {} commands sent again", line.damaged_frames, line.sent_again));
        }
        if shown == 0 && !interrupt::was_asked_for() {
            screen::note("no group came");
        }
        Ok(Outcome::Done)
    }

    fn show(&self, board: &mut Board, setup: &SetUp, view: &mut View, live: Option<&LookingOn>) -> Result<u32> {
        let late = board.group_period() * 3 + Duration::from_secs(4);
        let mut shown = 0;
        let mut waited = Duration::ZERO;
        let mut before = None;
        while self.groups.is_none_or(|groups| shown < groups) && !interrupt::was_asked_for() {
            let Some(group) = board.next_live(LOOK_EVERY, setup)? else {
                waited += LOOK_EVERY;
                anyhow::ensure!(waited < late, "the board answers and sends no groups: did its acquisition stop?");
                continue;
            };
            waited = Duration::ZERO;
            for lost in board.device.take_lost_groups() {
                let (first, last) = lost.into_inner();
                let which = if first == last { format!("group {first}") } else { format!("groups {first} to {last}") };
                screen::note(&format!("{which} did not arrive"));
                // The note stands; the table goes on below it.
                view.lines = 0;
            }
            if shown % FAULTS_EVERY == 0 {
                let faults = serde_json::to_value(board.faults()?)?;
                if before.as_ref().is_some_and(|before| *before != faults) && !view.is_table() {
                    screen::note(&format!("faults: {}", counters(&faults)));
                }
                view.faults = counters(&faults);
                before = Some(faults);
            }
            view.show(&group)?;
            if let Some(live) = live {
                let time_s = board.group_period().as_secs_f64() * f64::from(group.group);
                live.change(|run| look_on(run, &group, time_s));
            }
            shown += 1;
        }
        Ok(shown)
    }
}

/// Shows a group to those who look on.
fn look_on(run: &mut LiveRun, group: &LiveGroup, time_s: f64) {
    run.heard_at = looking_on::clock();
    for (own, axis) in run.axes.iter_mut().zip(&group.axes) {
        own.push(RunGroup {
            time_s,
            temperature_counts: axis.temperature_counts,
            reading_counts: axis.corrected_counts,
            // What the chamber does is not known here.
            is_ramp: false,
            is_compensated: axis.mode != zerorate_bench::board::Mode::Off.name(),
        });
    }
    run.doing = format!("group {}, {} lost", group.group, group.lost);
}

/// The counters that are not 0.
fn counters(faults: &Value) -> String {
    let counted = faults.as_object().into_iter().flatten().filter(|(_, count)| **count != json!(0));
    let told: Vec<String> = counted.map(|(name, count)| format!("{} {count}", name.replace('_', " "))).collect();
    if told.is_empty() { "none".into() } else { told.join(", ") }
}

/// Where groups are shown.
struct View {
    json: bool,
    terminal: Option<Term>,
    lines: usize,
    faults: String,
}

impl View {
    fn new(json: bool) -> Self {
        let terminal = Some(Term::stdout()).filter(|terminal| terminal.is_term() && !json);
        Self { json, terminal, lines: 0, faults: "none".into() }
    }

    const fn is_table(&self) -> bool {
        self.terminal.is_some()
    }

    fn show(&mut self, group: &LiveGroup) -> Result<()> {
        if self.json {
            return screen::print(&(serde_json::to_string(group)? + "\n"));
        }
        let Some(terminal) = &self.terminal else {
            return group.axes.iter().try_for_each(|axis| screen::print(&(line(group.group, axis) + "\n")));
        };
        let mut grid = Grid::new("lrrrrrll");
        grid.head(["", "temperature", "reading", "corrected", "rate", "", "", ""]);
        grid.head(["axis", "C", "counts", "counts", "deg/s", "tap", "mode", ""]);
        group.axes.iter().for_each(|axis| grid.row(cells(axis)));
        let mut lines = vec![format!("Group {}, {} lost; faults: {}", group.group, group.lost, self.faults)];
        lines.extend(grid.lines());
        terminal.clear_last_lines(self.lines)?;
        lines.iter().try_for_each(|line| terminal.write_line(line))?;
        self.lines = lines.len();
        Ok(())
    }
}

fn cells(axis: &LiveAxis) -> [String; 8] {
    let tap = axis.moved_to.map_or_else(|| axis.tap.to_string(), |to| format!("{} > {to}", axis.tap));
    [
        axis.axis.to_uppercase(),
        format!("{:.2}", axis.temperature_c),
        format!("{:.2}", axis.zro_counts),
        format!("{:.2}", axis.corrected_counts),
        format!("{:+.3}", axis.rate_dps),
        tap,
        axis.mode.to_owned(),
        axis.flags.join(" "),
    ]
}

fn line(group: u32, axis: &LiveAxis) -> String {
    let moved = axis.moved_to.map(|to| format!(" moved_to={to}")).unwrap_or_default();
    let flags = if axis.flags.is_empty() { String::new() } else { format!(" {}", axis.flags.join(" ")) };
    format!(
        "group={group} axis={} temperature_c={:.2} reading={:.2} corrected={:.2} rate_dps={:+.3} tap={} mode={}{moved}{flags}",
        axis.axis, axis.temperature_c, axis.zro_counts, axis.corrected_counts, axis.rate_dps, axis.tap, axis.mode
    )
}
