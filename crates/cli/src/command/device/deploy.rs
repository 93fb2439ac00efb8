//! `zerorate device deploy`.

use std::path::PathBuf;

use anyhow::Result;
use clap::Args;
use serde_json::json;
use zerorate_bench::board::read_record;

use super::Device;
use crate::command::Outcome;
use crate::screen;

/// Put a calibration on the board: write it, commit it, read it back, compare
///
/// The board checks everything before it stores anything: a damaged record, another unit's, or one that it cannot run is
/// refused, and what it had stays in use. Groups that fall into the commit are lost, and counted.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Deploy {
    /// A board's calibration (calibration.json) or device record (device-record.bin)
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

const EXAMPLES: &str = "\
Examples:
  zerorate device --port serial:/dev/ttyUSB0 deploy calibration/calibration.json
  zerorate device --port serial:/dev/ttyUSB0 deploy calibration/device-record.bin";

impl Deploy {
    pub fn run(&self, device: &Device) -> Result<Outcome> {
        let record = read_record(&self.file)?;
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
        let line = board.line();
        let told = json!({ "verdict": "deployed", "record": stored, "sent_again": line.sent_again,
            "damaged_frames": line.damaged_frames });
        let unit = if board.serial().is_empty() { "the board" } else { board.serial() };
        let text = format!(
            "{}: on {unit}, {} bytes, read back and the same (CRC-32 {}); it holds from the next group on",
            self.file.display(),
            stored.bytes,
            stored.crc32
        );
        device.done(&told, &text)
    }
}
