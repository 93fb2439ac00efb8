//! Why a procedure could not be carried through.

use zerorate_board_run::folder::BoardRunError;
use zerorate_cal::calibration::CalibrationFault;
use zerorate_cal::log::LogError;
use zerorate_cal::recording::{RecordingError, WriteError};
use zerorate_core::compensate::Mode;
use zerorate_core::units::{Axis, Taps};

use crate::client::ClientError;
use crate::following::LeftBehind;
use crate::instruments::InstrumentError;

/// Why a procedure could not be carried through. What had been taken is in the recording.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The device.
    #[error(transparent)]
    Device(#[from] ClientError),
    /// An instrument.
    #[error(transparent)]
    Instrument(#[from] InstrumentError),
    /// A recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A log cannot be read.
    #[error(transparent)]
    Log(#[from] LogError),
    /// No calibration comes of a fit.
    #[error(transparent)]
    Calibration(#[from] CalibrationFault),
    /// What was written cannot be read again.
    #[error(transparent)]
    BoardRun(#[from] BoardRunError),
    /// The recording cannot be written.
    #[error(transparent)]
    NotRecorded(#[from] WriteError),
    /// The board does not rest although it was told to.
    #[error(
        "axis {}: the board is in mode {} at tap {} although it was told off and {}, and what it compensates cannot be measured: switch it off and on; if that does not help, update its firmware", axis.name(), mode.name(), tap.get(), middle.get()
    )]
    NotAtRest {
        /// The axis.
        axis: Axis,
        /// The mode that it is in.
        mode: Mode,
        /// The tap that it was last commanded to.
        tap: Taps,
        /// The tap that it was told.
        middle: Taps,
    },
    /// No tap brings the reading near the centre.
    #[error(
        "axis {}: at a supply of {supply_v:.4} V no tap brings the reading near the centre of {centre_counts:.0} counts: the search ended at tap {} with {reading_counts:.0} counts. Make trim.span_counts smaller, or check the zero-adjust circuit", axis.name(), tap.get()
    )]
    CentreOutOfReach {
        /// The axis.
        axis: Axis,
        /// The supply, volts.
        supply_v: f64,
        /// The centre aimed at, counts.
        centre_counts: f64,
        /// Where the search ended.
        tap: Taps,
        /// The reading there, counts.
        reading_counts: f64,
    },
    /// The unit's recording was rejected.
    #[error("the recording was rejected, and no calibration comes of it: {reasons}. Mend that and record again")]
    Rejected {
        /// The reasons.
        reasons: String,
    },
    /// A ramp was none.
    #[error(
        "the controller started anew during the ramp, or somebody sent it elsewhere: what was recorded is of no ramp, and nothing is made of it"
    )]
    OffCourse,
    /// The board does not follow the chamber's air.
    #[error(transparent)]
    NotInChamber(#[from] LeftBehind),
    /// The A/D saturates.
    #[error(
        "axis {}: the A/D saturates {}: the reading is at the converter's end, and nothing can be measured there. {}", axis.name(), whence, remedy
    )]
    Saturated {
        /// The axis.
        axis: Axis,
        /// When.
        whence: String,
        /// What to do.
        remedy: &'static str,
    },
    /// Every tap moves the reading by nothing that can be seen.
    #[error(
        "axis {}: the wiper does not move the reading ({change_counts:.1} counts for {taps} taps): check the potentiometer's wiring and its SPI", axis.name()
    )]
    WiperDead {
        /// The axis.
        axis: Axis,
        /// How far the reading moved, counts.
        change_counts: f64,
        /// For how many taps.
        taps: u16,
    },
    /// The fit of the drift failed.
    #[error("axis {}: {reason}", axis.name())]
    Fit {
        /// The axis.
        axis: Axis,
        /// What is wrong and what to do.
        reason: String,
    },
    /// The serial does not fit a record.
    #[error("the serial '{0}' is longer than the 32 bytes that a device record holds: give a shorter one")]
    SerialTooLong(String),
    /// Another run is written into the folder.
    #[error("a run goes on in {folder}: wait until it is over, or give this one another folder (`out`)")]
    GoesOn {
        /// The folder.
        folder: String,
    },
    /// The serial has what a board puts for what it cannot read.
    #[error(
        "the serial '{0}' has a '?' in it, which a board puts for what it cannot read in its own, and no board takes a record of such a unit: write the board's serial anew, in ASCII, or give another"
    )]
    SerialUnreadable(String),
    /// The record cannot be composed.
    #[error("{0}")]
    Compose(String),
    /// A run was stopped before, and this one would begin anew.
    #[error(
        "a run that was stopped before its end is in {folder}: go on with it (`resume`), or remove that folder to begin anew"
    )]
    Unfinished {
        /// The run's folder.
        folder: String,
    },
    /// The folder has the results of another unit, and they would be gone.
    #[error("{folder} holds the results of {whose}: give another folder (`out`), or give them up (`force`)")]
    OthersResults {
        /// The folder.
        folder: String,
        /// Whose they are.
        whose: String,
    },
    /// The folder has the results of a real unit, and those of a simulated one would take their place.
    #[error(
        "{folder} holds the results of the real unit {serial}, and simulated ones never take their place: give another folder (`out`)"
    )]
    RealResults {
        /// The folder.
        folder: String,
        /// The real unit.
        serial: String,
    },
    /// The folder has a file that no run has left, and it would be gone.
    #[error(
        "{file} is there and is no run's, and a run writes a file of that name: give another folder (`out`), or give it up (`force`)"
    )]
    NoRuns {
        /// The file.
        file: String,
    },
    /// The run that was stopped is another one.
    #[error(
        "the run in {folder} that was stopped was another unit's or had another set-up: give those, or another folder (`out`)"
    )]
    OtherRun {
        /// The run's folder.
        folder: String,
    },
    /// The board takes other groups than the set-up says.
    #[error(
        "the board takes groups of {samples} samples every {period_us} us, the set-up says otherwise: put acquisition.group_length = {samples} and acquisition.sample_period_us = {period_us} into it"
    )]
    OtherTiming {
        /// Samples a group.
        samples: u16,
        /// Microseconds from sample to sample.
        period_us: u32,
    },
    /// It ended with an error, and what was to be brought to rest is on.
    #[error("{left_on}. Before that: {first}")]
    LeftOn {
        /// Why it ended.
        first: Box<BenchError>,
        /// What is on.
        left_on: InstrumentError,
    },
    /// All was done and written, and what was to be brought to rest is on.
    #[error("all was measured, but {0}")]
    DoneLeftOn(#[source] InstrumentError),
    /// A file cannot be written.
    #[error("cannot write {path}: {source}. Earlier results are untouched")]
    Write {
        /// The file.
        path: String,
        /// What the system says.
        source: std::io::Error,
    },
}

impl BenchError {
    /// Whether a run was refused because of another's in its folder, which it has left as it is.
    #[must_use]
    pub const fn is_refused(&self) -> bool {
        matches!(self, Self::Unfinished { .. } | Self::OtherRun { .. } | Self::GoesOn { .. })
    }

    /// Whether somebody wanted everything to stop.
    #[must_use]
    pub fn is_interrupted(&self) -> bool {
        match self {
            Self::LeftOn { first, .. } => first.is_interrupted(),
            error => matches!(error, Self::Instrument(InstrumentError::Interrupted)),
        }
    }
}
