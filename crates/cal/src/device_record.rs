//! Device records as files: what `device-record.bin` holds, for those who look at one.

use std::io;

use thiserror::Error;
use zerorate_core::compensate::{DriftNumbers, FixedDrift, LawNumbers, LawRefused, Mode, Q16};
use zerorate_core::record::{AxisRecord, DeviceRecord, MAX_RECORD_BYTES, RECORD_VERSION, RecordError};
use zerorate_core::units::{TemperatureCode, TemperatureScale};

use zerorate_fit::intervals::ends;
use zerorate_fit::model::Model;

use crate::source::{Faulty, Source};

/// A device record that was read, its CRC-32 and version known to be right.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredRecord {
    /// The record.
    pub record: DeviceRecord,
    /// The version of its body.
    pub version: u16,
    /// Its length, bytes.
    pub bytes: usize,
    /// Its CRC-32, the last four bytes.
    pub crc: u32,
}

/// What one axis's part of a record says, in the units of people.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisFacts {
    /// The model that its drift was rounded from.
    pub model: Model,
    /// The calibrated range, to the nearest code.
    pub temperature_counts: [f64; 2],
    /// Largest less smallest reading over that range; NaN where the numbers make no curve.
    pub drift_pp_counts: f64,
    /// Beyond the taps measured.
    pub counts_per_tap: f64,
    /// How many taps were measured; 0 where there is a line alone.
    pub taps_measured: usize,
    /// To four places: it is stored in steps of 1/65536.
    pub dead_band_taps: f64,
    /// What the axis does when the board starts.
    pub start_up_mode: Mode,
    /// Temperatures at which the tap changes; `None` where the wiper cannot follow.
    pub edges: Option<usize>,
    /// Why a device would refuse the axis's law.
    pub refused: Option<LawRefused>,
}

/// Why a file is not a device record, with its name.
pub type StoredRecordError = Faulty<StoredRecordFault>;

/// Why a file is not a device record.
#[derive(Debug, Error)]
pub enum StoredRecordFault {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Read(#[from] io::Error),
    /// Its bytes are no record.
    #[error("{0}")]
    Bytes(RecordError),
}

impl StoredRecord {
    /// Reads a record.
    ///
    /// # Errors
    /// [`StoredRecordFault`], by what is wrong first: file, form, version, CRC, body.
    pub fn read(source: &Source) -> Result<Self, StoredRecordError> {
        // A longer file is something else, whatever it begins with.
        let bytes = source.start(MAX_RECORD_BYTES as u64).map_err(|error| source.faulty(error))?;
        let record = DeviceRecord::decode(&bytes).map_err(|error| source.faulty(StoredRecordFault::Bytes(error)))?;
        let crc = bytes.last_chunk().map_or(0, |crc| u32::from_le_bytes(*crc));
        Ok(Self { record, version: RECORD_VERSION, bytes: bytes.len(), crc })
    }

    /// What it says of its axes, X then Y.
    #[must_use]
    pub fn axes(&self) -> [AxisFacts; 2] {
        self.record.axes.each_ref().map(|axis| AxisFacts::of(axis, self.record.temperature_scale))
    }
}

impl AxisFacts {
    fn of(axis: &AxisRecord, scale: TemperatureScale) -> Self {
        let LawNumbers { drift, trim, dead_band, edges, .. } = &axis.law;
        Self {
            model: Model::of_numbers(&drift.curve),
            temperature_counts: [drift.first, drift.last].map(|code| scale.temperature(TemperatureCode(code))),
            drift_pp_counts: peak_to_peak(drift),
            counts_per_tap: Q16(trim.per_tap).to_counts(),
            taps_measured: trim.effects.len(),
            dead_band_taps: (f64::from(*dead_band) / 65_536.0 * 1e4).round() / 1e4,
            start_up_mode: axis.start_up_mode,
            // Between two intervals of one tap each lies an edge.
            edges: edges.as_ref().map(|edges| edges.intervals().len().saturating_sub(1)),
            refused: axis.law().err(),
        }
    }
}

fn peak_to_peak(numbers: &DriftNumbers) -> f64 {
    let Some(drift) = FixedDrift::from_numbers(numbers) else { return f64::NAN };
    let readings = (numbers.first..=numbers.last).map(|code| drift.evaluate(TemperatureCode(code)).to_counts());
    let (least, most) = ends(readings);
    most - least
}
