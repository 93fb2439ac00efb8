//! A piecewise-linear table over evenly spaced temperatures.

use heapless::Vec;

use super::scale::Scale;

/// The most knots a table holds: 32 pieces.
pub const MAX_KNOTS: usize = 33;
/// The most temperatures at which a drift model can turn round: one for each inner knot of the longest table.
pub const MAX_TURNING_POINTS: usize = MAX_KNOTS - 2;

/// Readings at evenly spaced temperatures from `x = -1` to `x = 1`, straight lines between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    scale: Scale,
    knots: Vec<f64, MAX_KNOTS>,
}

impl Table {
    /// A table by its readings, coldest first. `None` unless there are 2 to 33 and all are finite.
    #[must_use]
    pub fn new(scale: Scale, knots: &[f64]) -> Option<Self> {
        if knots.len() < 2 || !knots.iter().all(|k| k.is_finite()) {
            return None;
        }
        Some(Self { scale, knots: Vec::from_slice(knots).ok()? })
    }

    pub(super) fn lowered(&self, by: f64) -> Self {
        let mut lowered = self.clone();
        lowered.knots.iter_mut().for_each(|knot| *knot -= by);
        lowered
    }

    /// The span that the knots cover.
    #[must_use]
    pub const fn scale(&self) -> Scale {
        self.scale
    }

    /// The readings at the knots, coldest first.
    #[must_use]
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// The temperature of a knot.
    #[must_use]
    pub fn knot_temperature(&self, index: usize) -> f64 {
        self.scale.temperature(2.0 * as_f64(index) / as_f64(self.knots.len() - 1) - 1.0)
    }

    /// The reading at a temperature, held at the end knots beyond them. NaN gives NaN.
    #[must_use]
    pub fn evaluate(&self, temperature: f64) -> f64 {
        let pieces = self.knots.len() - 1;
        let position = 0.5 * (self.scale.x(temperature).clamp(-1.0, 1.0) + 1.0) * as_f64(pieces);
        // As an index NaN becomes 0; the position itself carries it through.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let piece = (position as usize).min(pieces - 1);
        self.knots[piece] + (self.knots[piece + 1] - self.knots[piece]) * (position - as_f64(piece))
    }

    /// The knots strictly between `min` and `max` at which the curve turns round, coldest first.
    #[must_use]
    pub fn turning_points(&self, min: f64, max: f64) -> Vec<f64, MAX_TURNING_POINTS> {
        // A level piece belongs to the slope before it, so that the turn is found where the level ends.
        let mut before = 0.0;
        let mut found = Vec::new();
        for (index, pair) in self.knots.windows(2).enumerate() {
            let slope = pair[1] - pair[0];
            let at = self.knot_temperature(index);
            if slope * before < 0.0 && min < at && at < max {
                let _ = found.push(at);
            }
            if slope != 0.0 {
                before = slope;
            }
        }
        found
    }
}

fn as_f64(index: usize) -> f64 {
    // Knots are few: the cast is exact.
    #[allow(clippy::cast_precision_loss)]
    {
        index as f64
    }
}
