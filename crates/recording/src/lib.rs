#![doc = include_str!("../README.md")]

mod chamber;
mod columns;
mod error;
mod header;
mod label;
pub mod named;
pub mod parquet_source;
mod phase;
mod reader;
mod schema;
pub mod status;
mod streamed;
pub mod utc;
mod writer;

use std::collections::BTreeMap;

use chrono::{DateTime, Utc};
use zerorate_core::compensate::Mode;
use zerorate_core::group::GroupSums;
use zerorate_core::units::Axis;

pub use chamber::{ChamberInfo, ChamberMoment, ChamberRecording, ChamberWriter};
pub use columns::name_in_version_1;
pub use error::{RecordingError, RecordingFault, WriteError};
pub use label::{CALIBRATED, RECORDED_AT, label_doubts};
pub use phase::Phase;
pub use reader::Recording;
pub use schema::{COLUMNS_KEY, SCHEMA_VERSION, columns_told, described, described_as_a_recordings, key_values};
pub use streamed::hold;
pub use writer::RecordingWriter;

/// What is true of a whole recording.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RecordingInfo {
    /// The unit's serial number.
    pub unit_serial: String,
    /// The procedure, such as `full-temperature`.
    pub procedure: String,
    /// The set-up file's text.
    pub set_up: String,
    /// The device's firmware.
    pub firmware: String,
    /// The seed of a simulated bench.
    pub seed: Option<u64>,
    /// When it was begun, by the bench's clock: before its first group. None of a simulated bench, whose recordings are
    /// the same from run to run.
    pub started: Option<DateTime<Utc>>,
    /// What the line knows of it, by name, as `station`, `operator`, `recorded_at`.
    pub labels: BTreeMap<String, String>,
}

impl RecordingInfo {
    /// The groups that the ramps of a whole full-temperature test have by the set-up (`chamber.ramp_groups`, twice with
    /// `chamber.cooling_ramp`); `None` where it does not say.
    #[must_use]
    pub fn ramp_groups(&self) -> Option<u64> {
        let set_up: toml::Table = self.set_up.parse().ok()?;
        let chamber = set_up.get("chamber")?;
        let cooling = chamber.get("cooling_ramp").and_then(toml::Value::as_bool) == Some(true);
        let ramps = if cooling && self.procedure == "full-temperature" { 2 } else { 1 };
        let groups: u64 = chamber.get("ramp_groups")?.as_integer()?.try_into().ok()?;
        groups.checked_mul(ramps)
    }

    /// What there is to say of a recording that holds groups, and none of a ramp.
    #[must_use]
    pub fn without_a_ramp(&self) -> String {
        format!(
            "the recording{} holds no ramp, and only a ramp shows the drift: take that of a whole full-temperature test",
            self.of_procedure()
        )
    }

    /// The procedure in words that follow a noun; nothing where it is not told.
    fn of_procedure(&self) -> String {
        let named = Some(self.procedure.as_str()).filter(|name| !name.is_empty());
        named.map(|name| format!(" of the procedure {name}")).unwrap_or_default()
    }
}

/// One axis of one group.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupRow {
    /// The group's number.
    pub group: u32,
    /// Seconds from the first group.
    pub t_s: f64,
    /// What the chamber was doing.
    pub phase: Phase,
    /// The axis.
    pub axis: Axis,
    /// The exact sums; the columns `temperature_counts` and `zro_counts` are their means.
    pub sums: GroupSums,
    /// The zero-rate output after the digital correction, counts.
    pub corrected_counts: f64,
    /// The wiper's position, taps.
    pub tap: u16,
    /// The axis's mode.
    pub mode: Mode,
    /// The chamber's set point, degrees C; NaN if not known.
    pub chamber_set_c: f64,
    /// The chamber's air, degrees C; NaN if not known.
    pub chamber_c: f64,
    /// What the device said of the group: bits of [`status`].
    pub status_bits: u16,
}

#[cfg(test)]
mod tests;
