//! What each tap of the working range adds to the reading, from one sweep at one supply voltage.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use zerorate_core::trim::{MAX_TAP_OFFSETS, TapEffects};
use zerorate_core::units::{Counts, Taps};

use super::TrimFitError;

/// The reading at one tap, the supply unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TapReading {
    /// The tap.
    pub tap: Taps,
    /// The reading there.
    pub reading: Counts,
}

/// Each tap's reading less the middle tap's.
///
/// The sweep may run in either direction, and a tap read more than once counts by its mean. The taps must follow each
/// other without a gap; only the middle tap may lie apart from the others, where the drift never comes near it.
///
/// # Errors
/// [`TrimFitError`], when the sweep is empty, has a gap or too many taps, lacks the middle tap, or a reading is not a
/// number.
pub fn tap_effects(sweep: &[TapReading], middle: Taps) -> Result<TapEffects, TrimFitError> {
    let means = means(sweep)?;
    let (Some((&first, _)), Some((&last, _))) = (means.first_key_value(), means.last_key_value()) else {
        return Err(TrimFitError::EmptySweep);
    };
    let reference = *means.get(&middle.get()).ok_or(TrimFitError::NoMiddle { middle: middle.get(), first, last })?;
    let run = match gap(&means) {
        None => means,
        Some(tap) => {
            let mut rest = means;
            rest.remove(&middle.get());
            // Without the middle tap a gap that it closed would open: then the first one found is the one to name.
            if gap(&rest).is_some() {
                return Err(TrimFitError::Gap { tap });
            }
            rest
        }
    };
    let first = run.keys().next().and_then(|&tap| Taps::new(tap)).ok_or(TrimFitError::EmptySweep)?;
    if run.len() > MAX_TAP_OFFSETS {
        return Err(TrimFitError::TooManyTaps { found: run.len() });
    }
    let effects: Vec<Counts> = run.values().map(|reading| Counts(reading - reference)).collect();
    let falls = effects.windows(2).position(|pair| pair[1].0 <= pair[0].0);
    let tap = falls.map_or(first.get(), |place| first.get() + u16::try_from(place).unwrap_or(0));
    TapEffects::new(first, &effects).ok_or(TrimFitError::NotRising { tap })
}

/// The mean reading of each tap, counts.
fn means(sweep: &[TapReading]) -> Result<BTreeMap<u16, f64>, TrimFitError> {
    let mut sums: BTreeMap<u16, (f64, u32)> = BTreeMap::new();
    for TapReading { tap, reading } in sweep {
        if !reading.0.is_finite() {
            return Err(TrimFitError::SweepNotFinite { tap: tap.get() });
        }
        let (sum, count) = sums.entry(tap.get()).or_default();
        *sum += reading.0;
        *count += 1;
    }
    Ok(sums.into_iter().map(|(tap, (sum, count))| (tap, sum / f64::from(count))).collect())
}

/// The first tap missing between the first and the last.
fn gap(taps: &BTreeMap<u16, f64>) -> Option<u16> {
    taps.keys().zip(taps.keys().skip(1)).find(|(tap, next)| **tap + 1 != **next).map(|(tap, _)| tap + 1)
}
