//! What the compensator says of itself.

use zerorate_core::compensate::Mode;
use zerorate_core::units::{GroupNumber, Taps};
use zerorate_core::wire::{FaultCounts, GroupReport, Refusal, SampleBlock};

/// What came of a command, and the first group for which it holds.
pub type Outcome = (GroupNumber, Result<(), Refusal>);

/// What the compensator has to say.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant)] // a queue on a device holds them by value
pub enum Report {
    /// What came of the command with the host's number for it.
    Done(u16, Outcome),
    /// A closed group.
    Group(GroupReport),
    /// Some of a group's samples.
    Samples(SampleBlock),
}

/// What the task below the interrupt may look at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status {
    /// The group that is being filled, or the first that will be.
    pub group: GroupNumber,
    /// Whether groups are being taken.
    pub running: bool,
    /// Sets that have arrived since start-up, for the watchdog.
    pub sets: u32,
    /// The last commanded taps.
    pub taps: [Taps; 2],
    /// The modes.
    pub modes: [Mode; 2],
    /// The compensator's part of the fault counters.
    pub faults: FaultCounts,
}
