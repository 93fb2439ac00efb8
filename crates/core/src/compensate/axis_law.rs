//! One axis's law as a device runs it: its numbers, checked.

use super::dynamic::FixedHistory;
use super::edges::EdgeTable;
use super::effects::{FixedEffects, Side};
use super::fixed::FixedDrift;
use super::numbers::{HistoryNumbers, LawNumbers, LowPassNumbers};
use super::q16::Q16;
use super::refused::{LawRefused, Part};
use crate::drift::Coverage;
use crate::trim::MAX_TAP_OFFSETS;
use crate::units::{Taps, TemperatureCode};

/// An axis's law in the form that the device runs: integers and a table. It does not change while it is in use.
#[derive(Debug, Clone, PartialEq)]
// What a correction fetches by an index stands first: its place needs no addition.
#[repr(C)]
pub struct AxisLaw {
    /// The effects near the first tap measured and the drift's constant, added up beforehand.
    constants: [i32; MAX_TAP_OFFSETS],
    pub(super) drift: FixedDrift,
    pub(super) edges: Option<EdgeTable>,
    pub(super) effects: FixedEffects,
    pub(super) low_pass: LowPassNumbers,
    dead_band: i32,
    /// What makes the law dynamic; `None` where the drift is a function of temperature alone.
    pub(super) history: Option<FixedHistory>,
}

/// How far the drift may be past the middle between two taps where a table changes from one to the other, in halves of a
/// Q16 count: half a count, as far as the integers may be off the drift that the table was solved for. A tap that is
/// believed leaves the reading at most a count further from the centre than its neighbour would.
const EDGE_TOLERANCE: i64 = 1 << 16;

impl AxisLaw {
    /// The law by its stored numbers, none of which is believed. A CRC tells a record that was damaged on its way; this is
    /// for one that was composed wrongly, of another version's parts, or by chance has the right CRC. The drift must fit at
    /// every code, the effects must rise within the part, and the table of edges must be in order and agree with drift,
    /// effects, centre and dead band, by the integers that will be run, at both sides of every edge. (Between its edges a table
    /// is believed: the host has solved it for every code.)
    ///
    /// # Errors
    /// [`LawRefused`], with the part that is wrong.
    pub fn from_numbers(numbers: &LawNumbers) -> Result<Self, LawRefused> {
        let mut drift = FixedDrift::from_numbers(&numbers.drift).ok_or(LawRefused::Senseless(Part::Drift))?;
        let effects = FixedEffects::from_numbers(&numbers.trim).ok_or(LawRefused::Senseless(Part::Trim))?;
        if !(0..=1 << 16).contains(&numbers.dead_band) {
            return Err(LawRefused::Senseless(Part::DeadBand));
        }
        let constants = effects.near().map(|effect| effect.checked_add(drift.constant()));
        if constants.contains(&None) {
            drift.never_quickly();
        }
        let mut law = Self {
            constants: constants.map(Option::unwrap_or_default),
            drift,
            edges: numbers.edges.clone(),
            effects,
            low_pass: numbers.low_pass,
            dead_band: numbers.dead_band,
            history: None,
        };
        if let Some(edges) = &law.edges {
            let band = |is_held| if is_held { law.dead_band } else { 0 };
            let checked = edges.check_by(|tap, code, is_held| law.strays(tap, code, band(is_held)));
            checked.map_err(LawRefused::Edges)?;
        }
        if let Some(history) = &numbers.history {
            law.history = Some(law.checked_history(history)?);
        }
        Ok(law)
    }

    fn checked_history(&self, numbers: &HistoryNumbers) -> Result<FixedHistory, LawRefused> {
        let (first, last) = self.drift.range();
        let history = FixedHistory::from_numbers(numbers, first.0, last.0, self.dead_band);
        history.ok_or(LawRefused::Senseless(Part::History))
    }

    /// Whether at a code the tap is further from the centre than half the way to a neighbour, a band of the way, and
    /// [`EDGE_TOLERANCE`].
    fn strays(&self, tap: Taps, code: TemperatureCode, band: i32) -> bool {
        let drift = self.drift_from_centre(code);
        Side::BOTH.into_iter().any(|side| self.effects.past_middle(tap, side, drift, band) > EDGE_TOLERANCE)
    }

    /// Whether the law can move the wiper.
    #[must_use]
    pub const fn moves_wiper(&self) -> bool {
        self.edges.is_some()
    }

    /// What is to be subtracted from a settled reading: `V(T) + effect(N) - V0`, in integers.
    #[must_use]
    #[inline]
    pub fn correction(&self, code: TemperatureCode, tap: Taps) -> Q16 {
        if let Some(constant) = self.constants.get(tap.after(self.effects.first()))
            && let Some(drift) = self.drift.quickly(code)
        {
            return Q16(drift.saturating_add(*constant));
        }
        self.rare_correction(code, tap)
    }

    /// The same of a tap that was not measured, or by a drift of a rare form.
    #[cold]
    #[inline(never)]
    fn rare_correction(&self, code: TemperatureCode, tap: Taps) -> Q16 {
        Q16(self.drift.evaluate(code).0.saturating_add(self.effects.get(tap).0))
    }

    #[inline]
    pub(super) fn drift_from_centre(&self, code: TemperatureCode) -> i32 {
        self.drift.evaluate(code).0
    }

    pub(super) fn coverage(&self, code: TemperatureCode) -> Coverage {
        let (first, last) = self.drift.range();
        if code < first {
            Coverage::Below
        } else if code > last {
            Coverage::Above
        } else {
            Coverage::Inside
        }
    }
}
