//! Which model: the simplest whose error on data it has not seen is within one standard error of the best.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;
use zerorate_core::compensate::CurveNumbers;
use zerorate_core::drift::{MAX_KNOTS, MAX_ORDER, Scale, Shape};

use crate::fit::{Basis, Fit, FitError, Solution};

/// The contiguous stretches into which a record is cut for held-out error. Neighbouring rows are alike, so rows dealt out
/// at random would show a model its own test.
pub const STRETCHES: usize = 8;

/// A model asked for: `poly:K`, `table:K` or `auto`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Model {
    /// A polynomial of this order, 1 to 5.
    Poly(usize),
    /// A piecewise-linear table of this many equal intervals, 1 to 32.
    Table(usize),
    /// What held-out error chooses: of groups, curve and history ([`crate::auto`]); of plain rows, the order alone.
    #[default]
    Auto,
}

/// A model that was asked for and is none.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("'{0}' is no model: give poly:1 to poly:{MAX_ORDER}, table:1 to table:{most}, or auto", most = MAX_KNOTS - 1)]
pub struct ModelError(String);

impl FromStr for Model {
    type Err = ModelError;
    fn from_str(text: &str) -> Result<Self, ModelError> {
        let unknown = || ModelError(text.to_owned());
        if text == "auto" {
            return Ok(Self::Auto);
        }
        let (kind, size) = text.split_once(':').ok_or_else(unknown)?;
        let size: usize = size.parse().map_err(|_| unknown())?;
        match kind {
            "poly" if (1..=MAX_ORDER).contains(&size) => Ok(Self::Poly(size)),
            "table" if (1..MAX_KNOTS).contains(&size) => Ok(Self::Table(size)),
            _ => Err(unknown()),
        }
    }
}

impl fmt::Display for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Poly(order) => write!(f, "poly:{order}"),
            Self::Table(intervals) => write!(f, "table:{intervals}"),
            Self::Auto => f.write_str("auto"),
        }
    }
}

impl Model {
    /// The basis whose fit serves every candidate of the model: for `auto`, powers up to the highest order.
    #[must_use]
    pub fn basis(self) -> Basis {
        match self {
            Self::Poly(order) => Basis::Powers(order),
            Self::Table(intervals) => Basis::Hats(intervals),
            Self::Auto => Basis::Powers(MAX_ORDER),
        }
    }

    /// The coefficients of the simplest candidate.
    #[must_use]
    pub fn least_coefficients(self) -> usize {
        match self {
            Self::Poly(size) | Self::Table(size) => size + 1,
            Self::Auto => 2,
        }
    }

    /// The model that a curve is of.
    #[must_use]
    pub fn of_shape(shape: &Shape) -> Self {
        match shape {
            Shape::Polynomial(polynomial) => Self::Poly(polynomial.order()),
            Shape::Table(table) => Self::Table(table.knots().len() - 1),
        }
    }

    /// The model that a device's curve was rounded from.
    #[must_use]
    pub fn of_numbers(curve: &CurveNumbers) -> Self {
        match curve {
            CurveNumbers::Polynomial(polynomial) => Self::Poly(polynomial.coefficients.len().saturating_sub(1)),
            CurveNumbers::Table(table) => Self::Table(table.knots.len().saturating_sub(1)),
        }
    }

    /// The model of a basis.
    fn of(basis: Basis) -> Self {
        match basis {
            Basis::Powers(order) => Self::Poly(order),
            Basis::Hats(intervals) => Self::Table(intervals),
        }
    }
}

/// One candidate and its errors, rate units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// The model.
    pub model: Model,
    /// Root mean square of the residual of the fit of everything.
    pub in_sample_rms: f64,
    /// Root mean square over all stretches, each predicted by the fit of the others; NaN where one could not be fitted.
    pub held_out_rms: f64,
    /// Standard error of how much `held_out_rms` exceeds the best candidate's, from their differences stretch by
    /// stretch: what makes a stretch hard for all, as hysteresis does, says nothing about which is better. 0 for the best.
    pub standard_error: f64,
    /// What it has beside the curve.
    pub terms: TermSet,
    /// Further errors, where histories were compared.
    pub further: Option<Further>,
    /// Whether it is the one chosen.
    pub chosen: bool,
}

/// What a candidate has beside its curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TermSet {
    /// How many plays.
    pub plays: usize,
    /// How many lags.
    pub lags: usize,
    /// A slow drift in time.
    pub time: bool,
}

/// Further errors of a candidate, rate units; NaN where there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Further {
    /// Over all stretches without the drift in time, less the mean of each one's first groups.
    pub deployed_rms: f64,
    /// With the coldest and the hottest eighth held out.
    pub ends_rms: [f64; 2],
    /// Of the held-out groups, those taken while heating, and while cooling.
    pub by_direction_rms: [f64; 2],
    /// How strongly its weights were drawn to zero.
    pub ridge: f64,
}

impl fmt::Display for Candidate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.model)?;
        let TermSet { plays, lags, time } = self.terms;
        for (count, what) in [(plays, "play"), (lags, "lag")] {
            match count {
                0 => {}
                1 => write!(f, " + {what}")?,
                _ => write!(f, " + {count} {what}s")?,
            }
        }
        if time { f.write_str(" + time") } else { Ok(()) }
    }
}

/// The model chosen, fitted to everything and to all but each stretch.
#[derive(Debug, Clone, PartialEq)]
pub struct Choice {
    /// The model.
    pub model: Model,
    /// Its fit of everything.
    pub solution: Solution,
    /// For each stretch, the coefficients fitted without it; `None` where the rest does not settle them.
    pub without: Vec<Option<Solution>>,
    /// All candidates, simplest first.
    pub candidates: Vec<Candidate>,
}

/// Fits of one response, one a contiguous stretch, and which to push a row to.
#[derive(Debug, Clone)]
pub struct Stretches {
    fits: Vec<Fit>,
    rows: u64,
}

impl Stretches {
    /// Empty fits for a record of `rows` rows.
    #[must_use]
    pub fn new(scale: Scale, model: Model, rows: u64) -> Self {
        Self { fits: vec![Fit::new(scale, model.basis(), 1); STRETCHES], rows }
    }

    /// The stretch that a row of the record belongs to, 0 to 7, and the first row after it.
    #[must_use]
    // The quotient is below 8.
    #[allow(clippy::cast_possible_truncation)]
    pub fn of_row(&self, row: u64) -> (usize, u64) {
        let stretches = STRETCHES as u64;
        let stretch = (row * stretches / self.rows.max(1)).min(stretches - 1);
        let end = if stretch + 1 == stretches { u64::MAX } else { ((stretch + 1) * self.rows).div_ceil(stretches) };
        (stretch as usize, end)
    }

    /// The fit of a stretch, to push its rows to.
    pub fn fit(&mut self, stretch: usize) -> &mut Fit {
        &mut self.fits[stretch]
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
                tried[chosen].candidate.chosen = true;
                let candidates = tried.iter().map(|tried| tried.candidate).collect();
                let Tried { candidate, solution, without, .. } = tried.swap_remove(chosen);
                Ok(Choice { model: candidate.model, solution, without, candidates })
            }
            (None, failure) => Err(failure.unwrap_or(FitError::TooFewRows { rows: 0, coefficients: 2 })),
        }
    }

    fn try_basis(&self, basis: Basis) -> Result<Tried, FitError> {
        let fits: Vec<Fit> = self
            .fits
            .iter()
            .map(|fit| match basis {
                Basis::Powers(order) => fit.lowered(order).unwrap_or_else(|| fit.clone()),
                Basis::Hats(_) => fit.clone(),
            })
            .collect();
        let merged = |left_out: Option<usize>| -> Result<Solution, FitError> {
            let mut kept = fits.iter().enumerate().filter(|(stretch, _)| Some(*stretch) != left_out);
            let (_, first) = kept.next().expect("more than one stretch");
            let mut all = first.clone();
            kept.for_each(|(_, fit)| all.merge(fit));
            Ok(all.finish()?.swap_remove(0))
        };
        let solution = merged(None)?;
        let without: Vec<Option<Solution>> = (0..STRETCHES).map(|stretch| merged(Some(stretch)).ok()).collect();
        let mean_squares = held_out(&fits, &without);
        let candidate = Candidate {
            model: Model::of(basis),
            in_sample_rms: solution.rms,
            held_out_rms: held_out_rms(&fits, &mean_squares),
            standard_error: f64::NAN,
            terms: TermSet::default(),
            further: None,
            chosen: false,
        };
        Ok(Tried { candidate, solution, without, mean_squares })
    }
}

/// A candidate with its fits.
struct Tried {
    candidate: Candidate,
    solution: Solution,
    without: Vec<Option<Solution>>,
    /// Held out, a stretch each.
    mean_squares: Vec<f64>,
}

/// The mean square of each stretch with rows, predicted by the fit of the others; NaN where there is no such fit.
fn held_out(fits: &[Fit], without: &[Option<Solution>]) -> Vec<f64> {
    fits.iter()
        .zip(without)
        .filter(|(fit, _)| fit.rows() > 0)
        .map(|(fit, rest)| {
            let squares = rest.as_ref().map_or(f64::NAN, |rest| fit.sum_of_squares_of(0, &rest.coefficients));
            squares / fit.rows() as f64
        })
        .collect()
}

/// Root mean square over all stretches, each weighed by its rows.
fn held_out_rms(fits: &[Fit], mean_squares: &[f64]) -> f64 {
    let rows = || fits.iter().map(Fit::rows).filter(|rows| *rows > 0);
    let squares: f64 = mean_squares.iter().zip(rows()).map(|(mean, rows)| mean * rows as f64).sum();
    (squares / rows().sum::<u64>() as f64).sqrt()
}

/// Fills in the standard errors, and gives the place of the first candidate within its own of the best; the first of all
/// when none could be held out.
fn simplest_within_one_standard_error(tried: &mut [Tried]) -> Option<usize> {
    let best = tried
        .iter()
        .filter(|tried| tried.candidate.held_out_rms.is_finite())
        .min_by(|a, b| a.candidate.held_out_rms.total_cmp(&b.candidate.held_out_rms));
    let Some(best) = best else {
        return (!tried.is_empty()).then_some(0);
    };
    let (best_rms, best_squares) = (best.candidate.held_out_rms, best.mean_squares.clone());
    for Tried { candidate, mean_squares, .. } in &mut *tried {
        let excess: Vec<f64> = mean_squares.iter().zip(&best_squares).map(|(own, best)| own - best).collect();
        // a - b = (a^2 - b^2) / (a + b)
        let error = standard_error(&excess) / (candidate.held_out_rms + best_rms);
        candidate.standard_error = if error > 0.0 { error } else { 0.0 };
    }
    tried.iter().position(|tried| tried.candidate.held_out_rms <= best_rms + tried.candidate.standard_error)
}

/// The standard error of the mean of some values.
fn standard_error(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (variance / count).sqrt()
}

#[cfg(test)]
mod tests;
