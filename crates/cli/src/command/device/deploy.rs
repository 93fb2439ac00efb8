//! `zerorate device deploy`.

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Args;
use serde_json::json;
use zerorate_bench::board::{Deployable, read_deployable};
use zerorate_bench::choice::DeviceChoice;
use zerorate_bench::client::ClientError;
use zerorate_words::sentence;

use super::Device;
use crate::command::Outcome;
use crate::screen;

/// Put a calibration on the board: write it, commit it, read it back, compare, and turn the compensation on
///
/// The board checks everything before it stores anything: a damaged record, another unit's, or one that it cannot run is
/// refused, and what it had stays in use. Groups that are lost during the commit are counted (on an STM32F405 none is). Then each axis is put
/// into the mode in which the board would start with this record: hybrid, or digital where the wiper cannot follow or no
/// trim was measured. `mode` changes that.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Deploy {
    /// A board's calibration (calibration.json) or device record (device-record.bin)
    #[arg(value_name = "FILE")]
    file: PathBuf,

    /// Put a calibration on the board that was made on the simulated bench, and so on no gyro
    #[arg(long)]
    simulated: bool,
}

const EXAMPLES: &str = "\
Examples:
  zerorate device --port serial:/dev/ttyUSB0 deploy calibration/calibration.json
  zerorate device --port serial:/dev/ttyUSB0 deploy calibration/device-record.bin";

impl Deploy {
    pub fn run(&self, device: &Device) -> Result<Outcome> {
        let Deployable { record, simulated } = read_deployable(&self.file)?;
        let is_board = !matches!(device.port, Some(DeviceChoice::Native | DeviceChoice::Emulated));
        if let Some(of) = simulated.filter(|_| is_board && !self.simulated) {
            bail!(
                "{}: it was made on the simulated bench ({of}), and says nothing of this board's gyros: calibrate the board itself (zerorate calibrate --device), or put it there all the same (--simulated)",
                self.file.display()
            );
        }
        let mut board = device.open()?;
        let stored = board.deploy(&record).inspect_err(|error| {
            let of_another = !board.serial().is_empty() && record.unit.as_str() != board.serial();
            if of_another && error.to_string().contains("refused") {
                let (made_for, is) = (record.unit.as_str(), board.serial());
                screen::note(&format!(
                    "{} was made for unit {made_for}, the board is {is}: deploy that unit's own calibration",
                    self.file.display()
                ));
            }
        })?;
        let turned_on = match board.turn_on(&record) {
            Err(why @ ClientError::Refused(_)) => Err(sentence(&why)),
            other => Ok(other?),
        };
        let info = board.info()?;
        let line = board.line();
        let why_not = turned_on.as_ref().err();
        let told = json!({ "deployed": true, "record": stored, "modes": info.modes, "acquiring": info.acquiring,
            "not_turned_on": why_not, "sent_again": line.sent_again, "damaged_frames": line.damaged_frames });
        let unit = if board.serial().is_empty() { "the board" } else { board.serial() };
        let [x, y] = info.modes;
        let on = match turned_on {
            Ok((_, from)) => format!("axis X is in mode {x}, axis Y in mode {y}, from group {from} on"),
            Err(why) => format!("it was not turned on: {why}; axis X is in mode {x}, axis Y in mode {y}"),
        };
        let stands = match info.modes {
            _ if info.acquiring => "",
            ["off", "off"] => "; the acquisition stands still",
            _ => {
                "; the acquisition stands still, and nothing is compensated until it runs: switch the board off and on"
            }
        };
        let text = format!(
            "{}: on {unit}, {} bytes, read back and the same (CRC-32 {}); {on}{stands}",
            self.file.display(),
            stored.bytes,
            stored.crc32
        );
        device.done(&told, &text)
    }
}
