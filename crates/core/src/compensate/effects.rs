//! What each tap adds to the reading, in integers, and which of two neighbours is the nearer.

use heapless::Vec;

use super::numbers::TrimNumbers;
use super::q16::Q16;
use crate::trim::MAX_TAP_OFFSETS;
use crate::units::Taps;

/// What each tap adds to the reading, in Q16: as measured, and on from the nearer end of what was measured.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct FixedEffects {
    first: Taps,
    /// Empty without a measurement.
    measured: Vec<i32, MAX_TAP_OFFSETS>,
    per_tap: i32,
    intercept: i32,
}

/// The most that one tap moves the reading, Q16: 1024 counts.
const MOST_PER_TAP: i32 = 1 << 26;

/// A side of a tap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Below,
    Above,
}

impl Side {
    pub(super) const BOTH: [Self; 2] = [Self::Above, Self::Below];

    /// The neighbour on this side; `None` at the part's end.
    pub(super) fn of(self, tap: Taps) -> Option<Taps> {
        match self {
            Self::Below => tap.get().checked_sub(1).and_then(Taps::new),
            Self::Above => Taps::new(tap.get() + 1),
        }
    }
}

impl FixedEffects {
    /// `None` when the effects do not rise from tap to tap, go on beyond the part, or do not fit: a tap beside those that were
    /// measured would move the reading by 32 768 counts or more, or the next one by more than [`MOST_PER_TAP`].
    pub(super) fn from_numbers(numbers: &TrimNumbers) -> Option<Self> {
        let TrimNumbers { first, ref effects, per_tap, intercept } = *numbers;
        let is_rising = per_tap > 0 && effects.windows(2).all(|pair| pair[0] < pair[1]);
        let is_in_part = usize::from(first.get()) + effects.len() <= usize::from(Taps::LAST.get()) + 1;
        let all = Self { first, measured: effects.clone(), per_tap, intercept };
        let last = i32::from(first.get()) + i32::try_from(effects.len().saturating_sub(1)).ok()?;
        let beside = [i32::from(first.get()) - 1, last + 1];
        let mut beside = beside.into_iter().filter_map(|tap| u16::try_from(tap).ok().and_then(Taps::new));
        let fits = per_tap <= MOST_PER_TAP && beside.all(|tap| i32::try_from(all.whole(tap)).is_ok());
        (is_rising && is_in_part && fits).then_some(all)
    }

    /// The first tap measured.
    #[inline]
    pub(super) const fn first(&self) -> Taps {
        self.first
    }

    /// The effects of the first tap measured and of those after it, more than were measured; past the part's end nothing.
    pub(super) fn near(&self) -> [i32; MAX_TAP_OFFSETS] {
        let mut effects = [0; MAX_TAP_OFFSETS];
        for (slot, tap) in effects.iter_mut().zip((self.first.get()..).map_while(Taps::new)) {
            *slot = self.get(tap).0;
        }
        effects
    }

    #[inline]
    pub(super) fn get(&self, tap: Taps) -> Q16 {
        self.measured.get(tap.after(self.first)).map_or_else(|| self.beyond(tap), |&effect| Q16(effect))
    }

    /// The effect of a tap that was not measured; of one that would take any reading out of the converter no more than fits.
    #[cold]
    #[inline(never)]
    fn beyond(&self, tap: Taps) -> Q16 {
        let whole = self.whole(tap);
        Q16(i32::try_from(whole).unwrap_or(if whole < 0 { i32::MIN } else { i32::MAX }))
    }

    /// The effect of a tap, whether it fits or not.
    fn whole(&self, tap: Taps) -> i64 {
        let offset = i64::from(tap.get()) - i64::from(self.first.get());
        let nearest = usize::try_from(offset).unwrap_or(0).min(self.measured.len().saturating_sub(1));
        let measured = self.measured.get(nearest).copied().unwrap_or(0);
        let left = usize::from(tap.get()).abs_diff(usize::from(self.first.get()) + nearest);
        let beyond = i64::try_from(left).unwrap_or(0) * i64::from(self.per_tap);
        i64::from(measured) + if offset < 0 { -beyond } else { beyond }
    }

    /// How far the taps are from bringing a drift to the centre, when one of them has been commanded: beyond the middle
    /// between it and its neighbour, and a `band` of their distance (Q16) further; positive towards the neighbour, in
    /// halves of a Q16 count. Past the part's end a neighbour would be a slope's tap away.
    pub(super) fn past_middle(&self, tap: Taps, side: Side, drift_from_centre: i32, band: i32) -> i64 {
        let effect = i64::from(self.get(tap).0);
        let distance = match side.of(tap) {
            Some(neighbour) => (i64::from(self.get(neighbour).0) - effect).abs(),
            None => i64::from(self.per_tap),
        };
        let wanted = i64::from(self.intercept) - i64::from(drift_from_centre) - effect;
        let towards = if side == Side::Above { wanted } else { -wanted };
        2 * towards - distance - ((2 * distance * i64::from(band)) >> 16)
    }
}
