//! `zerorate device faults`.

use anyhow::Result;
use clap::Args;

use super::Device;
use crate::command::Outcome;
use crate::screen::Page;

/// Show how often each fault has happened since the board started
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Faults {}

const EXAMPLES: &str = "\
Examples:
  zerorate device --port serial:/dev/ttyUSB0 faults";

impl Faults {
    pub fn run(&self, device: &Device) -> Result<Outcome> {
        let faults = serde_json::to_value(device.open()?.faults()?)?;
        if device.json {
            super::print_json(&faults)?;
            return Ok(Outcome::Done);
        }
        let mut page = Page::default();
        let counters: Vec<(String, String)> = faults
            .as_object()
            .into_iter()
            .flatten()
            .map(|(name, count)| (name.replace('_', " "), count.to_string()))
            .collect();
        let facts: Vec<(&str, String)> = counters.iter().map(|(name, count)| (name.as_str(), count.clone())).collect();
        page.facts(&facts);
        page.print()?;
        Ok(Outcome::Done)
    }
}
