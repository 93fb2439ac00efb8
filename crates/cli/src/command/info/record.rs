//! What is in a device record.

use std::path::Path;

use anyhow::Result;
use serde::Serialize;
use zerorate_cal::device_record::{AxisFacts, StoredRecord};

use crate::screen::{Grid, Page, three_digits};

#[derive(Debug, Serialize)]
pub struct Facts {
    unit_serial: String,
    version: u16,
    crc32: String,
    bytes: usize,
    axes: Vec<Axis>,
}

#[derive(Debug, Serialize)]
struct Axis {
    name: &'static str,
    model: String,
    temperature_counts: [f64; 2],
    drift_pp_counts: f64,
    counts_per_tap: f64,
    taps_measured: usize,
    dead_band_taps: f64,
    start_up_mode: &'static str,
    edges: Option<usize>,
    refused: Option<String>,
}

impl Axis {
    fn of(name: &'static str, facts: AxisFacts) -> Self {
        Self {
            name,
            model: facts.model.to_string(),
            temperature_counts: facts.temperature_counts,
            drift_pp_counts: facts.drift_pp_counts,
            counts_per_tap: facts.counts_per_tap,
            taps_measured: facts.taps_measured,
            dead_band_taps: facts.dead_band_taps,
            start_up_mode: facts.start_up_mode.name(),
            edges: facts.edges,
            refused: facts.refused.map(|why| why.to_string()),
        }
    }
}

impl Facts {
    pub fn read(file: &Path) -> Result<Self> {
        let stored = StoredRecord::read(&file.into())?;
        let axes = ["x", "y"].into_iter().zip(stored.axes()).map(|(name, facts)| Axis::of(name, facts));
        Ok(Self {
            unit_serial: stored.record.unit.to_string(),
            version: stored.version,
            crc32: format!("{:08x}", stored.crc),
            bytes: stored.bytes,
            axes: axes.collect(),
        })
    }

    pub fn show(&self, file: &str, page: &mut Page) {
        page.sentence("", &format!("{file}: a device record, whole (its CRC-32 {} matches)", self.crc32));
        page.facts(&[
            ("unit", self.unit_serial.clone()),
            ("version", self.version.to_string()),
            ("size", format!("{} bytes", self.bytes)),
        ]);
        page.gap();
        let mut grid = Grid::new("llrrrrrrl");
        grid.head(["", "", "calibrated", "drift", "one tap", "taps", "", "dead", "starts"]);
        grid.head(["axis", "model", "counts", "pp", "counts", "measured", "edges", "band", "in mode"]);
        for axis in &self.axes {
            let [min, max] = axis.temperature_counts;
            grid.row([
                axis.name.to_owned(),
                axis.model.clone(),
                format!("{min:.0} to {max:.0}"),
                format!("{:.0}", axis.drift_pp_counts),
                three_digits(axis.counts_per_tap),
                axis.taps_measured.to_string(),
                axis.edges.map_or_else(|| "none".to_owned(), |edges| edges.to_string()),
                axis.dead_band_taps.to_string(),
                axis.start_up_mode.to_owned(),
            ]);
        }
        page.grid(&grid);
        page.gap();
        page.sentence(
            "  ",
            "An edge is a temperature at which the tap changes; an axis with none runs in numbers alone.",
        );
        for axis in &self.axes {
            if let Some(why) = &axis.refused {
                page.sentence("  - ", &format!("axis {}: a device refuses this law: {why}", axis.name));
            }
        }
    }
}
