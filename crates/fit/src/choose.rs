//! The order of a polynomial by blocked cross-validation over plain rows: the simplest whose error on data it has not seen
//! is within one standard error of the best.

use zerorate_core::drift::{Drift, MAX_ORDER, Scale, Shape, ValidRange};

use crate::drift_fit::{Candidate, DriftFit, FitStatistics, ResidualOver, finite};
use crate::folds::{FOLDS, fold_of_row};
use crate::least_squares::{Basis, Fit, FitError, Solution};
use crate::model::Model;
use crate::predict::DriftModel;
use crate::residual::{ResidualStatistics, Residuals};

/// The model chosen, fitted to everything and to all but each fold.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// Its fit of everything.
    pub solution: Solution,
    /// The curve.
    shape: Shape,
    /// For each fold, the curve fitted without it; `None` where the rest does not settle it.
    without: Vec<Option<Shape>>,
    /// All candidates, simplest first.
    pub candidates: Vec<Candidate>,
}

/// Fits of one response, one a fold, and which to push a row to.
#[derive(Debug, Clone)]
pub struct FoldFits {
    fits: Vec<Fit>,
    rows: u64,
}

impl FoldFits {
    /// Empty fits for a record of `rows` rows.
    #[must_use]
    pub fn new(scale: Scale, model: Model, rows: u64) -> Self {
        Self { fits: vec![Fit::new(scale, model.basis()); FOLDS], rows }
    }

    /// Takes in successive rows of the record, the first of them the record's row `first_row`. Rows without a number
    /// are passed over.
    pub fn push_rows(&mut self, first_row: u64, temperatures: &[f64], rates: &[f64]) {
        let numeric = |(t, r): &(&f64, &f64)| t.is_finite() && r.is_finite();
        let mut start = 0;
        while start < temperatures.len() {
            let fold = self.fold(first_row + start as u64);
            let same = (first_row + start as u64..).take(temperatures.len() - start);
            let end = start + same.take_while(|row| self.fold(*row) == fold).count();
            let (temperatures, rates) = (&temperatures[start..end], &rates[start..end]);
            let fit = &mut self.fits[fold];
            if temperatures.iter().zip(rates).all(|row| numeric(&row)) {
                fit.push_rows(temperatures, rates);
            } else {
                let (temperatures, rates): (Vec<f64>, Vec<f64>) =
                    temperatures.iter().zip(rates).filter(numeric).unzip();
                fit.push_rows(&temperatures, &rates);
            }
            start = end;
        }
    }

    /// Fits every candidate and chooses: the model asked for, or for [`Model::Auto`] the simplest polynomial whose
    /// held-out rms is within one standard error of the best one's (after Breiman et al., *Classification and Regression
    /// Trees*, 1984, 3.4.3, with the error of the difference in place of the error of the best). Candidates that the rows
    /// do not settle are left out.
    ///
    /// # Errors
    /// When the rows settle no candidate.
    pub fn choose(&self, model: Model) -> Result<Choice, FitError> {
        let bases: Vec<Basis> = match model {
            Model::Auto => (1..=MAX_ORDER).map(Basis::Powers).collect(),
            fixed => vec![fixed.basis()],
        };
        let mut tried = Vec::new();
        let mut failure = None;
        for basis in bases {
            match self.try_basis(basis) {
                Ok(candidate) => tried.push(candidate),
                Err(error) => failure = failure.or(Some(error)),
            }
        }
        match (simplest_within_one_standard_error(&mut tried), failure) {
            (Some(chosen), _) => {
                let mut candidates: Vec<Candidate> = tried.iter().map(|tried| tried.candidate.clone()).collect();
                candidates[chosen].chosen = true;
                let Tried { solution, shape, without, .. } = tried.swap_remove(chosen);
                Ok(Choice { solution, shape, without, candidates })
            }
            (None, failure) => Err(failure.unwrap_or(FitError::TooFewRows { rows: 0, coefficients: 2 })),
        }
    }

    fn fold(&self, row: u64) -> usize {
        fold_of_row(row, self.rows)
    }

    fn try_basis(&self, basis: Basis) -> Result<Tried, FitError> {
        let fits: Vec<Fit> = self
            .fits
            .iter()
            .map(|fit| match basis {
                Basis::Powers(order) => fit.lowered(order).unwrap_or_else(|| fit.clone()),
                Basis::PiecewiseLinear(_) => fit.clone(),
            })
            .collect();
        let merged = |left_out: Option<usize>| -> Result<Solution, FitError> {
            let mut kept = fits.iter().enumerate().filter(|(fold, _)| Some(*fold) != left_out);
            let (_, first) = kept.next().expect("more than one fold");
            let mut all = first.clone();
            kept.for_each(|(_, fit)| all.merge(fit));
            all.finish()
        };
        let solution = merged(None)?;
        // The bases that can be asked for are those that core has shapes for.
        let coefficients = basis.size();
        let shape = solution.shape().ok_or(FitError::Undetermined { coefficients })?;
        let without: Vec<Option<Solution>> = (0..FOLDS).map(|fold| merged(Some(fold)).ok()).collect();
        let mean_squares = held_out(&fits, &without);
        let candidate = Candidate {
            model: Model::of(basis).to_string(),
            in_sample_rms: solution.rms,
            held_out_rms: finite(held_out_rms(&fits, &mean_squares)),
            held_out_excess_standard_error: None,
            deployed_rms: None,
            ends_rms: None,
            by_direction_rms: None,
            chosen: false,
        };
        let without = without.iter().map(|solution| solution.as_ref()?.shape()).collect();
        Ok(Tried { candidate, solution, shape, without, mean_squares })
    }
}

impl Choice {
    /// The drift, believed over a range.
    #[must_use]
    pub fn drift(&self, valid: ValidRange) -> Drift {
        Drift { shape: self.shape.clone(), valid }
    }

    /// The fit, with what its residuals came to: in-sample and held out.
    #[must_use]
    pub fn finish(
        &self,
        valid: ValidRange,
        over: ResidualOver,
        (in_sample, held_out): (ResidualStatistics, ResidualStatistics),
    ) -> DriftFit {
        let Solution { rows, covariance, .. } = &self.solution;
        let statistics = FitStatistics {
            candidates: self.candidates.clone(),
            ..FitStatistics::new(over, *rows, in_sample, held_out, covariance.clone())
        };
        let model = DriftModel::of_curve(self.drift(valid));
        DriftFit { model, measured: valid, static_cubic: None, band: Vec::new(), next_run_band: Vec::new(), statistics }
    }
}

/// The residuals of one axis, in-sample and held out, in a second pass over its rows. The curve is not held at the ends of
/// a valid range: a fold may be the only one at its end.
#[derive(Debug)]
pub struct FoldResiduals<'a> {
    choice: &'a Choice,
    rows: u64,
    in_sample: Residuals,
    held_out: [Residuals; FOLDS],
    /// Every fold with rows had a fit of the others.
    complete: bool,
}

impl<'a> FoldResiduals<'a> {
    /// For the record of `rows` rows that was fitted.
    #[must_use]
    pub fn new(choice: &'a Choice, rows: u64) -> Self {
        let (in_sample, held_out) = (Residuals::default(), [Residuals::default(); FOLDS]);
        Self { choice, rows, in_sample, held_out, complete: true }
    }

    /// Takes in one row, and gives its residual of the fit of everything.
    pub fn push(&mut self, row: u64, temperature: f64, rate: f64) -> f64 {
        let residual = rate - self.choice.shape.evaluate(temperature);
        self.in_sample.push(residual);
        let fold = fold_of_row(row, self.rows);
        match &self.choice.without[fold] {
            Some(shape) => self.held_out[fold].push(rate - shape.evaluate(temperature)),
            None => self.complete = false,
        }
        residual
    }

    /// In-sample and held out.
    #[must_use]
    pub fn statistics(&self) -> (ResidualStatistics, ResidualStatistics) {
        let held_out =
            if self.complete { ResidualStatistics::of_folds(&self.held_out) } else { ResidualStatistics::NONE };
        (self.in_sample.statistics(), held_out)
    }
}

/// A candidate with its fits.
struct Tried {
    candidate: Candidate,
    solution: Solution,
    shape: Shape,
    without: Vec<Option<Shape>>,
    /// Held out, a fold each.
    mean_squares: Vec<f64>,
}

/// The mean square of each fold with rows, predicted by the fit of the others; NaN where there is no such fit.
fn held_out(fits: &[Fit], without: &[Option<Solution>]) -> Vec<f64> {
    fits.iter()
        .zip(without)
        .filter(|(fit, _)| fit.rows() > 0)
        .map(|(fit, rest)| {
            let squares = rest.as_ref().map_or(f64::NAN, |rest| fit.sum_of_squares_of(&rest.coefficients));
            squares / fit.rows() as f64
        })
        .collect()
}

/// Root mean square over all folds, each weighed by its rows.
fn held_out_rms(fits: &[Fit], mean_squares: &[f64]) -> f64 {
    let rows = || fits.iter().map(Fit::rows).filter(|rows| *rows > 0);
    let squares: f64 = mean_squares.iter().zip(rows()).map(|(mean, rows)| mean * rows as f64).sum();
    (squares / rows().sum::<u64>() as f64).sqrt()
}

/// Fills in the standard errors, and gives the place of the first candidate within its own of the best; the first of all
/// when none could be held out.
fn simplest_within_one_standard_error(tried: &mut [Tried]) -> Option<usize> {
    let rms = |tried: &Tried| tried.candidate.held_out_rms.unwrap_or(f64::INFINITY);
    let best = tried.iter().filter(|it| rms(it).is_finite()).min_by(|a, b| rms(a).total_cmp(&rms(b)));
    let Some(best) = best else {
        return (!tried.is_empty()).then_some(0);
    };
    let (best_rms, best_squares) = (rms(best), best.mean_squares.clone());
    let mut first = None;
    for (place, own) in tried.iter_mut().enumerate() {
        let excess: Vec<f64> = own.mean_squares.iter().zip(&best_squares).map(|(own, best)| own - best).collect();
        // a - b = (a^2 - b^2) / (a + b)
        let error = (standard_error(&excess) / (rms(own) + best_rms)).max(0.0);
        own.candidate.held_out_excess_standard_error = Some(error).filter(|error| *error > 0.0);
        if first.is_none() && rms(own) <= best_rms + error {
            first = Some(place);
        }
    }
    first
}

/// The standard error of the mean of some values.
pub(crate) fn standard_error(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (variance / count).sqrt()
}

#[cfg(test)]
mod tests;
