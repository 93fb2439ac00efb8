//! The marginal likelihood of the spreads, and its ascent.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::columns::Kind;
use super::noise::{Wander, Whitened};

/// A normal prior on the natural logarithm of a spread, in spreads of the rate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prior {
    pub mean: f64,
    pub sigma: f64,
}

impl Prior {
    /// Its negative logarithm.
    fn cost(self, log: f64) -> f64 {
        0.5 * ((log - self.mean) / self.sigma).powi(2)
    }

    fn slope(self, log: f64) -> f64 {
        (log - self.mean) / self.sigma.powi(2)
    }
}

/// The prior of a kind's spread, weak: a factor of e to the power of sigma either way is nothing special. The curve's bends
/// are a twentieth of the rate's spread, what remembers or follows switching on a fiftieth.
pub(super) fn prior(kind: Kind) -> Prior {
    let (mean, sigma) = match kind {
        Kind::Free => (0.0, 1.0),
        Kind::Powers | Kind::Logs => (-1.5, 1.5),
        Kind::Bends => (-3.0, 1.5),
        Kind::Lags | Kind::Behind | Kind::Plays | Kind::Start | Kind::Time => (-4.0, 2.0),
    };
    Prior { mean, sigma }
}

/// Of the white noise.
pub(super) const WHITE: Prior = Prior { mean: -3.0, sigma: 3.0 };

/// Of what wanders.
const WANDER: Prior = Prior { mean: -4.0, sigma: 2.0 };

/// Of the time in which that forgets, seconds: ten minutes.
pub(super) const SECONDS: Prior = Prior { mean: 6.4, sigma: 1.0 };

/// The variance of level and slope, in spreads of the rate: so large that it is of no consequence.
const FREE: f64 = 100.0;

/// Steps of the ascent, at most.
const MOST_STEPS: usize = 30;

/// A gain of the likelihood's logarithm that is not worth a step.
const ENOUGH: f64 = 0.02;

/// The longest step of a logarithm.
const LONGEST: f64 = 2.0;

/// What is found: the spread of each kind's coefficients and of the white noise, natural logarithms.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spreads {
    pub kinds: Vec<(Kind, f64)>,
    pub white: f64,
}

impl Spreads {
    /// As the priors have them.
    pub(super) fn prior(columns: &[Kind]) -> Self {
        let mut kinds: Vec<Kind> = columns.iter().copied().filter(|kind| *kind != Kind::Free).collect();
        kinds.sort_unstable();
        kinds.dedup();
        Self { kinds: kinds.into_iter().map(|kind| (kind, prior(kind).mean)).collect(), white: WHITE.mean }
    }
}

/// The sums of whitened rows, and how likely spreads are by them.
pub(super) struct Marginal<'a> {
    kinds: &'a [Kind],
    gram: DMatrix<f64>,
    target: DVector<f64>,
    square: f64,
    log_determinant: f64,
    rows: f64,
    wander: Wander,
}

/// The marginal likelihood at some spreads.
pub(super) struct Evaluated {
    /// Its negative logarithm, the priors' with it.
    pub cost: f64,
    /// The columns' coefficients: their mean, given the data.
    pub coefficients: DVector<f64>,
    /// Their covariance, given the data.
    pub covariance: DMatrix<f64>,
    /// Of the cost, in the logarithms of the spreads; of the white noise last.
    pub gradient: DVector<f64>,
    information: DMatrix<f64>,
}

impl Evaluated {
    /// The negative logarithm of the model's evidence where these are the likeliest spreads: their marginal likelihood, over
    /// all spreads by Laplace's approximation, less what all models have in common.
    pub(super) fn surprise(&self, spreads: &Spreads) -> Option<f64> {
        let widths: f64 = spreads.kinds.iter().map(|(kind, _)| libm::log(prior(*kind).sigma)).sum();
        let factor = Cholesky::new(self.information.clone())?;
        Some(self.cost + widths + factor.l_dirty().diagonal().iter().map(|own| libm::log(*own)).sum::<f64>())
    }
}

impl<'a> Marginal<'a> {
    pub(super) fn new(kinds: &'a [Kind], whitened: &Whitened, wander: Wander) -> Self {
        let width = kinds.len();
        Self {
            kinds,
            gram: whitened.products.view((0, 0), (width, width)).into_owned(),
            target: whitened.products.view((0, width), (width, 1)).column(0).into_owned(),
            square: whitened.products[(width, width)],
            log_determinant: whitened.log_determinant,
            rows: whitened.count,
            wander,
        }
    }

    /// Marginal likelihood, gradient and Fisher information in the logarithms of the spreads (MacKay, *Bayesian
    /// interpolation*, 1992; Rasmussen and Williams, *Gaussian processes for machine learning*, 2006, 5.4; the information as
    /// in restricted maximum likelihood: Searle, Casella and McCulloch, *Variance components*, 1992, 8.3).
    pub(super) fn evaluate(&self, spreads: &Spreads) -> Option<Evaluated> {
        let width = self.kinds.len();
        let noise = libm::exp(2.0 * spreads.white);
        let place: Vec<Option<usize>> =
            self.kinds.iter().map(|kind| spreads.kinds.iter().position(|(own, _)| own == kind)).collect();
        let spread = DVector::from_fn(width, |i, _| place[i].map_or(FREE.sqrt(), |p| libm::exp(spreads.kinds[p].1)));
        let mut precision = &self.gram / noise;
        for i in 0..width {
            precision[(i, i)] += spread[i].powi(-2);
        }
        let factor = Cholesky::new(precision)?;
        let log_precision: f64 = factor.l_dirty().diagonal().iter().map(|own| 2.0 * libm::log(*own)).sum();
        let covariance = factor.inverse();
        let coefficients = &covariance * &self.target / noise;
        let fitted = (self.square - coefficients.dot(&self.target)) / noise;
        // I - S^-1/2 covariance S^-1/2: how far the data have settled each coefficient.
        let settled = DMatrix::from_fn(width, width, |i, j| {
            f64::from(u8::from(i == j)) - covariance[(i, j)] / (spread[i] * spread[j])
        });
        // The white noise comes last.
        let white = spreads.kinds.len();
        let mut gradient = DVector::zeros(white + 1);
        let mut information = DMatrix::zeros(white + 1, white + 1);
        let (mut all, mut explained) = (0.0, 0.0);
        let mut with_noise = vec![0.0; white + 1];
        for i in 0..width {
            let size = (coefficients[i] / spread[i]).powi(2);
            all += settled[(i, i)];
            explained += size;
            let own = place[i].unwrap_or(white);
            if own < white {
                gradient[own] += settled[(i, i)] - size;
            }
            with_noise[own] += 2.0 * settled[(i, i)];
            for j in 0..width {
                let squared = 2.0 * settled[(i, j)].powi(2);
                with_noise[own] -= squared;
                if let (true, Some(other)) = (own < white, place[j]) {
                    information[(own, other)] += squared;
                }
            }
        }
        gradient[white] = self.rows - all - (fitted - explained);
        let mut noisy = 2.0 * (self.rows - all);
        for (own, shared) in with_noise.iter().enumerate() {
            noisy -= shared;
            if own < white {
                information[(own, white)] = *shared;
                information[(white, own)] = *shared;
            }
        }
        information[(white, white)] = noisy.max(1.0);
        let mut cost = 0.5 * (fitted + self.log_determinant + log_precision) + self.rows * spreads.white;
        cost += spread.iter().map(|spread| libm::log(*spread)).sum::<f64>();
        for (place, (kind, log)) in spreads.kinds.iter().enumerate() {
            let prior = prior(*kind);
            cost += prior.cost(*log);
            gradient[place] += prior.slope(*log);
            information[(place, place)] += prior.sigma.powi(-2);
        }
        for (prior, log) in [(WHITE, spreads.white), (WANDER, spreads.white + self.wander.log_ratio)] {
            cost += prior.cost(log);
            gradient[white] += prior.slope(log);
            information[(white, white)] += prior.sigma.powi(-2);
        }
        cost += SECONDS.cost(self.wander.log_seconds);
        cost.is_finite().then_some(Evaluated { cost, coefficients, covariance, gradient, information })
    }

    /// The likeliest spreads, from some on: Fisher's scoring, each step halved until it gains.
    pub(super) fn ascend(&self, mut spreads: Spreads) -> Option<(Spreads, Evaluated)> {
        let mut now = self.evaluate(&spreads)?;
        for _ in 0..MOST_STEPS {
            let step = Cholesky::new(now.information.clone())?.solve(&now.gradient);
            if step.dot(&now.gradient) < ENOUGH {
                break;
            }
            let mut share = (LONGEST / step.amax()).min(1.0);
            let better = (0..6).find_map(|_| {
                let mut tried = spreads.clone();
                tried.kinds.iter_mut().zip(step.iter()).for_each(|((_, log), step)| *log -= share * step);
                tried.white -= share * step[step.len() - 1];
                share *= 0.5;
                let found = self.evaluate(&tried)?;
                (found.cost < now.cost).then_some((tried, found))
            });
            let Some(found) = better else { break };
            (spreads, now) = found;
        }
        Some((spreads, now))
    }
}
