//! What a device says of itself, in words for people: what happened, and what to do about it.

use zerorate_core::wire::{CalibrationState, Refusal, ResetCause};

/// Why a command was not done.
pub(crate) fn of_refusal(refusal: &Refusal) -> String {
    let words = match refusal {
        Refusal::Record(error) => return error.to_string(),
        Refusal::NoCalibration => "the device has no calibration: deploy one first",
        Refusal::NoEdges => "this calibration cannot move the wiper (its drift needs too many taps): use mode digital",
        Refusal::TrimPartFailed => "the potentiometer could not be written: check its SPI wiring",
        Refusal::AcquisitionFailed => "the acquisition port does not answer: check its SPI wiring",
        Refusal::Busy => "too many commands are waiting: send it again later",
        Refusal::OutOfBuffer => "the record is longer than the device can hold",
        Refusal::OtherUnit => "the record belongs to a unit of another serial",
        Refusal::LawRefused => "the device cannot run the record's law: compose it again",
        Refusal::StoreFailed => "the device could not store the record: its flash has failed",
        Refusal::Stopped => "the acquisition was stopped before the command's group came: send it again",
    };
    words.into()
}

/// Whether a calibration is in use, and why not.
pub(crate) fn of_calibration(state: CalibrationState) -> String {
    let words = match state {
        CalibrationState::UnknownVersion { found } => {
            return format!(
                "a record of version {found}, which the firmware does not know, so it runs uncompensated: make the record anew from calibration.json and deploy it"
            );
        }
        CalibrationState::InUse => "in use",
        CalibrationState::OlderInUse => "the one before the last is in use, the last one is damaged: deploy it again",
        CalibrationState::Blank => "none stored, the device runs uncompensated: deploy one",
        CalibrationState::Damaged => "damaged, the device runs uncompensated: deploy it again",
        CalibrationState::OtherUnit => {
            "another unit's record is stored, the device runs uncompensated: deploy this unit's"
        }
        CalibrationState::LawRefused => {
            "the stored record's law cannot be run, the device runs uncompensated: compose it again"
        }
        CalibrationState::SetAside => {
            "set aside: the firmware stopped three times in a row with it, and runs uncompensated until it is switched off and on or another is deployed"
        }
        CalibrationState::Unreachable => {
            "the flash does not answer, the device runs uncompensated: check the flash's wiring"
        }
    };
    words.into()
}

/// Why a device started last.
pub(crate) const fn of_reset(cause: ResetCause) -> &'static str {
    match cause {
        ResetCause::Power => "power on",
        ResetCause::Watchdog => "restarted by the watchdog: sets stopped coming, or the program hung",
        ResetCause::Panic => "restarted after a panic of its program",
        ResetCause::Fault => "restarted after a fault of its processor",
        ResetCause::BrownOut => "its processor's supply had fallen too low: check the supply and its wiring",
        ResetCause::Software => "restarted by a debugger",
        ResetCause::Pin => "reset by its reset pin",
    }
}
