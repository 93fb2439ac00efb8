//! One model whose strength the data settle: a curve, memories, and what belongs to the recording alone.
//!
//! A part of what drifts may be at another temperature than its sensor, behind it ([`columns::Before`]): what that adds is the
//! curve there less the curve here, so the curve is found first, and then anew with those columns.
//!
//! A group's rate is a sum of columns ([`columns`]) plus noise that is white and besides wanders ([`noise`]). Level and slope
//! are free; the coefficients of every other kind are drawn from a normal distribution about zero with a spread of their
//! kind. The spreads, and those of the noise, are the ones that make the data likeliest ([`marginal`], [`search`]), weak priors
//! on their logarithms with them: what the data do not tell shrinks to nothing by itself, without folds and without
//! thresholds. A group that is far off counts as one with more noise (Huber).

mod averages;
mod columns;
mod deployed;
mod marginal;
mod memories;
mod noise;
mod search;
mod start_up;

use zerorate_core::drift::ValidRange;

use crate::model_fit::ModelFit;
use crate::robust::HUBER;
use crate::series::Series;
use averages::Averages;
use columns::{Before, Columns, Slow};
use marginal::Evaluated;
use memories::Memories;
use noise::Whitened;
pub(crate) use search::Found;

/// How often the noise of rows is looked at again; after the second time nothing moves.
const ROUNDS: usize = 2;

/// By how much a straight drift in time must be the likelier, natural logarithm: twenty to one, strong evidence (Kass and
/// Raftery, *Bayes factors*, 1995). What follows switching on dies away in most gyros, and of one cycle a model with a straight
/// line too easily takes hysteresis for time.
const STRONG: f64 = 3.0;

/// Columns, and what is the likeliest of them.
pub(crate) type Likeliest<'a> = (Evidence<'a>, Found);

/// A series with its columns.
pub(crate) struct Evidence<'a> {
    series: &'a Series<'a>,
    columns: Columns,
}

impl<'a> Evidence<'a> {
    /// The columns of a series whose used rates span `measured`, the curve believed over `valid`, and what is found of them:
    /// with a straight drift in time where there is strong evidence of one. Where lags can be told, the same once more with
    /// parts that are behind.
    pub(crate) fn likeliest(
        series: &'a Series<'a>,
        measured: ValidRange,
        valid: ValidRange,
    ) -> Option<(Likeliest<'a>, Option<Likeliest<'a>>)> {
        let memories = Memories::of(series, measured, valid);
        let searched = |slow, before, near: Option<&Found>| {
            let columns = Columns::new(series, measured, valid, &memories, slow, before)?;
            Searched::of(Self { series, columns }, near)
        };
        let together = |slow| searched(slow, None, None);
        // With new columns the likeliest spreads may be quite others; with a better curve they are no longer.
        let behind = |slow, together: &Searched<'a>| {
            let first = searched(slow, Some(together.curve()?), None)?;
            searched(slow, Some(first.curve()?), Some(&first.found))
        };
        let (dying, straight) = (together(Slow::Dying)?, together(Slow::Straight));
        let with_parts_behind = dying.evidence.columns.has_lags().then(|| {
            let straight = straight.as_ref().and_then(|straight| behind(Slow::Straight, straight));
            Some(Searched::likelier(behind(Slow::Dying, &dying)?, straight))
        });
        Some((Searched::likelier(dying, straight), with_parts_behind.flatten()))
    }

    /// Fits the groups that `keep` keeps, from what was `found` of all on. `None` where there is nothing to be fitted.
    pub(crate) fn fit(&self, found: &Found, keep: impl Fn(usize) -> bool) -> Option<ModelFit> {
        let (averages, _, evaluated) = self.search(Some(found), keep)?;
        deployed::model(&self.columns, &averages, &evaluated)
    }

    /// The rows of the groups that `keep` keeps, and the likeliest noise and spreads. What was `found` of nearly the same data
    /// is where the search begins.
    fn search(&self, found: Option<&Found>, keep: impl Fn(usize) -> bool) -> Option<(Averages, Found, Evaluated)> {
        let mut averages = Averages::new(self.series, &self.columns, keep)?;
        let (mut found, mut evaluated) = match found {
            Some(near) => near.search_nearby(&self.columns, &averages)?,
            None => Found::search(&self.columns, &averages)?,
        };
        let white = averages.variance.clone();
        for _ in 0..ROUNDS {
            if !self.doubt_outliers(&mut averages, &white, &found, &evaluated) {
                break;
            }
            (found, evaluated) = found.search_nearby(&self.columns, &averages)?;
        }
        Some((averages, found, evaluated))
    }

    /// Gives rows that are far off the variance that makes them less so; whether any changed.
    fn doubt_outliers(&self, averages: &mut Averages, white: &[f64], found: &Found, evaluated: &Evaluated) -> bool {
        /// A change of a variance that is not worth another search.
        const SAME: f64 = 0.1;
        let whitened = Whitened::new(averages, found.wander);
        let width = self.columns.kinds.len();
        let sigma = libm::exp(found.spreads.white);
        let mut changed = false;
        for (place, row) in whitened.rows.column_iter().enumerate() {
            let off = (row[width] - row.rows(0, width).dot(&evaluated.coefficients)).abs() / sigma;
            let variance = white[place] * (off / HUBER).max(1.0);
            changed |= (variance / averages.variance[place] - 1.0).abs() > SAME;
            averages.variance[place] = variance;
        }
        changed
    }
}

/// Columns, and the likeliest of them by all rows.
struct Searched<'a> {
    evidence: Evidence<'a>,
    averages: Averages,
    found: Found,
    evaluated: Evaluated,
    surprise: f64,
}

impl<'a> Searched<'a> {
    fn of(evidence: Evidence<'a>, near: Option<&Found>) -> Option<Self> {
        let (averages, found, evaluated) = evidence.search(near, |_| true)?;
        let surprise = evaluated.surprise(&found.spreads)?;
        Some(Self { evidence, averages, found, evaluated, surprise })
    }

    /// The one with a straight drift in time where that is strongly likelier.
    fn likelier(dying: Self, straight: Option<Self>) -> Likeliest<'a> {
        let likelier = straight.filter(|straight| straight.surprise < dying.surprise - STRONG).unwrap_or(dying);
        (likelier.evidence, likelier.found)
    }

    /// The curve by which another search tells parts that are behind.
    fn curve(&self) -> Option<Before> {
        let made = deployed::model(&self.evidence.columns, &self.averages, &self.evaluated)?;
        Some(Before { curve: made.model.drift.shape, spread: self.averages.spread })
    }
}

#[cfg(test)]
mod tests;
