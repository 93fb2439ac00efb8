//! A run of temperature codes, and whether a code is in it by one subtraction and one compare.

use crate::units::TemperatureCode;

/// A run of temperature codes, or none.
///
/// All of it is in the upper half of a word: there a code's own upper half, which may hold anything, is shifted out by the
/// subtraction itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Codes {
    first: u32,
    /// How many follow the first, and a bit more: below it is nothing.
    length: u32,
}

impl Codes {
    pub(super) const NONE: Self = Self { first: 0, length: 0 };
    pub(super) const ALL: Self = Self { first: 0, length: u32::MAX };

    /// From a code to another that is not below it, both included.
    pub(super) fn between(first: u16, last: u16) -> Self {
        Self { first: u32::from(first) << 16, length: u32::from(last.wrapping_sub(first)) << 16 | 1 }
    }

    /// How far from the first one a code is, in the upper half; `None` of one that is not in the run: below the first the
    /// difference wraps to more than any run.
    #[inline(always)]
    pub(super) fn place(self, code: TemperatureCode) -> Option<u32> {
        let place = (u32::from(code.0) << 16).wrapping_sub(self.first);
        (place < self.length).then_some(place)
    }
}
