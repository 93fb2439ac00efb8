//! `--model auto` on groups: static curve, history and drift in time, chosen on data that were not fitted.
//!
//! A fit is a function of groups (time, temperature, rate, weight) and of nothing else. Candidates
//! (`candidates`) are compared on eight folds and on the two ends of temperature (`score`), the
//! simplest that is not worse is taken, and the number that is reported for it comes from an outer split that played no
//! part in choosing (`nested`): for each of eight folds the whole choice is made anew from the other seven. A choice that
//! does worse there than a cubic is dropped for the best plain curve. Every fit is robust and drawn towards less (`sample`, `gram`).
//!
//! A model with a history is deployed beside the best static cubic, on which it leans while its history is unknown
//! ([`zerorate_core::drift::History`]).

mod band;
mod candidates;
mod deployed;
mod features;
mod gram;
mod nested;
mod sample;
mod score;

mod thinned;

use std::ops::Range;

use zerorate_core::drift::{Drift, MAX_ORDER, ValidRange};

use crate::drift_fit::{Candidate, DriftFit, FitStatistics, ResidualOver, finite};
use crate::least_squares::{Basis, FitError, Solution};
use crate::model::Model;
use crate::predict::{DriftModel, Predictor, Start};
use crate::residual::ResidualStatistics;
use crate::series::Series;
use crate::trend::trends;
use candidates::{Among, Spec, candidates};
use features::{Features, TABLE_INTERVALS};
use nested::Outer;
use sample::Sample;
use score::{FoldSums, Scored};
use thinned::Thinned;

/// The shrinkage of the fit that finds out which groups to believe; weak, for it has every column.
const PILOT_SHRINKAGE: f64 = 1e-4;

/// How far past the measured temperatures a polynomial chosen by `auto` is believed before it is held, as a fraction of
/// the span at each end. It was tested that far: chosen with the groups at either end held out, as many as a fold. The
/// next flight may start a little colder.
const BEYOND: f64 = 1.0 / 8.0;

/// The highest order of the plain curves that are fallen back on.
const PLAINEST: usize = 3;

/// What came of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupFit {
    /// The model and how well it holds.
    pub fit: DriftFit,
    /// Rate less prediction with the drift in time, a group each; NaN for one that was not used.
    pub residuals: Vec<f64>,
}

/// Fits a series: `auto`, or the model asked for alone, without history and drift in time.
///
/// `measured` is the least and greatest temperature of the groups that have a rate. `auto` believes its curve
/// further than that, by a fraction of the span at each end, where it was tested; another model is held at the ends.
///
/// # Errors
/// [`FitError`], when the groups do not settle the model, or no model.
pub fn fit(series: &Series<'_>, measured: ValidRange, asked: Model) -> Result<GroupFit, FitError> {
    let whole = Prepared::new(series, measured, asked).ok_or(FitError::NotFinite)?;
    let thinned = Thinned::of(series);
    let coarse_series = thinned.series();
    let coarse = Prepared::new(&coarse_series, measured, asked).ok_or(FitError::NotFinite)?;
    let used = (0..series.rate.len()).filter(|&group| series.is_used(group)).count();
    let coefficients = asked.least_coefficients();
    if used < coefficients {
        return Err(FitError::TooFewRows { rows: used as u64, coefficients });
    }
    let attempt = |among: Among| {
        let chosen = coarse.choose(among, |_| true)?;
        let made = whole.fit(&chosen.spec, |_| true)?;
        Some(Attempt { chosen, made, outer: nested::outer(&whole, &coarse, &thinned, among) })
    };
    let among = if asked == Model::Auto { Among::All } else { Among::Curve(asked) };
    let mut best = attempt(among).ok_or(FitError::Undetermined { coefficients })?;
    if among == Among::All && best.outer.is_worse_than_the_cubic() {
        // A drift in time that was found is no part of what is deployed, but a curve fitted as if there were none is bent by it.
        let plain = if best.chosen.spec.terms.time { Among::CurveInTime } else { Among::Curve };
        best = plainer(best, (1..=PLAINEST).filter_map(|order| attempt(plain(Model::Poly(order)))));
    }
    Ok(best.finish(&whole, measured))
}

/// The best of some plain curves, by the outer folds, in place of a choice that predicts new data worse than a cubic does:
/// what the folds within a fold found to be better was this recording's own.
fn plainer(choice: Attempt, curves: impl Iterator<Item = Attempt>) -> Attempt {
    let error = |attempt: &Attempt| attempt.outer.figures().deployed_warm.unwrap_or(f64::INFINITY);
    let Some(mut plain) = curves.min_by(|a, b| error(a).total_cmp(&error(b))) else { return choice };
    let name = plain.chosen.spec.to_string();
    plain.chosen.candidates = choice.chosen.candidates;
    plain.chosen.candidates.iter_mut().for_each(|candidate| candidate.chosen = candidate.model == name);
    plain
}

/// A choice, its fit, and how well the two predict what they have not seen.
struct Attempt {
    chosen: Chosen,
    made: Made,
    outer: Outer,
}

impl Attempt {
    fn finish(self, whole: &Prepared<'_>, measured: ValidRange) -> GroupFit {
        let Self { chosen, made, outer } = self;
        let series = whole.series;
        let residuals = in_recording(&made.model, series);
        let in_sample = ResidualStatistics::of(residuals.iter().copied());
        let deployed = predict(&made.model, Start::Unknown, series, 0..series.rate.len());
        let held_out = match outer.complete() {
            true => ResidualStatistics::by_folds(&outer.residuals),
            false => ResidualStatistics::NONE,
        };
        let band = band::band(series, measured, outer.complete().then_some(&outer.deployed[..]), &deployed);
        let covariance = made.solution.covariance.clone();
        let statistics = FitStatistics {
            candidates: chosen.candidates,
            nested: Some(outer.figures()),
            deployed: outer.deployed(series),
            uncorrected: outer.uncorrected(series),
            trends: trends(&deployed, series),
            ..FitStatistics::new(ResidualOver::Groups, made.solution.rows, in_sample, held_out, covariance)
        };
        let static_cubic = nested::static_cubic(whole, &made, &outer);
        GroupFit { fit: DriftFit { model: made.model, measured, static_cubic, band, statistics }, residuals }
    }
}

/// What a model leaves of the groups of the recording that it was fitted to; NaN for a group that was not used.
fn in_recording(model: &DriftModel, series: &Series<'_>) -> Vec<f64> {
    predict(model, Start::OwnRecording, series, 0..series.rate.len())
}

/// Rate less prediction of some successive groups, the history starting at the first of them and anew with each log; NaN
/// for a group that was not used.
fn predict(model: &DriftModel, start: Start, series: &Series<'_>, groups: Range<usize>) -> Vec<f64> {
    let mut predictor = Predictor::new(model, start);
    groups
        .map(|group| {
            if series.begins(group) {
                predictor = Predictor::new(model, start);
            }
            let bias = predictor.predict(series.time_s[group], series.temperature[group]).bias;
            if series.is_used(group) { series.rate[group] - bias } else { f64::NAN }
        })
        .collect()
}

/// A series with its columns.
struct Prepared<'a> {
    series: &'a Series<'a>,
    features: Features,
    directions: Vec<Option<usize>>,
}

/// The choice among candidates.
struct Chosen {
    spec: Spec,
    candidates: Vec<Candidate>,
}

/// A model fitted, with what a calibration keeps beside it.
struct Made {
    model: DriftModel,
    /// The best static cubic of the same groups.
    cubic: Option<Drift>,
    /// Of the static curve in `model`.
    solution: Solution,
}

impl<'a> Prepared<'a> {
    fn new(series: &'a Series<'a>, measured: ValidRange, asked: Model) -> Option<Self> {
        let intervals = match asked {
            Model::Table(intervals) => intervals,
            Model::Auto => TABLE_INTERVALS,
            Model::Poly(_) => 1,
        };
        let beyond = if asked == Model::Auto { BEYOND } else { 0.0 };
        let features = Features::new(series, measured, beyond, intervals)?;
        let directions = sample::directions(series.temperature, measured.max() - measured.min());
        Some(Self { series, features, directions })
    }

    /// Compares the candidates on the groups that `keep` keeps.
    fn choose(&self, among: Among, keep: impl Fn(usize) -> bool) -> Option<Chosen> {
        let mut sample = Sample::new(self.series, &self.directions, keep);
        self.believe(&mut sample);
        let specs = candidates(&self.features, among);
        let folds = FoldSums::new(&self.features, &sample);
        let scored = folds.score(&specs);
        // A smoothed table is settled by one temperature; a curve is not.
        if among == Among::All && !specs.iter().zip(&scored).any(|(spec, scored)| spec.is_static(1) && scored.is_some())
        {
            return None;
        }
        let (place, errors) = score::choose(&specs, &scored)?;
        Some(Chosen { spec: specs[place].clone(), candidates: listed(&specs, &scored, &errors, place) })
    }

    /// Weighs the groups by a fit of every column there is; by fewer where they do not settle it.
    fn believe(&self, sample: &mut Sample<'_>) {
        let memories: Vec<usize> = (0..self.features.memories.len()).collect();
        let time = self.features.time.is_some();
        for order in (1..=MAX_ORDER).rev() {
            let pilot = Spec::new(&self.features, Model::Poly(order), &memories, time, PILOT_SHRINKAGE);
            if sample.fit_robustly(&self.features, &pilot.penalised()).is_some() {
                return;
            }
        }
    }

    /// Fits a candidate to the groups that `keep` keeps.
    fn fit(&self, spec: &Spec, keep: impl Fn(usize) -> bool) -> Option<Made> {
        let mut sample = Sample::new(self.series, &self.directions, &keep);
        let beta = sample.fit_robustly(&self.features, &spec.penalised())?;
        let time_drift = deployed::time_drift(&self.features, spec, &beta);
        let history =
            if spec.memories.is_empty() { None } else { deployed::history(&self.features, spec, &beta, sample.mean) };
        let timeless: Vec<f64> = (self.series.rate.iter().zip(self.series.time_s))
            .map(|(rate, time)| rate - time_drift.map_or(0.0, |drift| drift.at(*time)))
            .collect();
        let timeless = Series { rate: &timeless, ..*self.series };
        // A curve alone is what was fitted already.
        let bare = spec.memories.is_empty() && !spec.terms.time;
        let curve = if bare { Some(self.curve(spec, &sample, &beta)?) } else { None };
        let cubic = match &curve {
            Some(curve) if spec.model == Model::Poly(3) => Some(curve.clone()),
            _ => (1..=3).rev().find_map(|order| self.fit_curve(&timeless, Model::Poly(order), 0.0, &keep)),
        };
        let (drift, solution) = match (&history, curve, spec.model) {
            (Some(_), _, _) => cubic.clone()?,
            (None, Some(curve), _) => curve,
            (None, None, Model::Poly(order))
                if cubic.as_ref().is_some_and(|(_, s)| s.basis == Basis::Powers(order)) =>
            {
                cubic.clone()?
            }
            (None, None, model) => self.fit_curve(&timeless, model, spec.smooth, &keep)?,
        };
        let model = DriftModel { drift, history, time_drift };
        Some(Made { model, cubic: cubic.map(|(drift, _)| drift), solution })
    }

    /// Fits a static curve alone to rates from which the drift in time was taken off.
    fn fit_curve(
        &self,
        timeless: &Series<'_>,
        model: Model,
        smooth: f64,
        keep: impl Fn(usize) -> bool,
    ) -> Option<(Drift, Solution)> {
        let spec = Spec { smooth, ..Spec::new(&self.features, model, &[], false, 0.0) };
        let mut sample = Sample::new(timeless, &self.directions, keep);
        let beta = sample.fit_robustly(&self.features, &spec.penalised())?;
        self.curve(&spec, &sample, &beta)
    }

    /// The static curve of a fit without other terms.
    fn curve(&self, spec: &Spec, sample: &Sample<'_>, beta: &[f64]) -> Option<(Drift, Solution)> {
        let shape = deployed::curve(&self.features, spec.model, beta, sample.mean)?;
        // A table is held at its end knots whatever the range says.
        let valid = if let Model::Table(_) = spec.model { self.features.measured } else { self.features.valid };
        Some((Drift { shape, valid }, self.solution(spec, sample, beta)?))
    }

    /// The coefficients as they are deployed, with their covariance.
    fn solution(&self, spec: &Spec, sample: &Sample<'_>, beta: &[f64]) -> Option<Solution> {
        let gram = sample.gram(&self.features, &spec.columns);
        let rows = sample.used.len();
        let freedom = rows.saturating_sub(beta.len()).max(1) as f64;
        let variance = gram.mean_square(&spec.columns, beta) * rows as f64 / freedom;
        let inverse = gram.factorise(&spec.penalised())?.inverse();
        // Columns of how the deployed coefficients follow from the fitted ones; a table's are its own.
        let unit = |k: usize| (0..beta.len()).map(|i| f64::from(u8::from(i == k))).collect::<Vec<f64>>();
        let (basis, change): (Basis, Vec<Vec<f64>>) = match spec.model {
            Model::Table(intervals) => (Basis::PiecewiseLinear(intervals), (0..beta.len()).map(unit).collect()),
            _ => {
                let columns = (0..beta.len()).map(|k| features::powers_of_legendre(&unit(k)));
                (Basis::Powers(beta.len() - 1), columns.collect())
            }
        };
        let scale = gram.weight / rows as f64;
        let covariance = (0..beta.len())
            .map(|i| {
                let entry = |j: usize| -> f64 {
                    let sum = |a: usize| (0..beta.len()).map(|b| inverse[a][b] * change[b][j]).sum::<f64>();
                    (0..beta.len()).map(|a| change[a][i] * sum(a)).sum::<f64>() * variance * scale
                };
                (0..beta.len()).map(entry).collect()
            })
            .collect();
        let mut coefficients: Vec<f64> =
            (0..beta.len()).map(|i| beta.iter().zip(&change).map(|(b, column)| b * column[i]).sum()).collect();
        match spec.model {
            Model::Table(_) => coefficients.iter_mut().for_each(|knot| *knot += sample.mean),
            _ => coefficients[0] += sample.mean,
        }
        let residuals = sample.residuals(&self.features, &spec.columns, beta);
        let rms = ResidualStatistics::of(residuals).rms;
        Some(Solution { scale: self.features.scale, basis, coefficients, covariance, rms, rows: rows as u64 })
    }
}

/// The candidates as they are shown: of one model the strength of shrinkage that did best, or the one chosen.
fn listed(specs: &[Spec], scored: &[Option<Scored>], errors: &[f64], chosen: usize) -> Vec<Candidate> {
    let mut shown: Vec<usize> = Vec::new();
    for (place, spec) in specs.iter().enumerate() {
        let Some(own) = &scored[place] else { continue };
        let same = |other: &usize| specs[*other].model == spec.model && specs[*other].terms == spec.terms;
        match shown.iter().position(same) {
            None => shown.push(place),
            Some(at) => {
                let best = scored[shown[at]].as_ref().map_or(f64::INFINITY, Scored::mean);
                if shown[at] != chosen && (place == chosen || own.mean() < best) {
                    shown[at] = place;
                }
            }
        }
    }
    let best = shown.iter().filter_map(|&place| scored[place].as_ref()).map(Scored::mean).fold(f64::INFINITY, f64::min);
    let candidate = |place: usize| -> Option<Candidate> {
        let (spec, own) = (&specs[place], scored[place].as_ref()?);
        // Of the sum of two mean squares, shared by both: a - b = (a^2 - b^2) / (a + b).
        let error = errors[place] / (2.0 * (own.mean().sqrt() + best.sqrt())) * std::f64::consts::SQRT_2;
        Some(Candidate {
            model: spec.to_string(),
            in_sample_rms: own.in_sample.sqrt(),
            held_out_rms: finite(own.in_recording.sqrt()),
            held_out_excess_standard_error: finite(error),
            deployed_rms: finite(own.deployed.sqrt()),
            ends_rms: Some(own.ends.map(f64::sqrt)).filter(|ends| ends.iter().all(|end| end.is_finite())),
            by_direction_rms: Some(own.by_direction.map(|square| finite(square.sqrt()))),
            shrinkage_weight: Some(spec.shrinkage),
            chosen: place == chosen,
        })
    };
    shown.into_iter().filter_map(candidate).collect()
}

#[cfg(test)]
mod tests;
