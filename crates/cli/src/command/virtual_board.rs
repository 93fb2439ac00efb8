//! `zerorate virtual-board`.

use std::io::{BufRead, stdin};
use std::path::PathBuf;
use std::sync::mpsc;
use std::thread;

use anyhow::{Context, Result, ensure};
use clap::Args;
use zerorate_bench::calibrated::Unit;
use zerorate_bench::setup::SetUp;
use zerorate_bench::virtual_board::{ListenOn, VirtualBoard};

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

impl Serve {
    pub fn run(&self) -> Result<Outcome> {
        ensure!(
            self.speed.is_finite() && (0.01..=100_000.0).contains(&self.speed),
            "--speed {}: give a number from 0.01 to 100000",
            self.speed
        );
        let kind = self.plant.kind();
        let setup = self.setup.as_deref().map_or_else(|| Ok(kind.setup()), SetUp::read)?;
        let unit = Unit::new(&self.serial, None)?;
        let mut board = VirtualBoard::new(kind.build(self.seed), &setup, &unit.serial, &self.on, self.speed)
            .with_context(|| format!("--on {}: cannot listen there", self.on))?;
        let scans = self
            .scans_on
            .as_ref()
            .map(|on| board.send_scans(on).with_context(|| format!("--scans-on {on}: cannot listen there")));
        let scans = scans.transpose()?;
        let chamber = self
            .chamber_on
            .as_ref()
            .map(|on| board.remote_chamber(on).with_context(|| format!("--chamber-on {on}: cannot listen there")));
        let supply = self
            .supply_on
            .as_ref()
            .map(|on| board.remote_supply(on).with_context(|| format!("--supply-on {on}: cannot listen there")));
        let (chamber, supply) = (chamber.transpose()?, supply.transpose()?);
        interrupt::watch()?;
        let (tell, orders) = mpsc::channel();
        thread::spawn(move || {
            for line in stdin().lock().lines().map_while(Result::ok) {
                if tell.send(line).is_err() {
                    break;
                }
            }
        });
        screen::print(&format!("board {} listens on {}\n", self.serial, board.address()))?;
        if let Some(scans) = scans {
            screen::print(&format!("its scans go out on {scans}\n"))?;
        }
        for (what, place) in [("chamber", chamber), ("supply", supply)] {
            if let Some(place) = place {
                screen::print(&format!("its {what} hears {place}\n"))?;
            }
        }
        let answer = |text: &str| {
            // Whoever closed the pipe does not want to know.
            let _ = screen::print(&format!("{text}\n"));
        };
        board.serve(&orders, answer, || !interrupt::was_asked_for()).context("the socket failed")?;
        Ok(Outcome::Done)
    }
}
