//! `zerorate device info`.

use anyhow::Result;
use clap::Args;
use zerorate_bench::board::Taps;

use super::Device;
use crate::command::Outcome;
use crate::screen::Page;

/// Say who the board is, and what calibration it has
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Info {}

const EXAMPLES: &str = "\
Examples:
  zerorate device --port serial:/dev/ttyUSB0 info
  zerorate device --port emulated info --json";

impl Info {
    pub fn run(&self, device: &Device) -> Result<Outcome> {
        let info = device.open()?.info()?;
        if device.json {
            super::print_json(&info)?;
            return Ok(Outcome::Done);
        }
        let serial =
            if info.unit_serial.is_empty() { "none given yet: it takes any record" } else { &info.unit_serial };
        let period_s = f64::from(info.samples_per_group) * f64::from(info.sample_period_us) * 1e-6;
        let stored = info.record.as_ref().map_or_else(
            || "none".to_owned(),
            |record| format!("{} bytes, CRC-32 {}, of unit {}", record.bytes, record.crc32, record.unit_serial),
        );
        let mut page = Page::default();
        page.facts(&[
            ("unit", serial.to_owned()),
            ("firmware", info.firmware.clone()),
            ("wire", format!("version {}", info.wire_version)),
            (
                "groups",
                format!("{} samples every {} us: {period_s} s each", info.samples_per_group, info.sample_period_us),
            ),
            ("at group", format!("{}, {}", info.group, if info.acquiring { "acquiring" } else { "standing still" })),
            ("compensation", of_each(info.modes.map(compensation))),
            ("wipers", of_each(info.taps.map(wiper))),
            ("started", info.started.clone()),
            ("stopped", info.stopped.as_ref().map_or_else(|| "never since power on".into(), ToString::to_string)),
            ("calibration", info.calibration.clone()),
            ("stored", stored),
        ]);
        page.print()?;
        Ok(Outcome::Done)
    }
}

/// What is told of X and of Y; once, where it is the same.
fn of_each(axes: [String; 2]) -> String {
    let [x, y] = axes;
    if x == y { format!("X and Y {x}") } else { format!("X {x}, Y {y}") }
}

fn compensation(mode: &str) -> String {
    if mode == "off" { mode.to_owned() } else { format!("in mode {mode}") }
}

fn wiper(tap: u16) -> String {
    if tap == Taps::MIDDLE.get() { format!("at the middle tap {tap}") } else { format!("at tap {tap}") }
}
