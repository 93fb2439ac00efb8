//! `zerorate device read`.

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;
use serde_json::json;
use zerorate_cal::source::whole_file::write_whole;

use super::Device;
use crate::command::Outcome;
use crate::output;

/// Read the calibration that the board has stored into a file
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Read {
    /// The file to write, as device-record.bin
    #[arg(value_name = "FILE")]
    out: PathBuf,

    #[command(flatten)]
    force: output::Force,
}

const EXAMPLES: &str = "\
Examples:
  zerorate device --port serial:/dev/ttyUSB0 read backup.bin
  zerorate info backup.bin";

impl Read {
    pub fn run(&self, device: &Device) -> Result<Outcome> {
        output::check("FILE", &self.out, &[])?;
        let mut board = device.open()?;
        self.force.record("FILE", &self.out, board.serial())?;
        let stored = board.read()?;
        if stored.is_empty() {
            return device.refused(&anyhow::anyhow!(
                "the board has no calibration stored, and nothing was written: `zerorate device deploy` puts one on it"
            ));
        }
        self.force.backup("FILE", &self.out, board.serial(), &stored)?;
        write_whole(&self.out, &stored).with_context(|| format!("{}: cannot be written", self.out.display()))?;
        let told = json!({ "file": self.out, "bytes": stored.len() });
        let text = format!(
            "{}: {} bytes; `zerorate info {}` tells what is in it",
            self.out.display(),
            stored.len(),
            output::argument(&self.out)
        );
        device.done(&told, &text)
    }
}
