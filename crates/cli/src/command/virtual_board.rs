//! `zerorate virtual-board`.

use std::io::{BufRead, stdin};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread;

use anyhow::{Context, Result, ensure};
use clap::Args;
use zerorate_bench::calibrated::Unit;
use zerorate_bench::setup::SetUp;
use zerorate_virtual_board::{ListenOn, VirtualBoard};

use super::Outcome;
use crate::interrupt;
use crate::plant::Plant;
use crate::screen;

/// Serve a simulated board on a socket or a pseudo-terminal, to try the other commands without hardware
///
/// The board behaves as a real one: groups come by themselves while its acquisition runs, and nothing waits for the host.
/// The person at its chamber and supply is you: orders are lines on standard input - `chamber -40`, `feed 2.4998`, `gyros`,
/// `voltmeter`, `power` (off and on), `break stuck-x`, `byte-errors 0.001`, `mend`, `status`, `quit`. Or chamber and supply
/// obey `calibrate`, by --chamber-on and --supply-on.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Serve {
    /// Where to listen: tcp:ADDRESS:PORT (port 0: any free one), pty, or pty:NAME
    #[arg(long, value_name = "PLACE", default_value = "tcp:127.0.0.1:0")]
    on: ListenOn,

    /// Where its second line is to be listened to, on which each scan goes out, corrected; as for --on
    #[arg(long, value_name = "PLACE")]
    scans_on: Option<ListenOn>,

    /// Where its chamber is to hear Modbus, as the controller watlow-f4t does: TCP, or RTU on a pseudo-terminal; as for --on
    #[arg(long, value_name = "PLACE")]
    chamber_on: Option<ListenOn>,

    /// Where its supply and voltmeter are to hear SCPI; as for --on
    #[arg(long, value_name = "PLACE")]
    supply_on: Option<ListenOn>,

    /// The simulated board
    #[arg(long, value_enum, default_value_t = Plant::Paper)]
    plant: Plant,

    /// The seed that everything in it is drawn from
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// How many times faster than the wall clock its time runs, the chamber's too
    #[arg(long, value_name = "X", default_value_t = 1.0)]
    speed: f64,

    /// The set-up file of the board; without it the plant's own (see `zerorate setup`)
    #[arg(long, value_name = "FILE")]
    setup: Option<PathBuf>,

    /// The unit's serial number, up to 32 bytes
    #[arg(long, value_name = "S", default_value = "ZR-0001")]
    serial: String,

    /// So many boards in one chamber, the first one's: each is a unit of its own (the seed and those after it, the serial with -1, -2
    /// and so on), has a supply of its own, and listens on a port of its own, which is told
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=64))]
    boards: u16,
}

const EXAMPLES: &str = "\
Examples:
  zerorate virtual-board --on tcp:127.0.0.1:5494
  zerorate device --port tcp:127.0.0.1:5494 monitor        in another terminal
  zerorate virtual-board --on tcp:127.0.0.1:5494 --scans-on tcp:127.0.0.1:5495
  zerorate device --port tcp:127.0.0.1:5495 stream
  zerorate virtual-board --on pty:/tmp/board --speed 60
  zerorate calibrate --device serial:/tmp/board            a chamber that you turn by hand, an hour a minute
  zerorate virtual-board --on tcp:127.0.0.1:5494 --chamber-on tcp:127.0.0.1:5502 --supply-on tcp:127.0.0.1:5025 --speed 60
  zerorate calibrate --device tcp:127.0.0.1:5494 --chamber modbus-tcp:127.0.0.1:5502 --supply scpi:127.0.0.1:5025 \\
      --setup night.toml
      nobody at the bench; [chamber.controller] preset = \"watlow-f4t\" is in night.toml";

/// What is told of a board that listens: a line each.
type Listening = Result<Vec<String>>;

impl Serve {
    pub fn run(&self) -> Result<Outcome> {
        ensure!(
            self.speed.is_finite() && (0.01..=100_000.0).contains(&self.speed),
            "--speed {}: give a number from 0.01 to 100000",
            self.speed
        );
        ensure!(
            self.boards == 1 || self.scans_on.is_none() && matches!(self.on, ListenOn::Tcp(_)),
            "--boards {}: each listens by TCP, and none has a second line",
            self.boards
        );
        let kind = self.plant.kind();
        let setup = self.setup.as_deref().map_or_else(|| Ok(kind.setup()), SetUp::read)?;
        interrupt::watch()?;
        let (tell, orders) = mpsc::channel();
        thread::spawn(move || {
            for line in stdin().lock().lines().map_while(Result::ok) {
                if tell.send(line).is_err() {
                    break;
                }
            }
        });
        let is_over = AtomicBool::new(false);
        thread::scope(|scope| {
            let mut beside = Vec::new();
            let mut listening = Vec::new();
            for number in 1..self.boards {
                let ((tell, orders), (say, said)) = (mpsc::channel(), mpsc::channel());
                beside.push(tell);
                listening.push(said);
                let (setup, is_over) = (&setup, &is_over);
                scope.spawn(move || {
                    let go_on = || !is_over.load(Ordering::Relaxed) && !interrupt::was_asked_for();
                    match self.board(number, setup) {
                        Ok((mut board, told)) => {
                            let _ = say.send(Ok(told));
                            let _ = board.serve(&orders, |_| (), go_on);
                        }
                        Err(error) => drop(say.send(Err(error))),
                    }
                });
            }
            let result = self.first(&setup, &orders, beside, &listening);
            is_over.store(true, Ordering::Relaxed);
            result
        })?;
        Ok(Outcome::Done)
    }

    /// The board to which orders are given, and in whose chamber the others stand.
    fn first(
        &self,
        setup: &SetUp,
        orders: &Receiver<String>,
        beside: Vec<Sender<String>>,
        listening: &[Receiver<Listening>],
    ) -> Result<()> {
        let (mut board, mut told) = self.board(0, setup)?;
        board.share_chamber(beside);
        for said in listening {
            told.extend(said.recv().context("a board has ended before it began")??);
        }
        told.iter().try_for_each(|line| screen::print(&format!("{line}\n")))?;
        let answer = |text: &str| {
            // Whoever closed the pipe does not want to know.
            let _ = screen::print(&format!("{text}\n"));
        };
        board.serve(orders, answer, || !interrupt::was_asked_for()).context("the socket failed")
    }

    /// A board that listens, by its number; what is told of it.
    fn board(&self, number: u16, setup: &SetUp) -> Result<(VirtualBoard, Vec<String>)> {
        let serial = if self.boards > 1 { format!("{}-{}", self.serial, number + 1) } else { self.serial.clone() };
        let unit = Unit::new(&serial, None)?;
        let on = |on: &ListenOn| if number == 0 { on.clone() } else { on.at_any_port() };
        let plant = self.plant.kind().build(self.seed + u64::from(number));
        let mut board = VirtualBoard::new(plant, setup, &unit.serial, &on(&self.on), self.speed)
            .with_context(|| format!("--on {}: cannot listen there", self.on))?;
        let mut told = vec![format!("board {serial} listens on {}", board.address())];
        if let Some(on) = &self.scans_on {
            let place = board.send_scans(on).with_context(|| format!("--scans-on {on}: cannot listen there"))?;
            told.push(format!("its scans go out on {place}"));
        }
        // All stand in the first one's chamber.
        if let Some(on) = self.chamber_on.as_ref().filter(|_| number == 0) {
            let place = board.remote_chamber(on).with_context(|| format!("--chamber-on {on}: cannot listen there"))?;
            told.push(format!("its chamber hears {place}"));
        }
        if let Some(place) = &self.supply_on {
            let place = on(place);
            let place =
                board.remote_supply(&place).with_context(|| format!("--supply-on {place}: cannot listen there"))?;
            told.push(format!("its supply hears {place}"));
        }
        Ok((board, told))
    }
}
