//! What of a compensator is large.

use heapless::Vec;
use zerorate_core::compensate::AxisLaw;
use zerorate_core::units::Axis;

use super::outbox::Outbox;
use super::scans::ScanByScan;
use crate::acquisition::Set;

/// What of a compensator is large: laws, sets, what waits to be said. A board has it as a static, so that it is never made on the
/// stack and moved; a home with room gives it by value.
///
/// Before it is used all of it is zeros, so that a static of it takes no flash.
pub struct Memory {
    /// One a axis, or none.
    pub(super) laws: [Vec<AxisLaw, 1>; 2],
    pub(super) set: Set,
    pub(super) scans: ScanByScan,
    pub(super) outbox: Outbox,
}

impl Memory {
    /// Memory that has not been used.
    #[must_use]
    pub const fn new() -> Self {
        Self { laws: [Vec::new(), Vec::new()], set: Set::new(), scans: ScanByScan::new(), outbox: Outbox::new() }
    }

    pub(super) fn law(&self, axis: Axis) -> Option<&AxisLaw> {
        self.laws[axis.index()].first()
    }
}

impl Default for Memory {
    fn default() -> Self {
        Self::new()
    }
}
