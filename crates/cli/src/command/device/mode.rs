//! `zerorate device mode`.

use anyhow::Result;
use clap::{Args, ValueEnum};
use serde_json::json;
use zerorate_bench::board;

use super::{Axes, Device};
use crate::command::Outcome;

/// Choose what an axis does with its calibration
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Mode {
    /// Which axis
    #[arg(value_enum)]
    axis: Axes,

    /// What it is to do
    #[arg(value_enum)]
    mode: ModeName,

    /// The first group for which it is to hold; without it the next one
    #[arg(long, value_name = "GROUP")]
    at: Option<u32>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ModeName {
    /// Nothing
    Off,
    /// The tap follows the temperature
    Trim,
    /// The tap stays, the drift is subtracted in numbers
    Digital,
    /// The tap follows, the rest is subtracted in numbers
    Hybrid,
}

impl ModeName {
    const fn mode(self) -> board::Mode {
        match self {
            Self::Off => board::Mode::Off,
            Self::Trim => board::Mode::Trim,
            Self::Digital => board::Mode::Digital,
            Self::Hybrid => board::Mode::Hybrid,
        }
    }
}

const EXAMPLES: &str = "\
Examples:
  zerorate device --port serial:/dev/ttyUSB0 mode both hybrid
  zerorate device --port serial:/dev/ttyUSB0 mode x off --at 2400";

impl Mode {
    pub fn run(&self, device: &Device) -> Result<Outcome> {
        let mode = self.mode.mode();
        let from = device.open()?.set_mode(self.axis.all(), mode, self.at)?;
        let told = json!({ "axes": self.axis.all().iter().map(|axis| axis.name()).collect::<Vec<_>>(),
            "mode": mode.name(), "from_group": from });
        device.done(&told, &format!("{} in mode {} from group {from} on", self.axis.name(), mode.name()))
    }
}
