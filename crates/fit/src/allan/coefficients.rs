//! N, B and K from an Allan curve: a weighted fit of their sum, none below zero.

use serde::Serialize;

use super::AllanPoint;
use super::confidence::{LEVEL, Noise, beyond, bound, interval};

/// Terms of the Allan variance over averaging time (IEEE Std 952-1997, annex C): quantization `3 Q^2 / tau^2`, angle random
/// walk `N^2 / tau`, bias instability `(2 ln 2 / pi) B^2` (its flat part), rate random walk `K^2 tau / 3`.
const TERMS: usize = 4;

/// The place of each coefficient among the terms.
const Q: usize = 0;
const N: usize = 1;
const B: usize = 2;
const K: usize = 3;

/// A term that makes up less than this of the variance at every averaging time is not seen: there is only a bound for it.
const SEEN: f64 = 0.5;

/// One that makes up more is nearly all that there is.
const NEARLY_ALL: f64 = 0.98;

/// Nor is one without which the curve is as likely: at every averaging time it is within what chance makes of the best sum of the
/// other terms. All times together are to be beyond it in so many of the curves that have none of the term.
const BY_CHANCE: f64 = 1.0 - LEVEL;

/// Rounds of the fit: four terms settle in a few hundred.
const ROUNDS: usize = 20_000;

/// The model in a denominator is this part of the variance found, at least: what a filter takes leaves more.
const LEAST_SIZE: f64 = 0.1;

/// Rounds of weighing by the model: it settles in a handful.
const REWEIGHTED: usize = 12;

/// A coefficient, in the rate's unit times the power of a second that its name says.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "seen")]
pub enum Coefficient {
    /// It is the largest part of the curve somewhere.
    #[serde(rename = "yes")]
    Seen {
        /// Its value.
        value: f64,
        /// Lower bound at the confidence [`super::LEVEL`].
        low: f64,
        /// Upper bound.
        high: f64,
        /// The averaging time at which it is the largest part, seconds.
        tau_s: f64,
    },
    /// Other noise or a trend hides it.
    #[serde(rename = "no")]
    Hidden {
        /// It is not more than this, at the confidence [`super::LEVEL`].
        at_most: f64,
    },
}

impl Coefficient {
    /// The value, where it is seen.
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        match self {
            Self::Seen { value, .. } => Some(*value),
            Self::Hidden { .. } => None,
        }
    }
}

/// What an Allan curve is made of.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Coefficients {
    /// N, in the rate's unit times the root of a second (deg/s a root hertz is deg/s times root s; times 60 it is deg a
    /// root hour).
    pub angle_random_walk: Coefficient,
    /// B, in the rate's unit.
    pub bias_instability: Coefficient,
    /// K, in the rate's unit over the root of a second.
    pub rate_random_walk: Coefficient,
}

/// What the terms are at a time, for coefficients of one.
fn terms(tau_s: f64) -> [f64; TERMS] {
    let flat = 2.0 * std::f64::consts::LN_2 / std::f64::consts::PI;
    [3.0 / (tau_s * tau_s), 1.0 / tau_s, flat, tau_s / 3.0]
}

/// The noises, in the order of the terms.
const NOISES: [Noise; TERMS] =
    [Noise::Quantization, Noise::AngleRandomWalk, Noise::BiasInstability, Noise::RateRandomWalk];

impl Coefficients {
    /// Fits the terms to the variances, each weighed by its degrees of freedom; `points` must not be empty. `level` are those of
    /// the record less its trend, at the averaging times that this leaves as they were: what is seen is read there, and bounds
    /// are of the whole. `filtered` are those of a gyro behind a filter, at averaging times beyond it.
    ///
    /// And whether the whole curve shows a flicker or a walk which the record less its trend does not.
    pub(super) fn of(points: &[AllanPoint], level: &[AllanPoint], filtered: bool) -> (Self, bool) {
        let whole = Curve { points, filtered }.read();
        let level = if level.is_empty() { [None; TERMS] } else { Curve { points: level, filtered }.read() };
        let room = Curve { points, filtered };
        let squares = room.fitted([true; TERMS]);
        let hidden = |of: usize| Coefficient::Hidden { at_most: room.room(&squares, of) };
        let found = Self {
            angle_random_walk: level[N].or(whole[N]).unwrap_or_else(|| hidden(N)),
            bias_instability: level[B].unwrap_or_else(|| hidden(B)),
            rate_random_walk: level[K].unwrap_or_else(|| hidden(K)),
        };
        let rises = |found: &[Option<Coefficient>; TERMS]| found[B].or(found[K]).is_some();
        (found, rises(&whole) && !rises(&level))
    }
}

/// The noise that is the largest part at each point, by a fit: at long averaging times the curve is too rough for its own
/// slope to tell.
pub(super) fn noises(points: &[AllanPoint], filtered: bool) -> Vec<Noise> {
    let squares = Curve { points, filtered }.fitted([true; TERMS]);
    let largest = |point: &AllanPoint| {
        let parts = terms(point.tau_s);
        let by_size = |a: &usize, b: &usize| (parts[*a] * squares[*a]).total_cmp(&(parts[*b] * squares[*b]));
        NOISES[(0..TERMS).max_by(by_size).unwrap_or(N)]
    };
    points.iter().map(largest).collect()
}

fn dot(a: &[f64; TERMS], b: &[f64; TERMS]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// How much of a point a term is.
fn share(squares: &[f64; TERMS], of: usize, point: &AllanPoint) -> f64 {
    let parts = terms(point.tau_s);
    parts[of] * squares[of] / dot(&parts, &squares.map(f64::abs))
}

/// What the terms are fitted to.
#[derive(Clone, Copy)]
struct Curve<'a> {
    points: &'a [AllanPoint],
    /// What a filter takes from white noise goes with `1 / tau^2` at times far beyond its own, for whichever filter: it is
    /// quantization below zero.
    filtered: bool,
}

impl Curve<'_> {
    /// The squares of the coefficients that minimise the sum over points of `w ((variance - model) / model)^2` with none
    /// below zero, `w` the degrees of freedom. The model in the denominator is that of the round before: were it the
    /// variance found, points that came out low by chance would pull the fit down. Terms that are not kept are zero.
    fn fitted(self, kept: [bool; TERMS]) -> [f64; TERMS] {
        let mut sizes: Vec<f64> = self.points.iter().map(|point| point.deviation.powi(2)).collect();
        let mut squares = [0.0; TERMS];
        for _ in 0..REWEIGHTED {
            squares = self.fitted_by(&sizes, kept);
            let model = |point: &AllanPoint| {
                let variance = point.deviation.powi(2);
                dot(&terms(point.tau_s), &squares).max(LEAST_SIZE * variance)
            };
            sizes = self.points.iter().map(model).collect();
        }
        squares
    }

    /// The same with given denominators: by turns, one coefficient at a time, which a convex sum of squares allows.
    fn fitted_by(self, sizes: &[f64], kept: [bool; TERMS]) -> [f64; TERMS] {
        let rows: Vec<([f64; TERMS], f64, f64)> = self
            .points
            .iter()
            .zip(sizes)
            .map(|(point, size)| {
                (terms(point.tau_s).map(|t| t / size), point.deviation.powi(2) / size, point.degrees_of_freedom)
            })
            .collect();
        // Each term by its greatest row, so that one size of step suits all.
        let size: [f64; TERMS] = std::array::from_fn(|j| rows.iter().map(|(row, _, _)| row[j]).fold(0.0, f64::max));
        let mut products = [[0.0; TERMS]; TERMS];
        let mut targets = [0.0; TERMS];
        for (row, variance, weight) in &rows {
            for i in 0..TERMS {
                targets[i] += weight * variance * row[i] / size[i];
                for j in 0..TERMS {
                    products[i][j] += weight * row[i] / size[i] * row[j] / size[j];
                }
            }
        }
        let mut parts = [0.0_f64; TERMS];
        for _ in 0..ROUNDS {
            let mut moved = 0.0_f64;
            for i in (0..TERMS).filter(|i| kept[*i]) {
                let rest: f64 = (0..TERMS).filter(|j| *j != i).map(|j| products[i][j] * parts[j]).sum();
                let free = (targets[i] - rest) / products[i][i];
                let best = if i == Q && self.filtered { free } else { free.max(0.0) };
                moved = moved.max((best - parts[i]).abs());
                parts[i] = best;
            }
            if moved < 1e-12 {
                break;
            }
        }
        std::array::from_fn(|j| parts[j] / size[j])
    }

    /// How likely chance makes the curve without a term, at the point that tells most: how far it lies above the best sum of the
    /// other terms that are kept.
    fn chance_without(self, term: usize, mut kept: [bool; TERMS]) -> f64 {
        kept[term] = false;
        let others = self.fitted(kept);
        let chance = |point: &AllanPoint| {
            let ratio = point.deviation.powi(2) / dot(&terms(point.tau_s), &others).max(0.0);
            beyond(ratio, point.degrees_of_freedom)
        };
        self.points.iter().map(chance).fold(1.0, f64::min)
    }

    fn chance_at_a_point(self) -> f64 {
        BY_CHANCE / self.points.len() as f64
    }

    /// The terms without which the curve is not as likely, one left out after the other. A term that is not there comes out above
    /// zero by chance, never below, and what it gets is taken from the others: N came out low by a third of its error.
    fn needed(self) -> [bool; TERMS] {
        let mut kept = [true; TERMS];
        loop {
            // What a filter takes is there.
            let may_go = (0..TERMS).filter(|term| kept[*term] && !(*term == Q && self.filtered));
            let chances = may_go.map(|term| (term, self.chance_without(term, kept)));
            match chances.max_by(|(_, a), (_, b)| a.total_cmp(b)) {
                Some((term, chance)) if chance >= self.chance_at_a_point() => kept[term] = false,
                _ => return kept,
            }
        }
    }

    /// The coefficients that are seen.
    fn read(self) -> [Option<Coefficient>; TERMS] {
        let kept = self.needed();
        let squares = self.fitted(kept);
        // Of two terms that can stand for each other one stays; neither is seen.
        let is_seen = |of: &usize| kept[*of] && self.chance_without(*of, [true; TERMS]) < self.chance_at_a_point();
        let mut found = [None; TERMS];
        let all = self.fitted([true; TERMS]);
        for of in [N, B, K].into_iter().filter(is_seen) {
            found[of] = self.coefficient(&squares, &all, of);
        }
        found
    }

    /// The point at which a term is the largest part.
    fn largest(self, squares: &[f64; TERMS], of: usize) -> AllanPoint {
        let by_share = |a: &&AllanPoint, b: &&AllanPoint| share(squares, of, a).total_cmp(&share(squares, of, b));
        self.points.iter().max_by(by_share).copied().unwrap_or(self.points[0])
    }

    /// One coefficient with its bounds: those of the point at which its term is the largest part. `squares` are those of the terms
    /// that the curve needs. That it shows none of another is no proof that there is none: the bounds are as wide as those by
    /// `all` the terms, too (K. P. Burnham and D. R. Anderson, *Model Selection and Multimodel Inference*, 2002, 4.3: bounds of the
    /// one model that was chosen are too narrow by what was uncertain of the choice).
    fn coefficient(self, squares: &[f64; TERMS], all: &[f64; TERMS], of: usize) -> Option<Coefficient> {
        let share = |point: &AllanPoint| share(squares, of, point);
        // N is read at one point, for its bounds to be the value's: neighbouring averaging times share their samples, and a fit that
        // weighs them as if they did not scatters by more than the best of them. Beyond a filter single points have few averages.
        let at_a_point = of == N && !self.filtered;
        // Of those at which it is nearly all that there is the first, which tells most. At one point short times tell more than
        // what is taken off there costs.
        let worth = |point: &AllanPoint| {
            if at_a_point { point.degrees_of_freedom * share(point).powi(4) } else { share(point).min(NEARLY_ALL) }
        };
        let best = self.points.iter().rev().max_by(|a, b| worth(a).total_cmp(&worth(b)));
        let point = best.filter(|point| share(point) >= SEEN)?;
        let (value, (low, high)) = self.at(point, squares, of, at_a_point);
        let (other, (other_low, other_high)) = self.at(point, all, of, at_a_point);
        // Of flicker and a walk each takes what the other lacks: alone a weak walk came out a quarter too large, and beside a flicker
        // that is none a fifteenth too small.
        let value = if of == N { value } else { f64::midpoint(value.powi(2), other.powi(2)).sqrt() };
        Some(Coefficient::Seen { value, low: low.min(other_low), high: high.max(other_high), tau_s: point.tau_s })
    }

    /// A coefficient by some squares, and its bounds as they are known at a point.
    fn at(self, point: &AllanPoint, squares: &[f64; TERMS], of: usize, at_a_point: bool) -> (f64, (f64, f64)) {
        if at_a_point {
            let parts = terms(point.tau_s);
            let others = dot(&parts, squares) - parts[N] * squares[N];
            let own = |deviation: f64| ((deviation.powi(2) - others).max(0.0) / parts[N]).sqrt();
            // What is taken off is known as well as where it is largest, and adds its own error: a variance of so many degrees of
            // freedom has a relative variance of two over them.
            let error = |j: usize| (parts[j] * squares[j]).powi(2) / self.largest(squares, j).degrees_of_freedom;
            let errors: f64 = (0..TERMS).filter(|j| *j != N && squares[*j] > 0.0).map(error).sum();
            let variance = point.deviation.powi(4);
            let degrees_of_freedom = variance / (variance / point.degrees_of_freedom + errors);
            let (low, high) = interval(point.deviation, degrees_of_freedom);
            (own(point.deviation), (own(low), own(high)))
        } else {
            let value = squares[of].sqrt();
            (value, interval(value, point.degrees_of_freedom))
        }
    }

    /// As much of a term as the curve has room for: at one of its points or another, chance takes more away than at a single
    /// one. Where a filter takes much there is no telling.
    fn room(self, squares: &[f64; TERMS], of: usize) -> f64 {
        let is_taken =
            |point: &&AllanPoint| -terms(point.tau_s)[Q] * squares[Q] > (1.0 - NEARLY_ALL) * point.deviation.powi(2);
        let room = |point: &AllanPoint| {
            let most = bound(point.deviation, point.degrees_of_freedom, self.chance_at_a_point());
            most / terms(point.tau_s)[of].sqrt()
        };
        self.points.iter().skip_while(is_taken).map(room).fold(f64::INFINITY, f64::min)
    }
}
