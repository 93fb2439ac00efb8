//! `--model auto` on groups: static curve, history and drift in time, chosen on data that were not fitted.
//!
//! A fit is a function of groups (time, temperature, rate, weight) and of nothing else. Candidates
//! (`candidates`) are compared on eight contiguous stretches and on the two ends of temperature (`score`), the
//! simplest that is not worse is taken, and the number that is reported for it comes from an outer split that played no
//! part in choosing (`nested`): for each of eight stretches the whole choice is made anew from the other seven. Every
//! fit is robust and drawn towards less (`sample`, `gram`).
//!
//! A model with a history is deployed beside the best static cubic, on which it leans while its history is unknown
//! ([`zerorate_core::drift::History`]).

mod band;
mod candidates;
mod features;
mod fitted;
mod gram;
mod nested;
mod sample;
mod score;

use zerorate_core::drift::{Drift, History, MAX_ORDER, ValidRange};

use crate::calibration::{BandPoint, HeldOut, StaticCubic, TimeDrift};
use crate::choose::{Candidate, Further, Model};
use crate::fit::{Basis, FitError, Solution};
use crate::log_fit::Spread;
use candidates::{Spec, candidates};
use features::{Features, TABLE_INTERVALS};
use fitted::Fitted;
use gram::Workspace;
use sample::Sample;
use score::{Folds, Scored};

/// Groups that candidates are compared on, at most: neighbours of a longer record are averaged for the comparison, so
/// that it takes as long whatever the record. Eight stretches of fifty groups still hold turns of temperature apart.
const CHOICE_GROUPS: usize = 400;

/// The ridge of the fit that finds out which groups to believe; weak, for it has every column.
const PILOT_RIDGE: f64 = 1e-4;

/// How far past the measured temperatures a polynomial chosen by `auto` is believed before it is held, a share of the span
/// at each end: as far as it was tested there, for it was chosen with either end, an eighth of the groups, held out, and
/// is no worse on it than the better of a straight line and a cubic. The next flight may start a little colder.
const BEYOND: f64 = 1.0 / 8.0;

/// Groups of one rate column, in order of time: one entry of each slice a group.
#[derive(Debug, Clone, Copy)]
pub struct Series<'a> {
    /// Seconds from the recording's first row; NaN without a time column.
    pub time_s: &'a [f64],
    /// Mean temperature; NaN for a group without one.
    pub temperature: &'a [f64],
    /// Mean rate; NaN for a group that is not to be fitted: the history runs through its temperature all the same.
    pub rate: &'a [f64],
    /// How much a group counts against the others, above zero; 1 for all where nothing says otherwise.
    pub weight: &'a [f64],
    /// Which uninterrupted log it belongs to: the history begins anew with each.
    pub log: &'a [u32],
    /// Whether a drift in time may be told. Not where nobody could take it off: a board has no such term.
    pub drifts_in_time: bool,
}

impl Series<'_> {
    fn is_used(&self, group: usize) -> bool {
        self.rate[group].is_finite() && self.temperature[group].is_finite() && self.weight[group] > 0.0
    }

    /// Whether a group is the first of its log.
    fn begins(&self, group: usize) -> bool {
        group == 0 || self.log[group] != self.log[group - 1]
    }
}

/// What came of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct AutoFit {
    /// The static curve with its range; with a history, the one for when that is not known.
    pub drift: Drift,
    /// What it remembers of its temperatures.
    pub history: Option<History>,
    /// The recording's own drift in time.
    pub time_drift: Option<TimeDrift>,
    /// The best static cubic.
    pub static_cubic: Option<StaticCubic>,
    /// The prediction band, coldest first.
    pub band: Vec<BandPoint>,
    /// How the whole choice predicts what played no part in it.
    pub nested: HeldOut,
    /// The static curve's coefficients and covariance.
    pub solution: Solution,
    /// The models compared, simplest first, each at its best strength of ridge.
    pub candidates: Vec<Candidate>,
    /// Rate less prediction with the drift in time, a group each; NaN for one that was not used.
    pub residuals: Vec<f64>,
    /// Residual of the fit of everything.
    pub in_sample: Spread,
    /// Residual within the recording of the outer stretches; NaN where one could not be predicted.
    pub held_out: Spread,
}

/// Fits a series: `auto`, or the model asked for alone, without history and drift in time.
///
/// `measured` is the least and greatest temperature of the groups that have a rate. `auto` believes its curve an eighth
/// of that further at each end, where it was tested; another model is held at the ends.
///
/// # Errors
/// [`FitError`], when the groups do not settle the model, or no model.
pub fn fit(series: &Series<'_>, measured: ValidRange, asked: Model) -> Result<AutoFit, FitError> {
    let whole = Prepared::new(series, measured, asked).ok_or(FitError::NotFinite)?;
    let thinned = Thinned::of(series);
    let coarse_series = thinned.series();
    let coarse = Prepared::new(&coarse_series, measured, asked).ok_or(FitError::NotFinite)?;
    let used = (0..series.rate.len()).filter(|&group| series.is_used(group)).count();
    let coefficients = asked.least_coefficients();
    if used < coefficients {
        return Err(FitError::TooFewRows { rows: used as u64, coefficients });
    }
    let chosen = coarse.choose(asked, |_| true).ok_or(FitError::Undetermined { coefficients })?;
    let made = whole.fit(&chosen.spec, |_| true).ok_or(FitError::Undetermined { coefficients })?;
    let outer = nested::outer(&whole, &coarse, &thinned, asked);
    let everything = made.fitted.in_recording(series);
    let residuals: Vec<f64> = (0..series.rate.len())
        .map(|group| match series.is_used(group) {
            true => series.rate[group] - everything[group],
            false => f64::NAN,
        })
        .collect();
    let in_sample = spread(residuals.iter().copied());
    let band = band::band(series, measured, if outer.complete() { &outer.residuals } else { &residuals });
    let static_cubic = nested::static_cubic(&whole, &made, &outer);
    Ok(AutoFit {
        held_out: if outer.complete() { spread(outer.residuals.iter().copied()) } else { NO_SPREAD },
        nested: outer.figures(),
        drift: made.fitted.drift,
        history: made.fitted.history,
        time_drift: made.fitted.time_drift,
        static_cubic,
        band,
        solution: made.solution,
        candidates: chosen.candidates,
        residuals,
        in_sample,
    })
}

/// No residual.
const NO_SPREAD: Spread = Spread { rms: f64::NAN, pp: f64::NAN };

/// Root mean square and peak to peak of the finite values.
fn spread(values: impl Iterator<Item = f64>) -> Spread {
    let (mut count, mut squares, mut min, mut max) = (0_u64, 0.0, f64::INFINITY, f64::NEG_INFINITY);
    for value in values.filter(|value| value.is_finite()) {
        count += 1;
        squares += value * value;
        min = min.min(value);
        max = max.max(value);
    }
    if count == 0 { NO_SPREAD } else { Spread { rms: (squares / count as f64).sqrt(), pp: max - min } }
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
    fitted: Fitted,
    /// The best static cubic of the same groups.
    cubic: Option<Drift>,
    /// Of the static curve in `fitted`.
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
    fn choose(&self, asked: Model, keep: impl Fn(usize) -> bool) -> Option<Chosen> {
        let mut sample = Sample::new(self.series, &self.directions, keep);
        self.believe(&mut sample);
        let specs = candidates(&self.features, asked);
        let folds = Folds::new(&self.features, &sample);
        let scored = folds.score(&specs);
        // A smoothed table is settled by one temperature; a curve is not.
        if asked == Model::Auto
            && !specs.iter().zip(&scored).any(|(spec, scored)| spec.is_static(1) && scored.is_some())
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
            let pilot = Spec::new(&self.features, Model::Poly(order), &memories, time, PILOT_RIDGE);
            if sample.fit_robustly(&self.features, &pilot.penalised()).is_some() {
                return;
            }
        }
    }

    /// Fits a candidate to the groups that `keep` keeps.
    fn fit(&self, spec: &Spec, keep: impl Fn(usize) -> bool) -> Option<Made> {
        let mut sample = Sample::new(self.series, &self.directions, &keep);
        let beta = sample.fit_robustly(&self.features, &spec.penalised())?;
        let time_drift = fitted::time_drift(&self.features, spec, &beta);
        let history =
            if spec.memories.is_empty() { None } else { fitted::history(&self.features, spec, &beta, sample.mean) };
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
        let fitted = Fitted { drift, history, time_drift };
        Some(Made { fitted, cubic: cubic.map(|(drift, _)| drift), solution })
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
        let shape = fitted::curve(&self.features, spec.model, beta, sample.mean)?;
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
        let inverse = Workspace::default().inverse(&gram, &spec.penalised())?;
        // Columns of how the deployed coefficients follow from the fitted ones; a table's are its own.
        let unit = |k: usize| (0..beta.len()).map(|i| f64::from(u8::from(i == k))).collect::<Vec<f64>>();
        let (basis, change): (Basis, Vec<Vec<f64>>) = match spec.model {
            Model::Table(intervals) => (Basis::Hats(intervals), (0..beta.len()).map(unit).collect()),
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
        let rms = spread(residuals.into_iter()).rms;
        Some(Solution { scale: self.features.scale, basis, coefficients, covariance, rms, rows: rows as u64 })
    }
}

/// The candidates as they are shown: of one model the strength of ridge that did best, or the one chosen.
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
        Some(Candidate {
            model: spec.model,
            in_sample_rms: own.in_sample.sqrt(),
            held_out_rms: own.in_recording.sqrt(),
            // Of the sum of two mean squares, shared by both: a - b = (a^2 - b^2) / (a + b).
            standard_error: errors[place] / (2.0 * (own.mean().sqrt() + best.sqrt())) * std::f64::consts::SQRT_2,
            terms: spec.terms,
            further: Some(Further {
                deployed_rms: own.deployed.sqrt(),
                ends_rms: own.ends.map(f64::sqrt),
                by_direction_rms: own.by_direction.map(f64::sqrt),
                ridge: spec.ridge,
            }),
            chosen: place == chosen,
        })
    };
    shown.into_iter().filter_map(candidate).collect()
}

/// A series of fewer, longer groups.
struct Thinned {
    /// Groups of the series in one of these.
    factor: usize,
    time_s: Vec<f64>,
    temperature: Vec<f64>,
    rate: Vec<f64>,
    weight: Vec<f64>,
    log: Vec<u32>,
    drifts_in_time: bool,
}

impl Thinned {
    fn of(series: &Series<'_>) -> Self {
        let groups = series.rate.len();
        let factor = groups.div_ceil(CHOICE_GROUPS).max(1);
        let mut thinned = Self {
            factor,
            time_s: Vec::new(),
            temperature: Vec::new(),
            rate: Vec::new(),
            weight: Vec::new(),
            log: Vec::new(),
            drifts_in_time: series.drifts_in_time,
        };
        for start in (0..groups).step_by(factor) {
            let part = start..(start + factor).min(groups);
            let mean = |values: &[f64]| {
                let finite = part.clone().map(|group| values[group]).filter(|value| value.is_finite());
                let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
                sum / count
            };
            let used = part.clone().filter(|&group| series.is_used(group));
            let (sum, weight) = used.fold((0.0, 0.0), |(sum, weight), group| {
                (sum + series.weight[group] * series.rate[group], weight + series.weight[group])
            });
            thinned.time_s.push(mean(series.time_s));
            thinned.temperature.push(mean(series.temperature));
            thinned.rate.push(sum / weight);
            thinned.weight.push(weight / factor as f64);
            thinned.log.push(series.log[start]);
        }
        thinned
    }

    fn series(&self) -> Series<'_> {
        Series {
            time_s: &self.time_s,
            temperature: &self.temperature,
            rate: &self.rate,
            weight: &self.weight,
            log: &self.log,
            drifts_in_time: self.drifts_in_time,
        }
    }
}

#[cfg(test)]
mod tests;
