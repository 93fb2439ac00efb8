//! Several boards in one chamber: a run each, with results of its own, and one that fails leaves the others running.

use std::path::PathBuf;
use std::thread;

use anyhow::{Context, Result, anyhow, bail, ensure};
use indicatif::MultiProgress;
use serde::Serialize;
use zerorate_bench::calibrated::Unit;
use zerorate_bench::choice::DeviceChoice;
use zerorate_bench::instruments::{Bench, Supply};
use zerorate_bench::output::{IN_PROGRESS, refuse_where_a_run_goes_on};
use zerorate_bench::plan::{Part, Plan};
use zerorate_bench::remote::LeftOn;
use zerorate_bench::setup::SetUp;
use zerorate_bench::shared::SharedChamber;
use zerorate_board_run::folder::SUMMARY;
use zerorate_board_run::summary::Summary;
use zerorate_cal::quality::Verdict;
use zerorate_words::sentence;

use super::real::SharedInstruments;
use super::{Bar, Calibrate, End, Run, dry_run, words};
use crate::clock::time;
use crate::command::unless_gone;
use crate::interrupt;
use crate::looking_on::LookingOnAll;
use crate::screen::{self, Grid, Page};

/// A board with its place.
struct Board<'a> {
    device: &'a DeviceChoice,
    serial: String,
    out: PathBuf,
}

impl Board<'_> {
    fn is_done(&self) -> bool {
        self.out.join(SUMMARY).is_file() && !self.out.join(IN_PROGRESS).is_dir()
    }
}

/// How the run of a board ended, as JSON has it.
#[derive(Serialize)]
struct Ended {
    serial: String,
    out: String,
    result: &'static str,
    /// What went wrong, where something did.
    message: Option<String>,
    summary: Option<Summary>,
}

#[derive(Serialize)]
struct AllEnded {
    schema: u32,
    units: Vec<Ended>,
}

impl Calibrate {
    pub(super) fn run_many(&self, devices: &[DeviceChoice], setup: &SetUp) -> Result<End> {
        if let Some(simulated) = devices.iter().find(|device| !device.is_real()) {
            bail!(
                "--device {simulated}: several boards at once are real ones; simulated units are for `zerorate study`"
            );
        }
        ensure!(self.serial.is_none(), "--serial: several boards say themselves who they are");
        let boards = self.boards(devices)?;
        boards.iter().try_for_each(|board| refuse_where_a_run_goes_on(&board.out))?;
        let mut instruments = SharedInstruments::open(self.chamber.as_ref(), &self.supplies, boards.len(), setup)?;
        instruments.found.extend(in_turns(setup, boards.len(), self.supplies.len()));
        if self.dry_run {
            let found = boards.iter().map(|board| format!("the board at {} is {}", board.device, board.serial));
            instruments.found.extend(found);
            dry_run::print(setup, dry_run::RampsOf::Real, &instruments.found, None, self.json)?;
            return Ok(End::Planned);
        }
        interrupt::watch()?;
        instruments.found.iter().for_each(|found| screen::note(found));
        let mut places: Vec<_> = boards.into_iter().zip(instruments.each(setup)?).collect();
        // What was finished before is not run again, and the others do not wait for it.
        for (board, _) in places.extract_if(.., |(board, _)| self.resume && board.is_done()) {
            screen::note(&format!("{}: was done before; its results are in {}", board.serial, board.out.display()));
        }
        ensure!(!places.is_empty(), "all boards were done before: there is nothing to go on with");
        let serials: Vec<&str> = places.iter().map(|(board, _)| board.serial.as_str()).collect();
        let (all, lives) = match &self.live {
            Some(listen) => LookingOnAll::open(listen, &serials, setup).map(|(all, lives)| (Some(all), lives))?,
            None => (None, Vec::new()),
        };
        all.iter().for_each(|all| screen::note(&all.told()));
        let lives = lives.into_iter().map(Some).chain(std::iter::repeat_with(|| None));
        let bars = MultiProgress::new();
        let ended = thread::scope(|scope| {
            let runs = places.into_iter().zip(lives).map(|((board, (chamber, supply, setup)), live)| {
                let (bars, bar) = (&bars, Bar::one_of(&bars, &board.serial));
                scope.spawn(move || {
                    let run = Run { setup: &setup, out: &board.out, live, keep: self.keep() };
                    let result = self.run_one(&board, run, chamber, supply, bar);
                    // The others go on for hours.
                    if let Err(error) = &result {
                        let told =
                            format!("{}: it ended before it was done: {}", board.serial, sentence(error.as_ref()));
                        bars.suspend(|| screen::note(&told));
                    }
                    ended(board, result)
                })
            });
            let runs: Vec<_> = runs.collect();
            runs.into_iter()
                .map(|run| run.join().map_err(|_| anyhow!("a run has panicked")))
                .collect::<Result<Vec<_>>>()
        })?;
        if let Some(all) = all {
            all.end();
        }
        self.end_with_all(ended)
    }

    /// The boards, asked who they are.
    fn boards<'a>(&self, devices: &'a [DeviceChoice]) -> Result<Vec<Board<'a>>> {
        let mut boards: Vec<Board> = Vec::new();
        for device in devices {
            let open = || device.open()?.context("a real board has a line")?.identify().map_err(anyhow::Error::from);
            let identity = open().with_context(|| format!("--device {device}"))?;
            let serial = identity.unit.as_str().to_owned();
            ensure!(
                !serial.is_empty(),
                "the board at {device} has no serial number: give it one first (firmware/README.md), for --serial is of one board"
            );
            if let Some(other) = boards.iter().find(|board| board.serial == serial) {
                bail!("the boards at {} and {device} both say that they are {serial}", other.device);
            }
            let is_plain = |letter: char| letter.is_alphanumeric() || "-_.".contains(letter);
            let folder: String = serial.chars().map(|letter| if is_plain(letter) { letter } else { '_' }).collect();
            let out = self.out.join(folder.trim_start_matches('.'));
            ensure!(
                out != self.out,
                "the board at {device} says that it is {serial}, and no folder can have that name"
            );
            boards.push(Board { device, serial, out });
        }
        Ok(boards)
    }

    fn run_one(
        &self,
        board: &Board,
        run: Run,
        chamber: SharedChamber,
        supply: Box<dyn Supply + Send>,
        bar: Bar,
    ) -> Result<Summary> {
        let device = board.device.open()?.context("a real board has a line")?;
        let (chamber, power) = (Box::new(chamber), Box::new(LeftOn));
        let mut bench = Bench { device, chamber, supply, power, clock: None, witness: None };
        self.carry_out(&mut bench, run, Unit::new(&board.serial, None)?, bar)
    }

    fn end_with_all(&self, ended: Vec<Ended>) -> Result<End> {
        let verdicts: Option<Vec<Verdict>> =
            ended.iter().map(|unit| unit.summary.as_ref().map(|summary| summary.verdict)).collect();
        let why = |unit: &Ended| Some(format!("{}: {}", unit.serial, unit.message.as_ref()?));
        let failed = ended.iter().filter_map(why).collect::<Vec<_>>().join("; ");
        let said =
            if self.json { screen::print_json(&AllEnded { schema: 1, units: ended }) } else { page(&ended).print() };
        unless_gone(said)?;
        Ok(verdicts.and_then(|verdicts| verdicts.into_iter().max()).map_or(End::NotAll(failed), End::Carried))
    }
}

/// What one supply for several boards does to the plan, which is of one.
fn in_turns(setup: &SetUp, boards: usize, supplies: usize) -> Option<String> {
    let plan = Plan::of(setup);
    let (_, took) = plan.parts.iter().find(|(part, _)| *part == Part::TrimExperiment)?;
    (supplies == 1 && boards > 1).then(|| {
        format!(
            "the supply feeds one board after the other: the trim experiments of {boards} boards take up to {} longer than the plan says",
            time(took.0 * (boards - 1) as f64)
        )
    })
}

fn ended(board: Board, result: Result<Summary>) -> Ended {
    let (serial, out) = (board.serial, board.out.display().to_string());
    match result {
        Ok(summary) => {
            let result = if summary.verdict == Verdict::Rejected { "rejected" } else { "passed" };
            Ended { serial, out, result, message: None, summary: Some(summary) }
        }
        Err(error) => {
            let result = if interrupt::was_asked_for() { "stopped" } else { "failed" };
            Ended { serial, out, result, message: Some(sentence(error.as_ref())), summary: None }
        }
    }
}

fn page(ended: &[Ended]) -> Page {
    let mut page = Page::default();
    let mut grid = Grid::new("lll");
    grid.head(["unit", "result", "report"]);
    for unit in ended {
        let report = if unit.summary.is_some() { format!("{}/report.html", unit.out) } else { "-".to_owned() };
        let result = unit.summary.as_ref().map_or(unit.result, |summary| words(summary.verdict));
        grid.row([unit.serial.as_str(), result, &report]);
    }
    page.grid(&grid);
    for (unit, message) in ended.iter().filter_map(|unit| Some((unit, unit.message.as_ref()?))) {
        page.sentence("  - ", &format!("{}: {message}", unit.serial));
    }
    page
}
