#![doc = include_str!("../README.md")]

mod hysteresis;
mod ramp;
mod sensitivity;
mod soak;
mod spikes;

use serde::{Serialize, Serializer};
use zerorate_cal::units::{RateScale, WrittenRate};

use zerorate_fit::allan::{Allan, AllanPoint, NoAllan};
use zerorate_fit::direction::warming;
use zerorate_fit::intervals::ends;
use zerorate_fit::robust::median;

pub use hysteresis::Hysteresis;
pub use ramp::RampSensitivity;
pub use sensitivity::{TemperatureSensitivity, is_of_a_soak};
pub use soak::{AxisNoise, NoiseError, NoiseOf, noise};
use zerorate_cal::log_fit::AxisFit;
use zerorate_fit::trace::TracePoint;

/// What a fitted log says of one axis. Rates and temperatures are in the log's units.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Characteristics {
    /// How the bias changes with temperature.
    pub temperature_sensitivity: TemperatureSensitivity,
    /// Heating less cooling at equal temperature.
    #[serde(serialize_with = "or_reason")]
    pub hysteresis: Result<Hysteresis, String>,
    /// What the curve leaves in proportion to the speed of the temperature.
    #[serde(serialize_with = "or_reason")]
    pub ramp_sensitivity: Result<RampSensitivity, String>,
    /// The noise of the residual, over averaging times from the spacing of the averages on.
    #[serde(serialize_with = "or_reason")]
    pub residual_noise: Result<ResidualNoise, String>,
}

/// The Allan deviation of what a model leaves of the averages it was fitted to. The fit has taken a part of the noise with it, so N, B
/// and K are not read here: [`noise`] does so, of the log's rows.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ResidualNoise {
    /// Time between averages, seconds.
    pub period_s: f64,
    /// Averages that were fitted.
    pub samples: u64,
    /// The curve, shortest averaging time first.
    pub points: Vec<AllanPoint>,
}

impl From<Allan> for ResidualNoise {
    fn from(Allan { period_s, samples, points, .. }: Allan) -> Self {
        Self { period_s, samples, points }
    }
}

/// What was found, or why nothing was: `{"none": "the log holds one direction alone"}`.
fn or_reason<T: Serialize, S: Serializer>(found: &Result<T, String>, to: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Nothing<'a> {
        none: &'a str,
    }
    match found {
        Ok(found) => found.serialize(to),
        Err(none) => Nothing { none }.serialize(to),
    }
}

impl Characteristics {
    /// Of one fitted axis; sentences tell rates in the unit that is asked for, if any is.
    #[must_use]
    pub fn of(axis: &AxisFit, asked: Option<WrittenRate>) -> Self {
        let points: Vec<TracePoint> = axis
            .trace
            .iter()
            .copied()
            .filter(|point| point.temperature.is_finite() && point.rate.is_finite())
            .collect();
        let temperatures: Vec<f64> = points.iter().map(|point| point.temperature).collect();
        let warming = warming(&temperatures);
        let left = less_drift_in_time(axis, &points);
        Self {
            temperature_sensitivity: TemperatureSensitivity::of(axis),
            hysteresis: Hysteresis::of(axis, &points, &warming, &left, asked),
            ramp_sensitivity: RampSensitivity::of(&level(&of_curve(&points, &left)), &warming),
            residual_noise: residual_noise(&level(&points)).map(Into::into).map_err(|error| error.to_string()),
        }
    }
}

/// What the curve leaves of the rates less the log's own drift in time: what the model leaves, and what it says that the
/// drift remembers.
fn less_drift_in_time(axis: &AxisFit, points: &[TracePoint]) -> Vec<f64> {
    let biases = axis.calibration.fit.model.biases(points.iter().map(|point| (point.time_s, point.temperature)));
    let curve = axis.calibration.drift();
    let left = |(point, bias): (&TracePoint, f64)| point.residual + bias - curve.evaluate(point.temperature).0;
    points.iter().zip(biases).map(left).collect()
}

/// The points with what the curve alone leaves in place of their residuals: a model that remembers takes a part that goes with
/// the temperature's speed for a lag.
fn of_curve(points: &[TracePoint], left: &[f64]) -> Vec<TracePoint> {
    points.iter().zip(left).map(|(point, residual)| TracePoint { residual: *residual, ..*point }).collect()
}

/// The residuals of several logs about each one's own mean: that they jump from one to the next is neither noise nor a ramp's.
fn level(points: &[TracePoint]) -> Vec<TracePoint> {
    let log = |log: &[TracePoint]| {
        let mean = log.iter().map(|point| point.residual).sum::<f64>() / log.len() as f64;
        log.iter().map(|point| TracePoint { residual: point.residual - mean, ..*point }).collect::<Vec<_>>()
    };
    points.chunk_by(|a, b| a.log == b.log).flat_map(log).collect()
}

/// What the log does not hold, and why, a sentence each: `x, y: thermal hysteresis cannot be told: the log holds one direction ...`.
fn missing<'a>(axes: impl IntoIterator<Item = (&'a str, &'a Characteristics)>) -> Vec<String> {
    together(axes.into_iter().flat_map(|(name, found)| {
        let [hysteresis, ramp] = [found.hysteresis.as_ref().err(), found.ramp_sensitivity.as_ref().err()];
        let of_each = [("thermal hysteresis", hysteresis), ("ramp sensitivity", ramp)].into_iter();
        of_each.filter_map(move |(what, why)| Some((name, format!("{what} cannot be told: {}", why?))))
    }))
}

/// What is to be told of axes, once for all of which it is the same.
fn together<'a>(told: impl IntoIterator<Item = (&'a str, String)>) -> Vec<String> {
    let mut sentences: Vec<(String, Vec<&str>)> = Vec::new();
    for (name, sentence) in told {
        match sentences.iter_mut().find(|(told, _)| *told == sentence) {
            Some((_, names)) => names.push(name),
            None => sentences.push((sentence, vec![name])),
        }
    }
    sentences.into_iter().map(|(sentence, names)| format!("{}: {sentence}", names.join(", "))).collect()
}

/// Where an Allan curve is a filter's at its short end, a sentence for all axes of one averaging time.
fn filtered<'a>(axes: impl IntoIterator<Item = (&'a str, &'a Allan)>) -> Vec<String> {
    together(axes.into_iter().filter_map(|(name, allan)| {
        let sentence = format!(
            "at averaging times below {:.1} s samples resemble their neighbours, as behind a filter; N, B and K are read from there on",
            allan.filtered_below_s?
        );
        Some((name, sentence))
    }))
}

/// How many samples were left out of each axis's noise, a sentence for all axes of as many.
fn left_out(axes: &[AxisNoise]) -> Vec<String> {
    together(axes.iter().filter(|axis| axis.left_out > 0).map(|axis| {
        let of = match axis.left_out {
            1 => "1 row was left out, its rate far from its neighbours".to_owned(),
            rows => format!("{rows} rows were left out, their rate far from their neighbours"),
        };
        (axis.name.as_str(), of)
    }))
}

/// Of noise that is not larger than so much of a converter's step the converter makes another: what is found of 0.6 steps is a
/// tenth too large, and of a tenth of one three times too large or too small.
const LEAST_OF_STEP: f64 = 0.66;

/// Where rates come in steps as large as their noise, a sentence for all axes.
fn coarse(axes: &[AxisNoise]) -> Vec<String> {
    together(axes.iter().filter_map(|axis| {
        let allan = axis.noise.as_ref().ok()?;
        let of_a_row = allan.coefficients.angle_random_walk.value()? / allan.period_s.sqrt();
        let sentence = || {
            format!(
                "the rate comes in steps of {}, as large as its noise: N, B and K are the converter's as well, and N may be several times \
                 too large or too small",
                RateScale::of(axis.rate_unit, &[axis.step], None).told(axis.step)
            )
        };
        (axis.step.is_finite() && of_a_row < LEAST_OF_STEP * axis.step).then(|| (axis.name.as_str(), sentence()))
    }))
}

/// What is to be known of some axes' noise, a sentence each, and why an axis has none.
#[must_use]
pub fn told_of_noise(axes: &[AxisNoise]) -> Vec<String> {
    let allans = axes.iter().filter_map(|axis| Some((axis.name.as_str(), axis.noise.as_ref().ok()?)));
    let told = filtered(allans.clone()).into_iter().chain(trended(allans)).chain(left_out(axes)).chain(coarse(axes));
    let mut reasons: Vec<&str> = Vec::new();
    let none = axes.iter().filter_map(|axis| {
        let why = axis.noise.as_ref().err()?;
        let is_new = !reasons.contains(&why.as_str());
        reasons.push(why);
        is_new.then(|| format!("{}: {why}", axis.name))
    });
    told.chain(none).collect()
}

/// What is to be known of some axes' sensitivities, a sentence each.
pub fn told_of_sensitivities<'a>(
    axes: impl IntoIterator<Item = (&'a AxisFit, &'a Characteristics)> + Clone,
    asked: Option<WrittenRate>,
) -> Vec<String> {
    let missing = missing(axes.clone().into_iter().map(|(axis, found)| (axis.name.as_str(), found)));
    doubtful(axes, asked).into_iter().chain(missing).collect()
}

/// Where an Allan curve rises by a smooth trend, a sentence for all axes.
fn trended<'a>(axes: impl IntoIterator<Item = (&'a str, &'a Allan)>) -> Vec<String> {
    let told = axes.into_iter().filter(|(_, allan)| allan.smooth_trend);
    together(told.map(|(name, _)| {
        let sentence = "the rate has a smooth trend in time or with the temperature, as while a gyro warms up; B and K are of what it \
                        leaves, and < where that shows none";
        (name, sentence.to_owned())
    }))
}

/// Where hysteresis may be a drift in time, a sentence each; and of one cycle in any case.
fn doubtful<'a>(
    axes: impl IntoIterator<Item = (&'a AxisFit, &'a Characteristics)>,
    asked: Option<WrittenRate>,
) -> Vec<String> {
    let doubt = |(axis, found): (&'a AxisFit, &Characteristics)| {
        let Hysteresis { mean, less_drift_in_time, one_cycle, .. } = *found.hysteresis.as_ref().ok()?;
        let sentence = match less_drift_in_time {
            Some(less) => {
                let scale = RateScale::of(axis.calibration.rate_unit, &[mean, less], asked);
                format!(
                    "heating less cooling is {} on average as recorded, and {} with the drift in time that the fit found taken off: {}",
                    scale.told(mean),
                    scale.number(less),
                    if one_cycle { ONE_CYCLE } else { "the difference of the two is what the fit took for that drift" }
                )
            }
            None if one_cycle => format!("thermal hysteresis is of one cycle: {ONE_CYCLE}"),
            None => return None,
        };
        Some((axis.name.as_str(), sentence))
    };
    together(axes.into_iter().filter_map(doubt))
}

const ONE_CYCLE: &str = "one cycle does not tell it from a drift in time, several do";

/// The least and the greatest temperature.
fn span(points: &[TracePoint]) -> (f64, f64) {
    ends(points.iter().map(|point| point.temperature))
}

/// The Allan deviation of the residual, on an even grid of time in which what was left out is a gap.
// Places on a grid of some thousands.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn residual_noise(points: &[TracePoint]) -> Result<Allan, NoAllan> {
    let mut steps: Vec<f64> = points.windows(2).map(|pair| pair[1].time_s - pair[0].time_s).collect();
    let period_s = median(&mut steps);
    if !(period_s.is_finite() && period_s > 0.0) {
        return Err(NoAllan::NoPeriod { period_s });
    }
    let first_s = points[0].time_s;
    let place = |point: &TracePoint| ((point.time_s - first_s) / period_s).round().max(0.0) as usize;
    // A log with hours of gaps has no more places than points, times a few.
    let most = 8 * points.len();
    let mut even = Vec::new();
    for point in points {
        let place = place(point);
        if place < most {
            even.resize(even.len().max(place + 1), f64::NAN);
            even[place] = point.residual;
        }
    }
    Allan::of(&even, period_s)
}

#[cfg(test)]
mod tests;
