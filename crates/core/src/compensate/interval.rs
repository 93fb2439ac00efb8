//! A run of temperature codes with one tap.

use serde::{Deserialize, Serialize};

use crate::units::Taps;

/// The most intervals a table holds: at 31 counts a tap, 2000 counts of drift one way, or 1000 up and down again.
pub const MAX_INTERVALS: usize = 64;

/// A run of temperature codes with one nearest tap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Interval {
    /// The first code whose nearest tap this is; the interval ends before the next one's first.
    pub first: u16,
    /// Going colder from this interval, the last code at which the dead band still holds the tap.
    pub hold_down_to: u16,
    /// Going hotter from this interval, the last code at which the dead band still holds the tap.
    pub hold_up_to: u16,
    /// The tap.
    pub tap: Taps,
}
