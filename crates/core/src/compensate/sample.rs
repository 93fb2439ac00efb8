//! Samples corrected one by one, beside the group that they add up to.

use super::q16::Q16;
use super::settling::Settling;

/// A step of the wiper that is still on its way is one of which more than this is missing: a count.
const SETTLED: u32 = 1 << 16;

/// What corrects single samples: the correction of the last closed group, and the wiper as far as it has settled. It is taken
/// from [`AxisCompensation`](super::AxisCompensation) where a group begins, and leaves it as it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleCorrection {
    settling: Settling,
    /// `V(T) - V0`, Q16; `None` where nothing is subtracted.
    drift_from_centre: Option<i32>,
}

impl SampleCorrection {
    /// Nothing is corrected.
    pub const NONE: Self = Self { settling: Settling::NONE, drift_from_centre: None };

    pub(super) const fn new(settling: Settling, drift_from_centre: Option<i32>) -> Self {
        Self { settling, drift_from_centre }
    }

    /// The next sample, corrected.
    pub fn correct(&mut self, zro: u16) -> Q16 {
        corrected(zro, self.drift_from_centre, self.settling.next_sample())
    }

    /// Passes over so many samples.
    pub fn skip(&mut self, n: u32) {
        let _ = self.settling.next_samples(n);
    }

    /// Whether the wiper's last step is still on its way at the next sample.
    #[must_use]
    pub const fn is_settling(&self) -> bool {
        self.settling.missing().unsigned_abs() > SETTLED
    }
}

/// A reading without drift and effect; the plain one where no drift is known that is to be subtracted. Of a converter of 16 bits
/// a reading takes the sign's bit too, so sums wrap: what is given is so many counts less 65 536 then ([`Q16::near`]).
pub(super) fn corrected(zro: u16, drift_from_centre: Option<i32>, effect: Q16) -> Q16 {
    let reading = (u32::from(zro) << 16).cast_signed();
    Q16(match drift_from_centre {
        Some(drift) => reading.wrapping_sub(drift).wrapping_sub(effect.0),
        None => reading,
    })
}
