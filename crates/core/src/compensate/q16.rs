//! Counts in fixed point.

/// A number of counts in steps of 1/65536.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Q16(pub i32);

impl Q16 {
    /// The nearest step to a number of counts; `None` at or beyond +-32768 counts, and for NaN.
    #[must_use]
    pub fn from_counts(counts: f64) -> Option<Self> {
        to_fixed(counts, 16).map(Self)
    }

    /// As counts.
    #[must_use]
    pub fn to_counts(self) -> f64 {
        f64::from(self.0) / 65_536.0
    }

    /// As counts, of a number that is known but for so many times 65 536 counts: the one nearest a reading. A corrected
    /// reading is within half of that of the reading itself.
    #[must_use]
    pub fn near(self, reading: f64) -> f64 {
        let counts = self.to_counts();
        let turns = libm::round((reading - counts) / 65_536.0);
        if turns.is_finite() { counts + 65_536.0 * turns } else { counts }
    }
}

/// The nearest fixed-point number with so many fractional bits; `None` when it does not fit.
pub(super) fn to_fixed(value: f64, fraction_bits: u32) -> Option<i32> {
    let scaled = libm::round(value * f64::from(1_u32 << fraction_bits));
    if !(f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&scaled) {
        return None;
    }
    #[allow(clippy::cast_possible_truncation)]
    Some(scaled as i32)
}
