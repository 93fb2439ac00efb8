//! What there is to say of a log that was read.

use std::fmt;

use crate::Sensor;

/// One thing to know of a log. Its text is a sentence for people.
#[derive(Debug, Clone, PartialEq)]
pub enum Remark {
    /// The file ends in the middle of a message.
    Cut {
        /// Where that message begins, bytes from the beginning of the file.
        at: u64,
    },
    /// Bytes that are no message.
    Damaged {
        /// How many.
        bytes: u64,
    },
    /// Rows of a time or a temperature that none can be.
    Impossible {
        /// How many.
        rows: u64,
    },
    /// Time begins anew in the file.
    SeveralLogs {
        /// How often.
        restarts: u32,
    },
    /// Rows whose time is a little before that of the row above.
    Disordered {
        /// The sensor.
        sensor: Sensor,
        /// How many.
        rows: u64,
    },
    /// More sensors than any vehicle has.
    TooManySensors {
        /// How many were read.
        most: usize,
        /// Rows of the others.
        rows: u64,
    },
    /// The logger could not keep up.
    Dropouts {
        /// How often.
        times: u64,
        /// What it lost in all.
        lost_s: f64,
    },
    /// The log has flags of a newer version of the format.
    NewerFormat,
    /// The log has no readings, only the means by which the autopilot learned.
    LearningOnly {
        /// How many means.
        means: u64,
    },
    /// A temperature calibration that was active in the log was undone.
    CalibrationUndone {
        /// The autopilot's number of the IMU, from 1.
        imu: u8,
    },
    /// A temperature calibration was switched within the log.
    CalibrationSwitched {
        /// The autopilot's number of the IMU, from 1.
        imu: u8,
    },
    /// The readings were turned back from the board's axes to the sensors' own.
    TurnedBack,
    /// Offsets that the autopilot had taken off were added again.
    OffsetsRestored,
    /// The board's orientation is none that has fixed angles.
    UnknownOrientation {
        /// Its number.
        orientation: f64,
    },
}

impl Remark {
    /// Whether a part of the file was lost.
    #[must_use]
    pub fn is_damage(&self) -> bool {
        matches!(self, Self::Cut { .. } | Self::Damaged { .. } | Self::Impossible { .. })
    }
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cut { at } => {
                write!(f, "the file is cut off in the middle of a message, at byte {at}: what is before it was read")
            }
            Self::Damaged { bytes } => {
                write!(f, "{bytes} bytes of the file are damaged and were passed over: the rest was read")
            }
            Self::Impossible { rows } => write!(
                f,
                "{rows} rows have a time or a temperature that none can be: the file is damaged there, and they were left out"
            ),
            Self::SeveralLogs { restarts } => write!(
                f,
                "time begins anew {restarts} times in the file: it holds {} logs, which were taken one after the other",
                restarts + 1
            ),
            Self::Disordered { sensor, rows } => {
                write!(f, "{sensor}: {rows} rows whose time is before that of the row above were left out")
            }
            Self::TooManySensors { most, rows } => {
                write!(f, "the log names more than {most} sensors: {rows} rows of the others were passed over")
            }
            Self::Dropouts { times, lost_s } => write!(
                f,
                "the logger could not keep up {times} times and lost {lost_s:.1} s in all: a faster card, or fewer messages"
            ),
            Self::NewerFormat => f.write_str("the log has flags of a newer format: what is known of it was read"),
            Self::LearningOnly { means } => {
                write!(
                    f,
                    "the log has no IMU readings: the {means} means that the autopilot's own learning logged were taken"
                )
            }
            Self::CalibrationUndone { imu } => {
                write!(f, "IMU {imu}: the temperature calibration that was active in the log was undone")
            }
            Self::CalibrationSwitched { imu } => write!(
                f,
                "IMU {imu}: its temperature calibration was switched in the log: the readings from then on were left out"
            ),
            Self::TurnedBack => {
                f.write_str("the readings were turned back from AHRS_ORIENTATION to the sensors' own axes")
            }
            Self::OffsetsRestored => f.write_str("the offsets that the autopilot had taken off were restored"),
            Self::UnknownOrientation { orientation } => write!(
                f,
                "AHRS_ORIENTATION {orientation} has no fixed angles: the readings were left in the board's axes, and parameters made from them would be wrong"
            ),
        }
    }
}
