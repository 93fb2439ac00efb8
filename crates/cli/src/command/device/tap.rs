//! `zerorate device tap`.

use anyhow::{Context, Result};
use clap::Args;
use serde_json::json;
use zerorate_bench::board::Taps;

use super::{Axes, Device};
use crate::command::Outcome;

/// Write a wiper; a mode that moves it moves it on from there
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Tap {
    /// Which axis
    #[arg(value_enum)]
    axis: Axes,

    /// The tap, 0 to 1023
    tap: u16,

    /// The first group for which it is to hold; without it the next one
    #[arg(long, value_name = "GROUP")]
    at: Option<u32>,
}

const EXAMPLES: &str = "\
Examples:
  zerorate device --port serial:/dev/ttyUSB0 tap both 511";

impl Tap {
    pub fn run(&self, device: &Device) -> Result<Outcome> {
        let tap = Taps::new(self.tap).with_context(|| format!("{} is no tap: the part has 0 to 1023", self.tap))?;
        let from = device.open()?.set_tap(self.axis.all(), tap, self.at)?;
        let told = json!({ "axes": self.axis.all().iter().map(|axis| axis.name()).collect::<Vec<_>>(),
            "tap": self.tap, "from_group": from });
        device.done(&told, &format!("{} at tap {} from group {from} on", self.axis.name(), self.tap))
    }
}
