//! Commands on their way to the compensator.

use zerorate_core::compensate::Mode;
use zerorate_core::units::{Axis, GroupNumber, Taps};
use zerorate_core::wire::{Request, SampleWindow};

/// A command on its way to the compensator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scheduled {
    /// The host's number for it.
    pub sequence: u16,
    /// The first group for which it is to hold; `None`: the next one.
    pub at: Option<GroupNumber>,
    /// What to do.
    pub action: Action,
}

/// What a command asks of the compensator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// Changes an axis's mode.
    SetMode(Axis, Mode),
    /// Writes a wiper.
    SetTap(Axis, Taps),
    /// Makes the present taps those of power-up.
    StorePowerUpTap,
    /// Puts the wipers where power-up would put them, and both axes off.
    RecallPowerUpTap,
    /// Starts the acquisition anew, or stops it.
    SetAcquisition(bool),
    /// Which samples are reported.
    SetSamples(SampleWindow),
}

impl Action {
    /// What of a request is the compensator's; `None` where all of it is the console's.
    #[must_use]
    pub const fn of(request: &Request) -> Option<Self> {
        Some(match *request {
            Request::SetMode { axis, mode } => Self::SetMode(axis, mode),
            Request::SetTap { axis, tap } => Self::SetTap(axis, tap),
            Request::StorePowerUpTap => Self::StorePowerUpTap,
            Request::RecallPowerUpTap => Self::RecallPowerUpTap,
            Request::SetAcquisition { run } => Self::SetAcquisition(run),
            Request::SetStream { samples, .. } => Self::SetSamples(samples),
            Request::Identity
            | Request::Faults
            | Request::Stop
            | Request::Health
            | Request::ReadCalibration { .. }
            | Request::WriteCalibration { .. }
            | Request::CommitCalibration { .. } => return None,
        })
    }

    /// Whether it changes how a group is taken, and so waits for the next.
    pub(super) const fn waits_for_a_group(self) -> bool {
        matches!(self, Self::SetMode(..) | Self::SetTap(..) | Self::StorePowerUpTap | Self::RecallPowerUpTap)
    }
}
