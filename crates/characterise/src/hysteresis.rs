//! Heating less cooling at equal temperature.

use std::collections::BTreeMap;
use zerorate_cal::units::{RateScale, WrittenRate};

use serde::Serialize;
use zerorate_cal::log_fit::AxisFit;
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

/// Heating less cooling in one bin.
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
                "the temperature spans {:.1} {} and too little for it: let it warm and cool by {:.0}",
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
        let noise = noise(&points.iter().map(|point| point.residual).collect::<Vec<_>>());
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
        let walk = walk(&both, noise);
        let error_of = |own: f64, weights: &Weights| (noise * own).hypot(walk * weights.spread());
        let mean_standard_error = error_of(mean_error, &mean_weights);
        let is_apart = |value: f64, error: f64| value.abs() > APART * error;
        if !is_apart(mean, mean_standard_error)
            && !both.iter().any(|own| own.value.abs() > TELLING * error_of(own.error, &own.weights))
        {
            let scale = RateScale::of(axis.calibration.rate_unit, &[mean, mean_standard_error], asked);
            return Err(format!(
                "heating and cooling differ on average by {} ± {}, which is not told apart from wandering in time; {} cycles do",
                scale.number(mean),
                scale.told(mean_standard_error),
                if has_cycles(points, warming) { "more" } else { "several" }
            ));
        }
        // The largest of many noisy bins is the noisiest: each counts as what it is likely to be.
        let (values, errors): (Vec<f64>, Vec<f64>) =
            both.iter().map(|own| (own.value, error_of(own.error, &own.weights))).unzip();
        let likely = shrunk(&values, &errors).into_iter().zip(&both);
        let ((largest, standard_error), place) =
            likely.max_by(|(a, _), (b, _)| a.0.abs().total_cmp(&b.0.abs())).ok_or("no temperature")?;
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

/// K of a walk by which the differences wander from one temperature to another, with its standard error on top. Of the steps the
/// one that allows least: a hysteresis changes with temperature too, where it turns round most, and so by their median. The curve
/// has no part in the differences, so that none of the wandering is taken away by a fit.
fn walk(differences: &[Difference], noise: f64) -> f64 {
    let of_step = |step: usize| {
        let part = |(one, other): (&Difference, &Difference)| {
            let mut weights = other.weights.clone();
            weights.add(&one.weights, -1.0);
            let of_noise = noise.powi(2) * (one.error.powi(2) + other.error.powi(2));
            Step { square: (other.value - one.value).powi(2), of_walk: weights.spread().powi(2), of_noise }
        };
        let steps: Vec<Step> = differences.iter().zip(differences.iter().skip(step)).map(part).collect();
        let square = likely(&steps);
        // A square of normal noise has twice its variance squared; steps that overlap tell as one.
        let squares: f64 = steps.iter().map(|own| own.expected(square).powi(2)).sum();
        let whole: f64 = steps.iter().map(|own| own.of_walk).sum();
        square + MEDIAN_ERROR * (2.0 * step as f64 * squares).sqrt() / whole
    };
    let found = STEPS.into_iter().filter(|step| 2 * step <= differences.len()).map(of_step);
    let least = found.filter(|square| square.is_finite()).fold(f64::INFINITY, f64::min);
    if least.is_finite() { least.sqrt() } else { 0.0 }
}

/// How a difference changes over some bins: the square of it, and what a walk of one and noise make of that.
struct Step {
    square: f64,
    of_walk: f64,
    of_noise: f64,
}

impl Step {
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

/// Whether there are two passes or more in each direction, each over half of the temperatures and more.
fn has_cycles(points: &[TracePoint], warming: &[bool]) -> bool {
    let (min, max) = span(points);
    let places: Vec<usize> = (0..points.len()).collect();
    let mut passes = [0, 0];
    for pass in places.chunk_by(|a, b| warming[*a] == warming[*b] && points[*a].log == points[*b].log) {
        let (from, to) = (points[pass[0]].temperature, points[pass[pass.len() - 1]].temperature);
        passes[usize::from(warming[pass[0]])] += usize::from((to - from).abs() > 0.5 * (max - min));
    }
    passes.iter().all(|passes| *passes >= 2)
}

/// The mean over the bins, each counting alike, its error for noise of one, and what each point weighs.
fn mean_of(differences: &[Difference]) -> (f64, f64, Weights) {
    let bins = differences.len() as f64;
    let value = differences.iter().map(|own| own.value).sum::<f64>() / bins;
    let mut weights = Weights::default();
    differences.iter().for_each(|own| weights.add(&own.weights, 1.0 / bins));
    (value, differences.iter().map(|own| own.error.powi(2)).sum::<f64>().sqrt() / bins, weights)
}

/// One direction's points in a bin.
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
    let (min, max) = span(points);
    let mut bins: BTreeMap<(usize, u32), [Direction; 2]> = BTreeMap::new();
    for ((point, warming), left) in points.iter().zip(warming).zip(left) {
        // Below 40.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bin = (((point.temperature - min) / (max - min) * BINS as f64) as usize).min(BINS - 1);
        let direction = &mut bins.entry((bin, point.log)).or_default()[usize::from(*warming)];
        direction.sum += left;
        direction.places.push((point.log, point.time_s));
    }
    let of_log = |((bin, _), [cooling, heating]): (&(usize, u32), &[Direction; 2])| {
        let value = heating.sum / heating.count() - cooling.sum / cooling.count();
        value.is_finite().then(|| {
            let mut weights = heating.weights(1.0);
            weights.add(&cooling.weights(1.0), -1.0);
            Difference { bin: *bin, value, error: (1.0 / heating.count() + 1.0 / cooling.count()).sqrt(), weights }
        })
    };
    let of_logs: Vec<Difference> = bins.iter().filter_map(of_log).collect();
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
