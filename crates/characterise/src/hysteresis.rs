//! Heating less cooling at equal temperature.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::Serialize;
use zerorate_cal::log_fit::AxisFit;
use zerorate_cal::units::{RateScale, WrittenRate};
use zerorate_fit::robust::{median, noise};
use zerorate_fit::shrinkage::shrunk;
use zerorate_fit::trace::TracePoint;

use super::span;

/// Bins of temperature in which the two directions are compared.
const BINS: usize = 40;

/// Bins that both directions must have, at least, for a hysteresis.
const LEAST_BINS: usize = 5;

/// Beyond so many standard errors a difference is told from noise: of normal noise the largest of forty is in one log in some
/// 400 (Bonferroni).
const TELLING: f64 = 4.0;

/// Beyond so many standard errors, the wandering in them, a difference is told from wandering in time: of drawn walks one in a
/// hundred is. It is not normal noise's one in 370, for K is found from some forty steps.
const APART: f64 = 3.0;

/// Bins over which the wandering is looked at: a short step is of noise, a long one takes in what the hysteresis itself does.
const STEPS: [usize; 4] = [1, 2, 4, 8];

/// Thermal hysteresis of the bias.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Hysteresis {
    /// Heating less cooling on average over the temperatures that both directions have, rate.
    pub mean: f64,
    /// Its standard error, by the noise from one average to the next and by how far the rate wanders meanwhile.
    pub mean_standard_error: f64,
    /// Heating less cooling where it is likely to be largest: each temperature's difference drawn towards the mean by the share of
    /// noise in how they scatter ([`shrunk`]).
    pub largest: f64,
    /// Its standard error.
    pub standard_error: f64,
    /// Where that is.
    pub at: f64,
    /// Root mean square over those temperatures, less what noise makes.
    pub rms: f64,
    /// The largest over the peak to peak of the bias, 0 to 1 and more; NaN, in JSON null, where the bias does not change.
    pub share: f64,
    /// Whether the log holds one cycle: what it shows may be of time as well as of direction.
    pub one_cycle: bool,
    /// The mean less the drift in time that the fit found, where that makes another: one cycle does not tell the two
    /// apart.
    pub less_drift_in_time: Option<f64>,
}

/// The median of the square of normal noise of one: chi-squared of one degree of freedom.
const MEDIAN_SQUARE: f64 = 0.4549;

/// A variance by the median has an error this much larger than one by the mean of squares: 1 / sqrt(0.37) (Rousseeuw and Croux,
/// 1993).
const MEDIAN_ERROR: f64 = 1.64;

/// Halvings by which K's square is found: to a part in 10^12 of the largest.
const HALVINGS: u32 = 40;

/// Heating less cooling in one bin, or one pass less another.
struct Difference {
    bin: usize,
    value: f64,
    /// For noise of one from one average to the next.
    error: f64,
    /// What each point weighs in it.
    weights: Weights,
}

impl Hysteresis {
    /// The two directions, bin by bin; `less_drift_in_time` is what the curve leaves of each point but for that drift.
    pub(super) fn of(
        axis: &AxisFit,
        points: &[TracePoint],
        warming: &[bool],
        less_drift_in_time: &[f64],
        asked: Option<WrittenRate>,
    ) -> Result<Self, String> {
        let ((min, max), unit) = (span(points), axis.temperature_unit);
        if max - min < unit.min_span() {
            return Err(format!(
                "the temperature spans {0:.1} {1}, too little to tell it: let it warm and cool by {2:.0} {1} or more",
                max - min,
                unit.name(),
                unit.min_span()
            ));
        }
        // Less the curve, so that a bin's width is no hysteresis.
        let curve = axis.calibration.drift();
        let recorded: Vec<f64> = points.iter().map(|point| point.rate - curve.evaluate(point.temperature).0).collect();
        let both = differences(points, warming, &recorded);
        if both.len() < LEAST_BINS {
            return Err(
                "the log holds one direction of the temperature, or one before and one after an interruption; let it warm and cool over the same range in one go".to_owned()
            );
        }
        let averages = Averages::of(points);
        let noise = averages.noise;
        let largest = both.iter().max_by(|a, b| a.value.abs().total_cmp(&b.value.abs())).ok_or("no temperature")?;
        let (mean, mean_error, mean_weights) = mean_of(&both);
        let is_noise = |value: f64, error: f64| value.abs() <= TELLING * error;
        if is_noise(largest.value, noise * largest.error) && is_noise(mean, noise * mean_error) {
            let scale = RateScale::of(axis.calibration.rate_unit, &[mean, noise * mean_error], asked);
            return Err(format!(
                "heating and cooling differ nowhere by more than {TELLING:.0} standard errors, on average by {} ± {}",
                scale.number(mean),
                scale.told(noise * mean_error)
            ));
        }
        // Wandering and noise are of each other independent.
        let walk = walk(&both, &from_pass_to_pass(points, warming, &recorded), averages);
        let error_of = |own: f64, weights: &Weights| (noise * own).hypot(walk * weights.spread());
        let mean_standard_error = error_of(mean_error, &mean_weights);
        let is_apart = |value: f64, error: f64| value.abs() > APART * error;
        if !is_apart(mean, mean_standard_error)
            && !both.iter().any(|own| own.value.abs() > TELLING * error_of(own.error, &own.weights))
        {
            let scale = RateScale::of(axis.calibration.rate_unit, &[mean, mean_standard_error], asked);
            return Err(format!(
                "heating and cooling differ on average by {} ± {}, which may as well be wandering in time; a log of {} cycles can tell them apart",
                scale.number(mean),
                scale.told(mean_standard_error),
                if has_cycles(points, warming) { "more" } else { "several" }
            ));
        }
        // The largest of many noisy bins is the noisiest: each counts as what it is likely to be.
        let (values, errors): (Vec<f64>, Vec<f64>) =
            both.iter().map(|own| (own.value, error_of(own.error, &own.weights))).unzip();
        let likely = shrunk(&values, &errors).into_iter().zip(&both);
        let ((largest, own_error), place) =
            likely.max_by(|(a, _), (b, _)| a.0.abs().total_cmp(&b.0.abs())).ok_or("no temperature")?;
        // What is drawn to the mean is known no better than that, and wandering is an error that all temperatures have in common.
        let to_the_mean = values.iter().sum::<f64>() / values.len() as f64 - place.value;
        let drawn = if to_the_mean == 0.0 { 0.0 } else { (largest - place.value) / to_the_mean };
        let standard_error = own_error.hypot(drawn * mean_standard_error);
        let squares: f64 = both.iter().map(|own| own.value.powi(2) - error_of(own.error, &own.weights).powi(2)).sum();
        let less = mean_of(&differences(points, warming, less_drift_in_time)).0;
        Ok(Self {
            mean,
            mean_standard_error,
            largest,
            standard_error,
            at: min + (max - min) * (place.bin as f64 + 0.5) / BINS as f64,
            rms: (squares.max(0.0) / both.len() as f64).sqrt(),
            share: largest.abs() / axis.calibration.measured_drift().peak_to_peak(),
            one_cycle: !has_cycles(points, warming),
            less_drift_in_time: Some(less).filter(|less| !is_noise(less - mean, noise * mean_error)),
        })
    }
}

/// What the points of a log weigh in a difference: log and time of each.
#[derive(Debug, Clone, Default)]
struct Weights(Vec<((u32, f64), f64)>);

impl Weights {
    fn add(&mut self, other: &Self, times: f64) {
        self.0.extend(other.0.iter().map(|(place, weight)| (*place, weight * times)));
    }

    /// The standard deviation of the weighed sum of a walk of one over the root of a second: each of its steps counts as much as
    /// all points after it weigh. Within a log the weights come to nothing, so that nothing goes from one to the next.
    fn spread(&self) -> f64 {
        let mut sorted = self.0.clone();
        sorted.sort_by(|(a, _), (b, _)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut before = 0.0;
        let steps = sorted.windows(2).map(|pair| {
            let ((log, time_s), weight) = pair[0];
            before += weight;
            let (next, next_s) = pair[1].0;
            let lasts_s = if next == log { next_s - time_s } else { 0.0 };
            // Without times nothing is known of it.
            if lasts_s.is_finite() { before * before * lasts_s } else { 0.0 }
        });
        steps.sum::<f64>().sqrt()
    }
}

/// K of a walk by which the rate wanders, with its standard error on top. Two things show it, and the smaller of the two holds, for
/// each may have something else in it: how heating less cooling goes on from one temperature to another, where a hysteresis turns
/// round, and where there are several cycles, how a pass differs from the one before it in the same direction. The curve has no part
/// in either, so that none of the wandering is taken away by a fit.
fn walk(differences: &[Difference], from_pass_to_pass: &[Vec<Difference>], averages: Averages) -> f64 {
    let of_cycles = from_temperature_to_temperature(from_pass_to_pass, averages);
    // A drift that goes on evenly is nowhere but in how far the passes are apart.
    let apart: Vec<Step> = from_pass_to_pass.iter().flatten().filter_map(|own| Step::of(own, None, averages)).collect();
    let of_cycles = of_cycles.max(likely(&apart));
    let least = from_temperature_to_temperature(&[differences], averages).min(of_cycles);
    if least.is_finite() { least.sqrt() } else { 0.0 }
}

/// The square of K by how differences go on over some bins, of the numbers of bins the one that allows least: a difference may turn
/// round somewhere, and so by the median. Infinite where nothing is told.
fn from_temperature_to_temperature(differences: &[impl AsRef<[Difference]>], averages: Averages) -> f64 {
    let of_step = |step: usize| {
        let steps = differences.iter().map(AsRef::as_ref).flat_map(|own| {
            own.iter().zip(own.iter().skip(step)).filter_map(|(one, other)| Step::of(other, Some(one), averages))
        });
        let steps: Vec<Step> = steps.collect();
        // Steps that overlap tell as one.
        if steps.len() < step { f64::INFINITY } else { allowed(&steps, step as f64) }
    };
    STEPS.into_iter().map(of_step).fold(f64::INFINITY, f64::min)
}

/// The square of K that steps allow, of which so many tell as one: the likely one and its standard error.
fn allowed(steps: &[Step], tell_as_one: f64) -> f64 {
    let square = likely(steps);
    // A square of normal noise has twice its variance squared.
    let squares: f64 = steps.iter().map(|own| own.expected(square).powi(2)).sum();
    let whole: f64 = steps.iter().map(|own| own.of_walk).sum();
    square + MEDIAN_ERROR * (2.0 * tell_as_one * squares).sqrt() / whole
}

/// The points, each an average of the rate over a while.
///
/// In their noise by second differences is a sixth of K squared times the period; and two averages wander a third of a period less
/// than the time between them. A sum that weighs points by w has so K squared times a third of a period times the sum of w squared
/// less of a walk than one of moments with noise of their own.
#[derive(Clone, Copy)]
struct Averages {
    noise: f64,
    period_s: f64,
}

impl Averages {
    fn of(points: &[TracePoint]) -> Self {
        let mut lasts_s: Vec<f64> = points
            .windows(2)
            .filter(|pair| pair[0].log == pair[1].log)
            .map(|pair| pair[1].time_s - pair[0].time_s)
            .filter(|lasts_s| lasts_s.is_finite())
            .collect();
        let period_s = if lasts_s.is_empty() { 0.0 } else { median(&mut lasts_s) };
        Self { noise: noise(&points.iter().map(|point| point.residual).collect::<Vec<_>>()), period_s }
    }
}

/// How far something goes: the square of it, and what a walk of one and noise make of that.
struct Step {
    square: f64,
    of_walk: f64,
    of_noise: f64,
}

impl Step {
    /// A difference, less another if there is one; `None` where nothing of a walk is in it.
    fn of(own: &Difference, less: Option<&Difference>, averages: Averages) -> Option<Self> {
        let mut weights = own.weights.clone();
        less.iter().for_each(|less| weights.add(&less.weights, -1.0));
        let [value, error] = less.map_or([0.0; 2], |less| [less.value, less.error]);
        let of_noise_of_one = own.error.powi(2) + error.powi(2);
        let of_walk = weights.spread().powi(2) - averages.period_s / 3.0 * of_noise_of_one;
        let (square, of_noise) = ((own.value - value).powi(2), averages.noise.powi(2) * of_noise_of_one);
        (of_walk > 0.0).then_some(Self { square, of_walk, of_noise })
    }

    fn expected(&self, walk: f64) -> f64 {
        walk * self.of_walk + self.of_noise
    }
}

/// The square of K by which half of the steps are smaller than half of normal noise is: by halving, for the share falls as K grows.
fn likely(steps: &[Step]) -> f64 {
    let too_small = |walk: f64| {
        median(&mut steps.iter().map(|own| own.square / own.expected(walk)).collect::<Vec<_>>()) > MEDIAN_SQUARE
    };
    let largest = steps.iter().map(|own| own.square / own.of_walk).fold(0.0, f64::max) / MEDIAN_SQUARE;
    if !too_small(0.0) || !largest.is_finite() {
        return 0.0;
    }
    let (mut low, mut high) = (0.0, largest);
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        if too_small(middle) { low = middle } else { high = middle }
    }
    high
}

/// The passes: points in one direction, over half of the temperatures and more.
fn passes(points: &[TracePoint], warming: &[bool]) -> Vec<Range<usize>> {
    let (min, max) = span(points);
    let places: Vec<usize> = (0..points.len()).collect();
    let runs = places.chunk_by(|a, b| warming[*a] == warming[*b] && points[*a].log == points[*b].log);
    let ends = runs.map(|run| run[0]..run[run.len() - 1] + 1);
    let is_long = |run: &Range<usize>| {
        (points[run.end - 1].temperature - points[run.start].temperature).abs() > 0.5 * (max - min)
    };
    ends.filter(is_long).collect()
}

/// Whether there are two passes or more in each direction.
fn has_cycles(points: &[TracePoint], warming: &[bool]) -> bool {
    let heating = |pass: &Range<usize>| warming[pass.start];
    let passes = passes(points, warming);
    let heated = passes.iter().filter(|pass| heating(pass)).count();
    heated >= 2 && passes.len() - heated >= 2
}

/// Each pass less the one before it in the same direction, bin by bin: no hysteresis is in it.
fn from_pass_to_pass(points: &[TracePoint], warming: &[bool], left: &[f64]) -> Vec<Vec<Difference>> {
    let passes = passes(points, warming);
    let is_alike = |one: usize, other: usize| points[one].log == points[other].log && warming[one] == warming[other];
    let of_pass = |(place, later): (usize, &Range<usize>)| {
        let before = passes[..place].iter().rev().find(|before| is_alike(before.start, later.start))?;
        let is_later: Vec<bool> = (0..points.len()).map(|place| later.contains(&place)).collect();
        let part_of: Vec<Option<u32>> =
            (0..points.len()).map(|place| (later.contains(&place) || before.contains(&place)).then_some(0)).collect();
        Some(of_parts(points, &is_later, left, &part_of))
    };
    passes.iter().enumerate().filter_map(of_pass).collect()
}

/// The mean over the bins, each counting alike, its error for noise of one, and what each point weighs.
fn mean_of(differences: &[Difference]) -> (f64, f64, Weights) {
    let bins = differences.len() as f64;
    let value = differences.iter().map(|own| own.value).sum::<f64>() / bins;
    let mut weights = Weights::default();
    differences.iter().for_each(|own| weights.add(&own.weights, 1.0 / bins));
    (value, differences.iter().map(|own| own.error.powi(2)).sum::<f64>().sqrt() / bins, weights)
}

/// One direction's points, or those of one pass, in a bin.
#[derive(Default)]
struct Direction {
    sum: f64,
    places: Vec<(u32, f64)>,
}

impl Direction {
    fn count(&self) -> f64 {
        self.places.len() as f64
    }

    fn weights(&self, times: f64) -> Weights {
        Weights(self.places.iter().map(|place| (*place, times / self.count())).collect())
    }
}

/// Heating less cooling in each bin, within a log: from one log to the next the rate may jump for reasons of its own.
fn differences(points: &[TracePoint], warming: &[bool], left: &[f64]) -> Vec<Difference> {
    let log_of: Vec<Option<u32>> = points.iter().map(|point| Some(point.log)).collect();
    let of_logs = of_parts(points, warming, left, &log_of);
    // Each log's difference counts by how well it is known.
    let joined = |logs: &[Difference]| {
        let weight = |own: &Difference| own.error.powi(-2);
        let whole: f64 = logs.iter().map(weight).sum();
        let value = logs.iter().map(|own| own.value * weight(own)).sum::<f64>() / whole;
        let mut weights = Weights::default();
        logs.iter().for_each(|own| weights.add(&own.weights, weight(own) / whole));
        Difference { bin: logs[0].bin, value, error: whole.sqrt().recip(), weights }
    };
    of_logs.chunk_by(|a, b| a.bin == b.bin).map(joined).collect()
}

/// Heating less cooling, or one kind of points less the other, in each bin and each part of the recording, by bin and then by part;
/// points of no part are left out.
fn of_parts(points: &[TracePoint], is_one: &[bool], left: &[f64], part_of: &[Option<u32>]) -> Vec<Difference> {
    let (min, max) = span(points);
    let mut bins: BTreeMap<(usize, u32), [Direction; 2]> = BTreeMap::new();
    for (((point, is_one), left), part) in points.iter().zip(is_one).zip(left).zip(part_of) {
        let Some(part) = *part else { continue };
        // Below 40.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bin = (((point.temperature - min) / (max - min) * BINS as f64) as usize).min(BINS - 1);
        let direction = &mut bins.entry((bin, part)).or_default()[usize::from(*is_one)];
        direction.sum += left;
        direction.places.push((point.log, point.time_s));
    }
    let of_part = |((bin, _), [other, one]): (&(usize, u32), &[Direction; 2])| {
        let value = one.sum / one.count() - other.sum / other.count();
        value.is_finite().then(|| {
            let mut weights = one.weights(1.0);
            weights.add(&other.weights(1.0), -1.0);
            Difference { bin: *bin, value, error: (1.0 / one.count() + 1.0 / other.count()).sqrt(), weights }
        })
    };
    bins.iter().filter_map(of_part).collect()
}
