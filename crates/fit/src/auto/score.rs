//! Candidates compared on what they were not fitted to.

use super::candidates::Spec;
use super::features::Features;
use super::gram::Gram;
use super::sample::Sample;
use crate::boot::booted;
use crate::choose::standard_error;
use crate::folds::{FOLDS, rows_of_fold};

/// The ends of temperature that are held out: as many groups each as a fold.
const ENDS: usize = 2;

/// Groups further apart than this are of two visits: a few that were left out do not end one.
const VISIT_GAP: usize = 8;

/// The errors of a candidate, mean squares.
#[derive(Debug, Clone)]
pub(super) struct Scored {
    /// A fold or an end each: within the recording plus as deployed.
    pub of_folds: Vec<f64>,
    /// Over the folds: within the recording, and as deployed.
    pub in_recording: f64,
    pub deployed: f64,
    /// With the cold and the hot end held out.
    pub ends: [f64; ENDS],
    /// Over the folds: heating, cooling; NaN without such groups.
    pub by_direction: [f64; 2],
    pub in_sample: f64,
}

impl Scored {
    pub(super) fn mean(&self) -> f64 {
        self.of_folds.iter().sum::<f64>() / self.of_folds.len() as f64
    }
}

/// Sums of a held-out part: of the rows as they are, and of the rows less the mean of its first ones.
struct Fold {
    whole: Gram,
    zeroed: Gram,
    /// Heating and cooling.
    directions: [Gram; 2],
}

/// What all candidates are scored on.
pub(super) struct FoldSums {
    all: Gram,
    folds: Vec<Fold>,
    time: usize,
}

impl FoldSums {
    /// Cuts the used rows of a sample into eight folds, and once more into its two ends.
    pub(super) fn new(features: &Features, sample: &Sample<'_>) -> Self {
        let used = &sample.used;
        let mut parts: Vec<&[usize]> = (0..FOLDS).map(|fold| &used[rows_of_fold(fold, used.len())]).collect();
        let mut by_temperature = used.clone();
        by_temperature.sort_by(|&a, &b| sample.temperature(a).total_cmp(&sample.temperature(b)));
        let end = used.len() / FOLDS;
        let (cold, hot) = by_temperature.split_at(used.len() - end);
        let mut ends = [cold[..end].to_vec(), hot.to_vec()];
        ends.iter_mut().for_each(|end| end.sort_unstable());
        parts.extend(ends.iter().map(Vec::as_slice));
        let folds: Vec<Fold> = parts.into_iter().map(|part| Fold::new(features, sample, part)).collect();
        let mut all = Gram::new(features.columns);
        folds[..FOLDS].iter().for_each(|fold| all.add(&fold.whole, 1.0));
        Self { all, folds, time: features.time_column() }
    }

    /// The sums of all rows but a fold's or an end's.
    pub(super) fn without(&self, fold: usize) -> Gram {
        let mut rest = self.all.clone();
        rest.add(&self.folds[fold].whole, -1.0);
        rest
    }

    /// Scores every candidate that the rows settle; the others are `None`.
    pub(super) fn score(&self, specs: &[Spec]) -> Vec<Option<Scored>> {
        let rests: Vec<Gram> = (0..self.folds.len()).map(|fold| self.without(fold)).collect();
        specs.iter().map(|spec| self.score_one(spec, &rests)).collect()
    }

    fn score_one(&self, spec: &Spec, rests: &[Gram]) -> Option<Scored> {
        let penalised = spec.penalised();
        let in_sample = self.all.mean_square(&spec.columns, &self.all.solve(&penalised)?);
        let mut of_folds = Vec::with_capacity(self.folds.len());
        let (mut in_recording, mut deployed, mut weight) = (0.0, 0.0, 0.0);
        let mut ends = [f64::NAN; ENDS];
        let mut by_direction = [(0.0, 0.0); 2];
        for (place, (fold, rest)) in self.folds.iter().zip(rests).enumerate() {
            if fold.whole.weight <= 0.0 {
                continue;
            }
            let beta = rest.solve(&penalised)?;
            let own = fold.whole.mean_square(&spec.columns, &beta);
            let timeless = spec.columns.len() - usize::from(spec.columns.last() == Some(&self.time));
            let zeroed = if fold.zeroed.weight > 0.0 {
                fold.zeroed.mean_square(&spec.columns[..timeless], &beta[..timeless])
            } else {
                own
            };
            of_folds.push(own + zeroed);
            if place >= FOLDS {
                ends[place - FOLDS] = own;
                continue;
            }
            in_recording += own * fold.whole.weight;
            deployed += zeroed * fold.whole.weight;
            weight += fold.whole.weight;
            for (sum, gram) in by_direction.iter_mut().zip(&fold.directions).filter(|(_, gram)| gram.weight > 0.0) {
                sum.0 += gram.weight * gram.mean_square(&spec.columns, &beta);
                sum.1 += gram.weight;
            }
        }
        Some(Scored {
            of_folds,
            in_recording: in_recording / weight,
            deployed: deployed / weight,
            ends,
            by_direction: by_direction.map(|(sum, weight)| sum / weight),
            in_sample,
        })
    }
}

impl Fold {
    fn new(features: &Features, sample: &Sample<'_>, part: &[usize]) -> Self {
        let gram = || Gram::new(features.columns);
        let mut fold = Self { whole: gram(), zeroed: gram(), directions: [gram(), gram()] };
        for &group in part {
            let (rate, weight) = (sample.rate(group), sample.weight(group));
            fold.whole.push(features.row(group), rate, weight);
            if let Some(direction) = sample.direction(group) {
                fold.directions[direction].push(features.row(group), rate, weight);
            }
        }
        // An end is visited at times far apart: a zero is taken at each visit.
        let mut visits = part;
        while !visits.is_empty() {
            let along = |pair: &&[usize]| pair[1] - pair[0] <= VISIT_GAP;
            let (visit, rest) = visits.split_at(1 + visits.windows(2).take_while(along).count());
            fold.push_zeroed(features, sample, visit);
            visits = rest;
        }
        fold
    }

    /// Takes in a visit less the mean of its first half minute.
    fn push_zeroed(&mut self, features: &Features, sample: &Sample<'_>, visit: &[usize]) {
        let booted = booted(sample.times(), visit);
        let mut zero = vec![0.0; features.columns];
        let mut zero_rate = 0.0;
        for &group in &visit[..booted] {
            zero.iter_mut().zip(features.row(group)).for_each(|(zero, value)| *zero += value / booted as f64);
            zero_rate += sample.rate(group) / booted as f64;
        }
        let mut row = vec![0.0; features.columns];
        for &group in &visit[booted..] {
            row.iter_mut().zip(features.row(group).iter().zip(&zero)).for_each(|(row, (a, b))| *row = a - b);
            self.zeroed.push(&row, sample.rate(group) - zero_rate, sample.weight(group));
        }
    }
}

/// The place of the simplest candidate that is not worse: within one standard error of the best, from the differences
/// fold by fold (after Breiman et al., *Classification and Regression Trees*, 1984, 3.4.3, with the error of the
/// difference in place of the error of the best), and the standard error of each.
///
/// Only candidates that are no worse at either end than a straight line or a cubic, whichever is more accurate there, and
/// no worse in either direction of the ramp than the cubic, are looked at; where there is none, the one that fails by least.
pub(super) fn choose(specs: &[Spec], scored: &[Option<Scored>]) -> Option<(usize, Vec<f64>)> {
    let of =
        |order: usize| specs.iter().position(|spec| spec.is_static(order)).and_then(|place| scored[place].as_ref());
    let least = scored.iter().flatten().map(|own| own.in_sample).fold(f64::INFINITY, f64::min);
    let ratio = |own: f64, allowed: f64| ratio(own - NOISE * least, allowed);
    // What the cubic leaves of the whole is what there is to gain.
    let small = SMALL_AT_AN_END * of(3).map_or(0.0, |cubic| cubic.in_recording);
    let excess = |scored: &Scored| {
        let mut worst = 0.0_f64;
        for end in 0..ENDS {
            let allowed = [1, 3].into_iter().filter_map(of).map(|other| other.ends[end]).fold(f64::INFINITY, f64::min);
            worst = worst.max(ratio(scored.ends[end] - small, allowed));
        }
        for direction in 0..2 {
            let allowed = of(3).map_or(f64::INFINITY, |other| other.by_direction[direction]);
            worst = worst.max(ratio(scored.by_direction[direction], allowed));
        }
        worst
    };
    let settled = || specs.iter().enumerate().filter_map(|(place, _)| scored[place].as_ref().map(|own| (place, own)));
    let mut allowed: Vec<(usize, &Scored)> = settled().filter(|(_, own)| excess(own) <= 1.0).collect();
    if allowed.is_empty() {
        allowed.extend(settled().min_by(|a, b| excess(a.1).total_cmp(&excess(b.1))));
    }
    let (_, best) = allowed.iter().min_by(|a, b| a.1.mean().total_cmp(&b.1.mean()))?;
    let errors: Vec<f64> = scored.iter().map(|own| own.as_ref().map_or(f64::NAN, |own| error(own, best))).collect();
    let not_worse = |place: usize, own: &Scored| {
        own.mean() <= best.mean() + errors[place] + 2.0 * NOISE_OF_ALL * least && worse_folds(own, best) < WORSE_FOLDS
    };
    let simplest = allowed.iter().find(|(place, own)| not_worse(*place, own))?.0;
    Some((simplest, errors))
}

/// A mean square over the groups of a part, 50 of them, is known to `sqrt(2 / 50)` of the noise in it: two candidates that
/// are the same but for noise differ by about so much. The noise is at most what the best fit of everything leaves.
const NOISE: f64 = 0.2;

/// The same over 400 groups: what the best of many candidates gains by chance. A score is the sum of two mean squares.
const NOISE_OF_ALL: f64 = 0.07;

/// A mean square at an end that is this small against what the cubic leaves of the whole recording (a seventh of its rms)
/// speaks against nobody: there a chamber stands nearly still, and a static curve is at its best, however far it is off
/// on the way.
const SMALL_AT_AN_END: f64 = 0.02;

/// How many times another mean square one is; 0 where there is nothing to compare.
fn ratio(own: f64, allowed: f64) -> f64 {
    let ratio = own / allowed;
    if ratio.is_nan() { 0.0 } else { ratio }
}

/// Held-out parts of ten on which a candidate is worse than the best by more than a twentieth, from which on it is worse
/// whatever the standard error says: of a fair coin, 9 or more of 10 are heads once in a hundred. A few parts with large
/// errors would else hide what all of them say.
const WORSE_FOLDS: usize = 9;

fn worse_folds(own: &Scored, best: &Scored) -> usize {
    own.of_folds.iter().zip(&best.of_folds).filter(|(own, best)| **own > 1.05 * **best).count()
}

/// The standard error of the difference of two means over the folds.
fn error(own: &Scored, best: &Scored) -> f64 {
    let differences: Vec<f64> = own.of_folds.iter().zip(&best.of_folds).map(|(own, best)| own - best).collect();
    standard_error(&differences)
}
