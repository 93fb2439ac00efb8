//! Every message between device and host, in one table, and the frames that carry them.
//!
//! Host to device: [`Command`]. Device to host: [`Upload`]; on a line of its own, scan by scan, [`ScanReport`]. Each travels as postcard, a CRC-32, COBS and a zero byte
//! ([`frame`]).
//!
//! A command says at which group it takes effect and is answered with the group at which it did. What changes how
//! groups are taken happens between two groups, never within one; what only asks is answered at once.
//!
//! [`Request::Identity`] opens a conversation. Within one, a command that is sent again with its number and content
//! unchanged is not done again: the device answers with what happened, or goes on waiting for the command's group. What
//! only asks is asked anew.

pub mod frame;
mod scan;
mod stop;

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::compensate::{Mode, Q16};
use crate::drift::Coverage;
use crate::group::GroupSums;
use crate::record::{RecordError, RecordRefused, UnitSerial};
use crate::units::{Axis, Counts, GroupNumber, Taps};

pub use self::scan::{AxisScan, SCAN_FRAME_BYTES, ScanFlags, ScanReport};
pub use self::stop::{FILE_BYTES, FaultRegisters, Stop};

/// The version of this table. Host and device compare it in the answer to [`Request::Identity`].
pub const WIRE_VERSION: u16 = 5;
/// Bytes of a calibration in one message.
pub const CHUNK: usize = 128;
/// Samples in one message.
pub const SAMPLES_PER_BLOCK: usize = 25;

/// What the host sends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Command {
    /// The host's number for the command; the answer carries it.
    pub sequence: u16,
    /// The first group for which the command is to hold; `None`: the next one. A group that has begun cannot be
    /// changed: then it holds from the next, and the answer says which.
    pub at: Option<GroupNumber>,
    /// What is asked.
    pub request: Request,
}

/// What the host asks for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// Who are you? Answered at once.
    Identity,
    /// Changes an axis's mode, between groups.
    SetMode {
        /// Which axis.
        axis: Axis,
        /// The mode.
        mode: Mode,
    },
    /// Writes a wiper, between groups. A mode that moves the wiper moves it on from there.
    SetTap {
        /// Which axis.
        axis: Axis,
        /// The tap.
        tap: Taps,
    },
    /// Starts the acquisition anew at group 0, or stops it. Answered at once.
    SetAcquisition {
        /// Whether to acquire.
        run: bool,
    },
    /// Chooses what is uploaded. Answered at once.
    SetStream {
        /// A [`GroupReport`] for every group.
        groups: bool,
        /// Which of its samples, too.
        samples: SampleWindow,
    },
    /// Puts a part of a record in the device's buffer; it changes nothing yet. Answered at once.
    WriteCalibration {
        /// Where in the record, bytes.
        offset: u16,
        /// The part.
        bytes: Vec<u8, CHUNK>,
    },
    /// Checks the buffered record, stores it at once, and takes it into use between groups. A declared pause: groups
    /// that fall into it are lost and counted.
    CommitCalibration {
        /// Length of the whole record, bytes.
        length: u16,
    },
    /// Asks for a part of the stored record. Answered at once.
    ReadCalibration {
        /// Where in the record, bytes.
        offset: u16,
    },
    /// Asks for the fault counters. Answered at once.
    Faults,
    /// Makes the present taps those of power-up: a store in the potentiometer's non-volatile register, which wears
    /// (50 000 stores). Between groups.
    StorePowerUpTap,
    /// Puts both axes off and both wipers where the potentiometer's non-volatile registers have them, and leaves them there
    /// until a mode is set or a wiper is written. Between groups.
    RecallPowerUpTap,
    /// Asks where the program stopped itself last. Answered at once.
    Stop,
    /// Asks how the board finds itself. Answered at once.
    Health,
}

/// Which of a group's samples are uploaded: the first so many and the last so many of each axis that is asked for.
///
/// A line carries far fewer samples than the board takes, and most who ask look at the beginning of a group alone, after
/// a tap change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct SampleWindow {
    /// Whether X's and Y's are.
    pub axes: [bool; 2],
    /// How many from the group's first sample on.
    pub first: u16,
    /// How many up to the group's last sample.
    pub last: u16,
}

impl SampleWindow {
    /// No samples.
    pub const NONE: Self = Self { axes: [false; 2], first: 0, last: 0 };
    /// Every sample of both axes.
    pub const ALL: Self = Self { axes: [true; 2], first: u16::MAX, last: 0 };

    /// Whether any sample is asked for.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        (self.axes[0] || self.axes[1]) && (self.first > 0 || self.last > 0)
    }

    /// The samples of a group of `n` that are asked for of an axis: those before the first number returned, and those
    /// from the second on.
    #[must_use]
    pub fn of(&self, axis: Axis, n: u16) -> (u16, u16) {
        if !self.axes[axis.index()] {
            return (0, n);
        }
        let first = self.first.min(n);
        (first, n.saturating_sub(self.last).max(first))
    }
}

/// What the device sends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Upload {
    /// Counts every upload, so that a lost one is noticed.
    pub sequence: u32,
    /// What it carries.
    pub message: Message,
}

/// What an upload carries.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Message {
    /// The answer to a command.
    Answer {
        /// The command's number.
        to: u16,
        /// The first group for which it holds.
        group: GroupNumber,
        /// What came of it.
        answer: Answer,
    },
    /// A closed group.
    Group(GroupReport),
    /// Some of a group's samples.
    Samples(SampleBlock),
}

/// What came of a command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Answer {
    /// It was done.
    Done,
    /// Who the device is.
    Identity(Identity),
    /// A part of the stored record.
    Calibration {
        /// Length of the whole record, bytes; 0 where there is none.
        length: u16,
        /// Where the part belongs.
        offset: u16,
        /// The part.
        bytes: Vec<u8, CHUNK>,
    },
    /// The fault counters.
    Faults(FaultCounts),
    /// It was not done.
    Refused(Refusal),
    /// Where the program stopped itself last since power came, if it did.
    Stop(Option<Stop>),
    /// How the board finds itself.
    Health(Health),
}

/// How a board finds itself, as far as it can tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Health {
    /// Its stack; `None` where the program runs on one that is not its own.
    pub stack: Option<Stack>,
    /// The longest that the data-ready interrupt took since the start; `None` where no cycles are counted.
    pub interrupt: Option<Interrupt>,
}

/// A stack since the start, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stack {
    /// How much of it there is.
    pub size: u32,
    /// How much of it was ever used.
    pub used: u32,
}

/// An interrupt, by the processor's own counter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Interrupt {
    /// The longest since the start, cycles.
    pub longest_cycles: u32,
    /// Cycles a microsecond.
    pub cycles_per_us: u32,
}

/// Who the device is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// [`WIRE_VERSION`] of the device.
    pub wire_version: u16,
    /// The unit's serial.
    pub unit: UnitSerial,
    /// The firmware's version, major, minor, patch.
    pub firmware: [u16; 3],
    /// Samples a group.
    pub samples_per_group: u16,
    /// Microseconds from sample to sample.
    pub sample_period_us: u32,
    /// Whether a calibration is in use, and why not.
    pub calibration: CalibrationState,
    /// The group that is being filled.
    pub group: GroupNumber,
    /// Whether groups are being taken.
    pub running: bool,
    /// The last commanded taps, X then Y.
    pub taps: [Taps; 2],
    /// The modes, X then Y.
    pub modes: [Mode; 2],
    /// Why the device started last.
    pub reset: ResetCause,
}

/// Why a device started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum ResetCause {
    /// Its power came.
    #[default]
    Power,
    /// Its watchdog was not fed: sets stopped coming, or its program hung.
    Watchdog,
    /// Its program stopped itself at a fault of its own: [`Stop::Panic`].
    Panic,
    /// Its processor could not go on with the program: [`Stop::Fault`].
    Fault,
    /// Its processor's supply fell below the level at which it can work.
    BrownOut,
    /// A reset that was asked for, and not by the program: a debugger's.
    Software,
    /// Its reset pin.
    Pin,
}

impl ResetCause {
    /// Whether the device restarted itself, and goes on compensating without being asked.
    #[must_use]
    pub const fn is_fault(self) -> bool {
        matches!(self, Self::Watchdog | Self::Panic | Self::Fault)
    }
}

/// Whether a calibration is in use, and why not. Without one the device runs uncompensated at the middle tap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum CalibrationState {
    /// The stored record is in use.
    InUse,
    /// The record stored last is damaged; the one before it is in use.
    OlderInUse,
    /// Nothing was ever stored.
    Blank,
    /// What is stored is damaged.
    Damaged,
    /// The stored record has a version that the firmware does not know.
    UnknownVersion {
        /// The version found.
        found: u16,
    },
    /// The stored record is another unit's.
    OtherUnit,
    /// The stored record's laws cannot be run.
    LawRefused,
    /// The flash does not answer.
    Unreachable,
    /// The stored record is whole and not in use: the program has failed with it three times in a row.
    SetAside,
}

impl CalibrationState {
    /// Whether the device compensates.
    #[must_use]
    pub const fn is_in_use(self) -> bool {
        matches!(self, Self::InUse | Self::OlderInUse)
    }
}

/// Why a command was not done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// The mode needs a calibration and there is none.
    NoCalibration,
    /// The mode moves the wiper and the calibration has no table of edges.
    NoEdges,
    /// The potentiometer could not be written.
    TrimPartFailed,
    /// The acquisition could not be reached.
    AcquisitionFailed,
    /// More commands wait than the device can hold: send it again.
    Busy,
    /// The part lies outside the calibration buffer.
    OutOfBuffer,
    /// The record cannot be read.
    Record(RecordError),
    /// The record is another unit's.
    OtherUnit,
    /// The record's laws cannot be run: their numbers do not fit, or a table of edges disagrees with its law.
    LawRefused,
    /// The record could not be stored.
    StoreFailed,
    /// The acquisition was stopped, or started anew, before the command's group came.
    Stopped,
}

impl From<RecordRefused> for Refusal {
    fn from(refused: RecordRefused) -> Self {
        match refused {
            RecordRefused::Bytes(error) => Self::Record(error),
            RecordRefused::OtherUnit => Self::OtherUnit,
            RecordRefused::Law => Self::LawRefused,
        }
    }
}

/// How often each fault has happened since the device started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct FaultCounts {
    /// Sets lost before they were read.
    pub lost_sets: u32,
    /// Sets and scans whose CRC did not match, or whose transfer failed; and how often the acquisition was to be set up anew.
    pub acquisition_errors: u32,
    /// Wiper writes that failed.
    pub trim_errors: u32,
    /// Groups outside the calibrated temperature range.
    pub out_of_range: u32,
    /// Groups with a reading at either end of the converter.
    pub saturated: u32,
    /// Frames that could not be read.
    pub damaged_frames: u32,
    /// Uploads dropped because the line was too slow.
    pub dropped_uploads: u32,
    /// Whole frames that held no message of this version.
    pub unknown_frames: u32,
    /// Commands that came again and were not done again.
    pub repeated_commands: u32,
    /// Groups of an axis whose temperature did not move by a count for too long.
    pub temperature_stuck: u32,
    /// Groups of an axis whose temperature jumped, or scattered, more than a temperature can.
    pub temperature_jumped: u32,
    /// Groups of an axis whose temperature stood at either end of the converter.
    pub temperature_saturated: u32,
    /// Restarts by the watchdog or after a fault of the program, since power came.
    pub restarts: u32,
    /// Dips of the processor's supply that were too short or too shallow to reset it, since power came.
    pub supply_dips: u32,
}

/// Whether a group's temperature is believed. What is not leaves tap and correction where the last believed one put them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum TemperatureCheck {
    /// It is believed.
    #[default]
    Believed,
    /// It has not moved by a count for too long.
    Stuck,
    /// It jumped, or scattered, more than a temperature can; a jump that stays is believed after a few groups.
    Jumped,
    /// It stands at either end of the converter.
    Saturated,
}

/// One axis's part of a group.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AxisReport {
    /// The exact sums.
    pub sums: GroupSums,
    /// The tap while the group was taken.
    pub tap: Taps,
    /// The mode while the group was taken.
    pub mode: Mode,
    /// The corrected mean, in steps of 1/65536 count, modulo 65 536 counts: [`corrected`](Self::corrected) tells it.
    pub corrected_q16: i32,
    /// Where the temperature lay against the calibrated range.
    pub coverage: Coverage,
    /// Whether a sample was at either end of the converter.
    pub saturated: bool,
    /// The tap that was written when the group closed, if it changed.
    pub moved_to: Option<Taps>,
    /// Whether the temperature is believed.
    pub temperature: TemperatureCheck,
    /// Whether the wiper was to be written when the group closed, and could not be: it will be tried again.
    pub trim_failed: bool,
}

impl AxisReport {
    /// The corrected mean.
    #[must_use]
    pub fn corrected(&self) -> Counts {
        Counts(Q16(self.corrected_q16).near(self.sums.mean_zro().0))
    }
}

/// A closed group.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GroupReport {
    /// Its number.
    pub group: GroupNumber,
    /// Groups lost since acquisition started.
    pub lost: u32,
    /// Reads of a set or a scan that failed since the device started.
    pub acquisition_errors: u32,
    /// The axes, X then Y.
    pub axes: [AxisReport; 2],
}

/// One sample of one axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sample {
    /// The temperature reading, counts.
    pub temperature: u16,
    /// The zero-rate reading, counts.
    pub zro: u16,
    /// The corrected reading, in steps of 1/65536 count, modulo 65 536 counts: [`corrected`](Self::corrected) tells it.
    pub corrected_q16: i32,
}

impl Sample {
    /// The corrected reading.
    #[must_use]
    pub fn corrected(&self) -> Counts {
        Counts(Q16(self.corrected_q16).near(f64::from(self.zro)))
    }
}

/// Some of a group's samples of one axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SampleBlock {
    /// The group.
    pub group: GroupNumber,
    /// The axis.
    pub axis: Axis,
    /// The first sample's place in the group.
    pub index: u16,
    /// The samples.
    pub samples: Vec<Sample, SAMPLES_PER_BLOCK>,
}
