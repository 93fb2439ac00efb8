//! Which model: the simplest whose error on data it has not seen is within one standard error of the best.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;
use zerorate_core::drift::{MAX_KNOTS, MAX_ORDER, Scale};

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
    /// A polynomial of the order that held-out error chooses.
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
    /// Standard error of `held_out_rms`, from the scatter of the stretches' mean squares.
    pub standard_error: f64,
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
    /// held-out mean square is within one standard error of the best one's (Breiman et al., *Classification and
    /// Regression Trees*, 1984, 3.4.3). Candidates that the rows do not settle are left out.
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
        let candidates: Vec<Candidate> = tried.iter().map(|tried| tried.candidate).collect();
        match (simplest_within_one_standard_error(&candidates), failure) {
            (Some(chosen), _) => {
                let Tried { candidate, solution, without } = tried.swap_remove(chosen);
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
        let (held_out_rms, standard_error) = held_out(&fits, &without);
        let candidate =
            Candidate { model: Model::of(basis), in_sample_rms: solution.rms, held_out_rms, standard_error };
        Ok(Tried { candidate, solution, without })
    }
}

/// A candidate with its fits.
struct Tried {
    candidate: Candidate,
    solution: Solution,
    without: Vec<Option<Solution>>,
}

/// The rms over all stretches and its standard error; NaN where a stretch with rows has no fit of the others.
fn held_out(fits: &[Fit], without: &[Option<Solution>]) -> (f64, f64) {
    let mut sum = 0.0;
    let mut means = Vec::new();
    for (fit, rest) in fits.iter().zip(without).filter(|(fit, _)| fit.rows() > 0) {
        let squares = rest.as_ref().map_or(f64::NAN, |rest| fit.sum_of_squares_of(0, &rest.coefficients));
        sum += squares;
        means.push(squares / fit.rows() as f64);
    }
    let rows: u64 = fits.iter().map(Fit::rows).sum();
    let rms = (sum / rows as f64).sqrt();
    let count = means.len() as f64;
    let mean = means.iter().sum::<f64>() / count;
    let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (count - 1.0);
    // d(rms) = d(mean square) / (2 rms).
    let standard_error = (variance / count).sqrt() / (2.0 * rms);
    (rms, if rms > 0.0 { standard_error } else { 0.0 })
}

/// The place of the first candidate within one standard error of the best; the first of all when none was held out.
fn simplest_within_one_standard_error(candidates: &[Candidate]) -> Option<usize> {
    let best = candidates
        .iter()
        .filter(|candidate| candidate.held_out_rms.is_finite())
        .min_by(|a, b| a.held_out_rms.total_cmp(&b.held_out_rms));
    let Some(best) = best else {
        return (!candidates.is_empty()).then_some(0);
    };
    let bar = best.held_out_rms + best.standard_error;
    // A single stretch with rows has no standard error: then the best itself.
    candidates.iter().position(|candidate| candidate.held_out_rms <= bar || candidate.model == best.model)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle sweep over -40..60, so that each temperature is seen in several stretches.
    fn stretches(model: Model, curve: impl Fn(f64) -> f64) -> Stretches {
        let rows = 8000;
        let mut stretches = Stretches::new(Scale::spanning(-40.0, 60.0).unwrap(), model, rows);
        for row in 0..rows {
            let phase = (row as f64 / 1300.0).fract();
            let temperature = -40.0 + 200.0 * (phase - 0.5).abs();
            let noise = ((row * 7919) % 1000) as f64 / 1000.0 - 0.5;
            let (stretch, _) = stretches.of_row(row);
            stretches.fit(stretch).push(temperature, &[curve(temperature) + noise]);
        }
        stretches
    }

    #[test]
    fn model_names_are_read_and_written() {
        for name in ["poly:1", "poly:5", "table:32", "auto"] {
            assert_eq!(name.parse::<Model>().unwrap().to_string(), name);
        }
        for name in ["poly:0", "poly:6", "table:33", "poly", "poly:x", "spline:3", ""] {
            let error = name.parse::<Model>().unwrap_err().to_string();
            assert!(error.contains("poly:1 to poly:5, table:1 to table:32"), "{error}");
        }
    }

    #[test]
    fn rows_fall_into_eight_equal_contiguous_stretches() {
        let stretches = Stretches::new(Scale::spanning(0.0, 1.0).unwrap(), Model::Auto, 8403);
        let mut counts = [0; STRETCHES];
        for row in 0..8403 {
            let (stretch, end) = stretches.of_row(row);
            counts[stretch] += 1;
            assert!(row < end && (end == u64::MAX || stretches.of_row(end).0 == stretch + 1));
        }
        assert!(counts.iter().all(|count| (1050..=1051).contains(count)), "{counts:?}");
    }

    #[test]
    fn a_quadratic_drift_is_fitted_by_a_quadratic() {
        let choice = stretches(Model::Auto, |t| 30.0 - 0.9 * t + 0.01 * t * t).choose(Model::Auto).unwrap();
        assert_eq!(choice.model, Model::Poly(2));
        assert_eq!(choice.candidates.len(), 5);
        let [line, square, ..] = choice.candidates[..] else { panic!() };
        assert!(line.held_out_rms > 5.0 * square.held_out_rms);
        // Uniform noise over one count: 1 / sqrt(12).
        assert!((square.held_out_rms - 0.2887).abs() < 0.01);
        assert!(square.in_sample_rms <= square.held_out_rms);
    }

    #[test]
    fn a_cubic_drift_is_fitted_by_a_cubic() {
        let choice = stretches(Model::Auto, |t| t * t * t * 2e-4).choose(Model::Auto).unwrap();
        assert_eq!(choice.model, Model::Poly(3));
    }

    #[test]
    fn a_model_asked_for_is_taken_and_still_held_out() {
        let choice = stretches(Model::Table(16), |t| (t / 15.0).sin()).choose(Model::Table(16)).unwrap();
        assert_eq!(choice.model, Model::Table(16));
        assert_eq!(choice.without.iter().flatten().count(), STRETCHES);
        assert!(choice.candidates[0].held_out_rms < 0.31);
    }

    #[test]
    fn what_no_row_settles_is_an_error() {
        let empty = Stretches::new(Scale::spanning(0.0, 1.0).unwrap(), Model::Auto, 0);
        assert_eq!(empty.choose(Model::Auto), Err(FitError::TooFewRows { rows: 0, coefficients: 2 }));
    }
}
