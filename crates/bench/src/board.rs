//! What a person asks of a board: who it is, what it does, a calibration put on it or read from it.

mod first_time;
mod live;
mod self_test;
mod stopped;

use std::path::Path;
use std::time::Duration;

use serde::Serialize;
use zerorate_board_run::folder::CALIBRATION;
use zerorate_cal::calibration::Calibration;
use zerorate_cal::device_record::StoredRecord;
use zerorate_core::record::DeviceRecord;
use zerorate_core::units::GroupNumber;
use zerorate_core::wire::{FaultCounts, Identity, Request};

pub use zerorate_core::compensate::Mode;
pub use zerorate_core::units::{Axis, Taps};

pub use self::first_time::{FirstTime, MOST_STORES, Recalled};
pub use self::live::{LiveAxis, LiveGroup};
pub use self::self_test::{Check, SelfTest, Verdict};
pub use self::stopped::Stopped;

use crate::choice::DeviceChoice;
use crate::client::{ClientError, DeviceClient, LineCounts, wording};
use crate::instruments::Bench;
use crate::plants::PlantKind;
use crate::setup::SetUp;
use crate::simulated;

/// A board that hands were shaken with.
pub struct Board {
    /// The board.
    pub device: DeviceClient,
    identity: Identity,
    /// Whether this program has started the acquisition, and stops it at the end.
    started: bool,
}

/// Who a board is.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Info {
    /// The unit's serial; empty on a board that has not been given one.
    pub unit_serial: String,
    /// The firmware's version.
    pub firmware: String,
    /// The version of the wire that it speaks.
    pub wire_version: u16,
    /// Samples a group.
    pub samples_per_group: u16,
    /// Microseconds from sample to sample.
    pub sample_period_us: u32,
    /// The group that is being filled, or will be the first.
    pub group: u32,
    /// Whether a calibration is in use.
    pub calibrated: bool,
    /// The same in words, and why not.
    pub calibration: String,
    /// The stored record, where there is one.
    pub record: Option<RecordFacts>,
    /// Whether groups are being taken.
    pub acquiring: bool,
    /// The last commanded taps, X then Y.
    pub taps: [u16; 2],
    /// The modes, X then Y.
    pub modes: [&'static str; 2],
    /// Why the board started last.
    pub started: String,
    /// Where its program stopped itself last since power came, if it did.
    pub stopped: Option<Stopped>,
}

/// What a stored record says of itself.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RecordFacts {
    /// Its length, bytes.
    pub bytes: usize,
    /// Its CRC-32, in hexadecimal.
    pub crc32: String,
    /// The unit it was made for.
    pub unit_serial: String,
}

/// Why a file cannot be put on a board.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct NotDeployable(String);

impl Board {
    /// Opens the line and shakes hands.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn open(choice: &DeviceChoice) -> Result<Self, ClientError> {
        Self::on(match choice.open()? {
            Some(device) => device,
            None => simulated_bench(choice)?.device,
        })
    }

    /// Shakes hands with a device.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn on(mut device: DeviceClient) -> Result<Self, ClientError> {
        let identity = device.identify()?;
        Ok(Self { device, identity, started: false })
    }

    /// Who it is, and what it has stored.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn info(&mut self) -> Result<Info, ClientError> {
        let stored = self.device.read_calibration()?;
        let stopped = self.device.stop()?.map(Stopped::from);
        let identity = self.device.identify()?;
        let [major, minor, patch] = identity.firmware;
        Ok(Info {
            unit_serial: identity.unit.to_string(),
            firmware: format!("{major}.{minor}.{patch}"),
            wire_version: identity.wire_version,
            samples_per_group: identity.samples_per_group,
            sample_period_us: identity.sample_period_us,
            group: identity.group.0,
            calibrated: identity.calibration.is_in_use(),
            calibration: wording::of_calibration(identity.calibration),
            record: RecordFacts::of(&stored),
            acquiring: identity.running,
            taps: identity.taps.map(Taps::get),
            modes: identity.modes.map(Mode::name),
            started: wording::of_reset(identity.reset).into(),
            stopped,
        })
    }

    /// The fault counters.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn faults(&mut self) -> Result<FaultCounts, ClientError> {
        self.device.faults()
    }

    /// Changes the mode of some axes, from a group on or from the next; returns the group from which it holds.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn set_mode(&mut self, axes: &[Axis], mode: Mode, at: Option<u32>) -> Result<u32, ClientError> {
        self.each(axes, at, |axis| Request::SetMode { axis, mode })
    }

    /// Writes the wipers of some axes, from a group on or from the next; returns the group from which it holds.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn set_tap(&mut self, axes: &[Axis], tap: Taps, at: Option<u32>) -> Result<u32, ClientError> {
        self.each(axes, at, |axis| Request::SetTap { axis, tap })
    }

    fn each(&mut self, axes: &[Axis], at: Option<u32>, request: impl Fn(Axis) -> Request) -> Result<u32, ClientError> {
        let mut from = 0;
        for &axis in axes {
            from = from.max(self.device.order_at(request(axis), at.map(GroupNumber))?.0);
        }
        Ok(from)
    }

    /// Puts a record on the board: written, committed, read back and compared.
    ///
    /// # Errors
    /// [`ClientError`]; [`ClientError::Refused`] with the board's reason.
    pub fn deploy(&mut self, record: &DeviceRecord) -> Result<RecordFacts, ClientError> {
        self.device.deploy(record)?;
        let stored = self.device.read_calibration()?;
        RecordFacts::of(&stored).ok_or(ClientError::ReadBack)
    }

    /// Turns on what a record that was put on the board says, axis by axis; returns the modes, and the group from which
    /// they hold.
    ///
    /// # Errors
    /// [`ClientError::Refused`] with the board's reason.
    pub fn turn_on(&mut self, record: &DeviceRecord) -> Result<([Mode; 2], u32), ClientError> {
        let modes = record.axes.each_ref().map(|axis| axis.start_up_mode);
        let mut from = 0;
        for (axis, mode) in Axis::BOTH.into_iter().zip(modes) {
            from = from.max(self.set_mode(&[axis], mode, None)?);
        }
        Ok((modes, from))
    }

    /// The stored record as it is, byte for byte; empty where there is none.
    ///
    /// # Errors
    /// [`ClientError`].
    pub fn read(&mut self) -> Result<Vec<u8>, ClientError> {
        self.device.read_calibration()
    }

    /// The unit's serial.
    #[must_use]
    pub fn serial(&self) -> &str {
        &self.identity.unit
    }

    /// How long a group takes.
    #[must_use]
    pub const fn group_period(&self) -> Duration {
        self.device.group_period()
    }

    /// What was noticed of the line.
    #[must_use]
    pub const fn line(&self) -> LineCounts {
        self.device.counts()
    }
}

impl RecordFacts {
    fn of(stored: &[u8]) -> Option<Self> {
        let crc = stored.last_chunk().map(|crc| u32::from_le_bytes(*crc))?;
        let unit_serial =
            DeviceRecord::decode(stored).map_or_else(|why| why.to_string(), |record| record.unit.to_string());
        Some(Self { bytes: stored.len(), crc32: format!("{crc:08x}"), unit_serial })
    }
}

/// The simulated bench about a device without a line of its own.
fn simulated_bench(choice: &DeviceChoice) -> Result<Bench, ClientError> {
    let serial = zerorate_core::record::UnitSerial::try_from("ZR-0001").unwrap_or_default();
    let (plant, setup) = (PlantKind::Paper.build(1), PlantKind::Paper.setup());
    match choice {
        DeviceChoice::Emulated => emulated_bench(plant, &setup, &serial, None),
        _ => Ok(simulated::bench(plant, &setup, &serial)),
    }
}

/// The simulated bench with an emulated board on it. `firmware` is found if it is not named.
///
/// # Errors
/// [`ClientError::NotEmulated`], with what is missing.
#[cfg(unix)]
pub fn emulated_bench(
    plant: zerorate_sim::Plant,
    setup: &SetUp,
    unit: &zerorate_core::record::UnitSerial,
    firmware: Option<&Path>,
) -> Result<Bench, ClientError> {
    use crate::emulated;
    let not = |why: &dyn std::fmt::Display| ClientError::NotEmulated(why.to_string());
    let firmware = emulated::find_firmware(firmware).map_err(|why| not(&why))?;
    emulated::bench(plant, setup, unit, &firmware).map_err(|why| not(&why))
}

/// The simulated bench with an emulated board on it, which takes a system with FIFOs.
///
/// # Errors
/// [`ClientError::NotEmulated`].
#[cfg(not(unix))]
pub fn emulated_bench(
    _: zerorate_sim::Plant,
    _: &SetUp,
    _: &zerorate_core::record::UnitSerial,
    _: Option<&Path>,
) -> Result<Bench, ClientError> {
    Err(ClientError::NotEmulated("an emulated board takes a Unix system: use the native device".into()))
}

/// What can be put on a board.
pub struct Deployable {
    /// The record.
    pub record: DeviceRecord,
    /// The simulated bench that it comes of ([`Calibration::simulated`]); nobody knows it of a device record.
    pub simulated: Option<String>,
}

/// Reads what can be put on a board: a calibration, of which the record is made, or a device record.
///
/// # Errors
/// [`NotDeployable`], with the reason.
pub fn read_deployable(path: &Path) -> Result<Deployable, NotDeployable> {
    let not = |reason: &dyn std::fmt::Display| NotDeployable(reason.to_string());
    // A port's name in the file's place would be waited for without end.
    if path.exists() && !path.is_file() {
        return Err(NotDeployable(format!(
            "{}: this is no file: name a calibration.json or device-record.bin",
            path.display()
        )));
    }
    if std::fs::read(path).is_ok_and(|bytes| bytes.trim_ascii_start().starts_with(b"{")) {
        let calibration = Calibration::read(&path.into()).map_err(|error| not(&error))?;
        let made = calibration.to_device_record();
        let made = made.map_err(|error| NotDeployable(format!("{}: {error}", path.display())))?;
        return Ok(Deployable { record: made.record, simulated: calibration.simulated });
    }
    let record = StoredRecord::read(&path.into()).map_err(|error| not(&error))?.record;
    let simulated = simulated_beside(path, &record);
    Ok(Deployable { record, simulated })
}

/// A record cannot say that it is of the simulated bench; the calibration that it was made of, which lies beside it, does.
fn simulated_beside(path: &Path, record: &DeviceRecord) -> Option<String> {
    let beside = Calibration::read(&(&path.with_file_name(CALIBRATION)).into()).ok()?;
    let made = beside.to_device_record().ok()?;
    beside.simulated.filter(|_| made.record == *record)
}
