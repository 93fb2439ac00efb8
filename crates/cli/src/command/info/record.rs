//! What is in a device record.

use std::path::Path;

use anyhow::Result;
use serde::Serialize;
use zerorate_cal::choose::Model;
use zerorate_cal::device_record::StoredRecord;

use crate::screen::{Grid, Page, significant};

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
    /// Temperatures at which the tap changes; `None` where the wiper cannot follow.
    edges: Option<usize>,
    /// Why a device would refuse the axis's law.
    refused: Option<String>,
}

impl Facts {
    pub fn read(file: &Path) -> Result<Self> {
        let stored = StoredRecord::read(file)?;
        let scale = stored.record.temperature_scale;
        let axes = ["x", "y"].into_iter().zip(&stored.record.axes).map(|(name, axis)| Axis {
            name,
            model: Model::of_shape(&axis.drift.shape).to_string(),
            temperature_counts: [axis.drift.valid.min(), axis.drift.valid.max()],
            drift_pp_counts: axis.drift.peak_to_peak(),
            counts_per_tap: axis.trim.line.counts_per_tap().0,
            taps_measured: axis.trim.measured.as_ref().map_or(0, |measured| measured.effects().len()),
            dead_band_taps: axis.dead_band,
            start_up_mode: axis.start_up_mode.name(),
            // Between two intervals of one tap each lies an edge.
            edges: axis.edges.as_ref().map(|edges| edges.intervals().len().saturating_sub(1)),
            refused: axis.law(scale).err().map(|why| why.to_string()),
        });
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
                significant(axis.counts_per_tap),
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
