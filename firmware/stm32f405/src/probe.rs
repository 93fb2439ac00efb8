//! What a board says to a debug probe: lines of text by RTT, in memory that a probe reads while the program runs. `probe-rs run`
//! shows what a start has found. Nobody waits for a probe: what there is no place for is dropped.

use rtt_target::ChannelMode::NoBlockSkip;
use rtt_target::{UpChannel, rtt_init};
use zerorate_core::wire::{CalibrationState, Identity, ResetCause, Stop};
use zerorate_device::restart::Started;

/// The lines. No formatting of `core`, which takes a fifth of the flash that there is: text goes out as it is.
pub struct Probe(UpChannel);

impl Probe {
    /// Ready for lines; to be called once.
    pub fn new() -> Self {
        let channels = rtt_init! { up: { 0: { size: 512, mode: NoBlockSkip, name: "Terminal" } } };
        Self(channels.up.0)
    }

    fn line(&mut self, parts: &[&str]) {
        for part in parts {
            self.0.write(part.as_bytes());
        }
        self.0.write(b"\n");
    }

    /// Why it started, at once: what comes after may fail.
    pub fn started(&mut self, started: &Started) {
        let cause = match started.reset {
            ResetCause::Power => "power came",
            ResetCause::Watchdog => "the watchdog was not fed",
            ResetCause::Panic => "the program stopped itself",
            ResetCause::Fault => "the processor could not go on",
            ResetCause::BrownOut => "the supply fell",
            ResetCause::Software => "a reset was asked for",
            ResetCause::Pin => "the reset pin",
        };
        self.line(&["zerorate ", env!("CARGO_PKG_VERSION"), " starts: ", cause]);
        if started.restarts > 0 {
            self.line(&["restarts since power came: ", itoa::Buffer::new().format(started.restarts)]);
        }
        match &started.stop {
            Some(Stop::Panic { file, line }) => {
                self.line(&["it stopped itself last at ", file, ":", itoa::Buffer::new().format(*line)]);
            }
            Some(Stop::Fault(_)) => self.line(&["it could not go on last: `zerorate device info` has the registers"]),
            None => {}
        }
    }

    /// What it found.
    pub fn found(&mut self, identity: &Identity) {
        match identity.unit.as_str() {
            "" => self.line(&["no serial: any unit's record is taken"]),
            serial => self.line(&["unit ", serial]),
        }
        let record = match identity.calibration {
            CalibrationState::InUse => "in use",
            CalibrationState::OlderInUse => "the latest is damaged, the one before it is in use",
            CalibrationState::Blank => "none was ever stored",
            CalibrationState::Damaged => "damaged",
            CalibrationState::UnknownVersion { .. } => "of a version that this program does not know",
            CalibrationState::OtherUnit => "another unit's",
            CalibrationState::LawRefused => "its numbers make no law",
            CalibrationState::Unreachable => "the flash does not answer",
            CalibrationState::SetAside => "set aside: the program failed with it three times in a row",
        };
        let work = if identity.running { "groups are taken" } else { "it waits for a host" };
        self.line(&["record: ", record, "; ", work]);
    }
}
